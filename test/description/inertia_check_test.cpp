#include "ellipsoid_vehicle_sim/description/inertia_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d turned(const Vector3d& moments) {
  const Matrix3d R = Eigen::Quaterniond(0.5, -0.5, 0.1, 0.7).normalized().toRotationMatrix();
  return R * moments.asDiagonal() * R.transpose();
}

TEST(InertiaCheck, AcceptsWhatBodiesHave) {
  EXPECT_EQ(inertiaFault(Vector3d(1, 1, 1).asDiagonal()), "");
  EXPECT_EQ(inertiaFault(turned({0.002, 0.03, 0.031})), "");
}

TEST(InertiaCheck, AcceptsAFlatPlateToTheRoundingOfFiles) {
  // A plate's moments add up exactly: m b^2/12 + m a^2/12 = m (a^2 + b^2)/12. Six digits miss that by up to 1e-6.
  EXPECT_EQ(inertiaFault(Vector3d(0.333333, 0.333333, 0.666667 - 0.0000005).asDiagonal()), "");
  EXPECT_EQ(inertiaFault(turned({1.0, 2.0, 3.0})), "");
}

TEST(InertiaCheck, RefusesMoreThanTheSumOfTheOthersWithTheValues) {
  const std::string fault = inertiaFault(Vector3d(1, 1, 2.1).asDiagonal());
  EXPECT_NE(fault.find("1, 1, 2.1"), std::string::npos) << fault;
  EXPECT_NE(fault.find("the sum of the others, 2"), std::string::npos) << fault;
  EXPECT_NE(inertiaFault(turned({1.0, 2.0, 3.1})), "");
}

TEST(InertiaCheck, RefusesZeroNegativeAndIndefinite) {
  EXPECT_NE(inertiaFault(Matrix3d::Zero()).find("ixx reads 0"), std::string::npos);
  EXPECT_NE(inertiaFault(Vector3d(1, -2, 1).asDiagonal()).find("iyy reads -2"), std::string::npos);
  Matrix3d indefinite = Matrix3d::Identity();
  indefinite(0, 1) = indefinite(1, 0) = 2.0;  // moments -1, 1, 3
  EXPECT_NE(inertiaFault(indefinite).find("-1, 1, 3"), std::string::npos);
}

TEST(InertiaCheck, RefusesWhatIsNotFinite) {
  Matrix3d I = Matrix3d::Identity();
  I(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(inertiaFault(I).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
