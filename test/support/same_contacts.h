#pragma once

#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/contact/contact.h"

namespace ellipsoid_vehicle_sim::test {

/// All that contacts are, to the last bit.
inline void expectSameBits(const EllipsoidContacts& a, const EllipsoidContacts& b) {
  ASSERT_EQ(a.count, b.count);
  for (int i = 0; i < a.count; ++i) {
    const Contact &x = a.contact[static_cast<std::size_t>(i)], &y = b.contact[static_cast<std::size_t>(i)];
    ASSERT_EQ(x.triangle, y.triangle);
    ASSERT_EQ(x.nhat_W, y.nhat_W);
    ASSERT_EQ(x.p_WE_lowest, y.p_WE_lowest);
    ASSERT_EQ(x.depth, y.depth);
    ASSERT_EQ(x.pressed, y.pressed);
    ASSERT_EQ(x.share, y.share);
  }
}

}  // namespace ellipsoid_vehicle_sim::test
