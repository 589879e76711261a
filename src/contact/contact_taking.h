#pragma once

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"

namespace ellipsoid_vehicle_sim {

// What a contact's past decides: whether its triangle may push, and how much of its depth is felt. Part of the inside
// of find_contacts.cpp.

// Depths that differ by less are the same push seen from two poses [m]; a nanometre is far below any contact's sag.
constexpr double kSameDepth = 1e-9;
// Rounding allowance when a depth is compared with its explanation [m].
constexpr double kExplained = 1e-12;
// h(u) changes by at most this times r_max per radian of turn when the axes' ratio is unbounded; [ContactDefinition] 6.
constexpr double kTurnReach = 1.12;

inline TriangleContact meet(const PosedEllipsoid& ellipsoid, const Triangle& triangle, ContactRule rule,
                            double floor_depth) {
  if (rule == ContactRule::kMinimumTranslation) return minimumTranslation(ellipsoid, triangle, floor_depth);
  const TriangleContact contact = clampedPoint(ellipsoid, triangle);
  return contact.depth > floor_depth ? contact : TriangleContact{};
}

inline PosedEllipsoid moved(const PosedEllipsoid& ellipsoid, const Eigen::Vector3d& push) {
  PosedEllipsoid result = ellipsoid;
  result.p_WE += push;
  return result;
}

inline bool centreInFront(const PosedEllipsoid& ellipsoid, const Triangle& triangle) {
  return triangle.nhat_W.dot(ellipsoid.p_WE - triangle.v[0]) > 0.0;
}

// W(u): how far the supporting plane along the fixed u has moved in since the remembered pose; half_width is h0(u)
// there.
inline double advance(const PosedEllipsoid& ellipsoid, const ContactMemory& memory, const Eigen::Vector3d& u,
                      double half_width) {
  return u.dot(memory.posed.p_WE - ellipsoid.p_WE) - half_width + ellipsoid.halfWidth(u);
}

// Angle between the remembered and the present axes [rad].
inline double angleTurned(const Eigen::Matrix3d& R0, const Eigen::Matrix3d& R1) {
  // |R0 - R1|_F = 2 sqrt(2) sin(angle / 2): keeps its digits for small angles, where the trace loses them.
  return 2.0 * std::asin(std::min(1.0, (R0 - R1).norm() / (2.0 * std::sqrt(2.0))));
}

/// How one ellipsoid takes the contacts that are found for it.
class ContactTaking {
 public:
  ContactTaking(const PosedEllipsoid& ellipsoid, const ContactMemory& memory, const ContactOptions& options)
      : ellipsoid_(ellipsoid), memory_(memory), options_(options) {}

  void take(EllipsoidContacts& result, int triangle, const Eigen::Vector3d& u, const Eigen::Vector3d& lowest,
            double depth, double felt) const {
    Contact& contact = result.contact[result.count++];
    contact.triangle = triangle;
    contact.nhat_W = u;
    contact.p_WE_lowest = lowest;
    contact.depth = depth;
    contact.pressed = std::max(0.0, felt - (options_.memory ? memory_.slack : 0.0));
    contact.share = 1.0;
  }

  void take(EllipsoidContacts& result, int triangle, const TriangleContact& contact, double felt) const {
    take(result, triangle, contact.nhat_W, contact.p_WE_lowest, contact.depth, felt);
  }

  // May this triangle push? It must have been known, or have had the centre in front and been no deeper than the
  // others.
  bool admitted(const Candidate& candidate) const {
    return !options_.memory || memory_.fresh || carried(candidate.index) || wasInFront(candidate);
  }

  // The part of a contact's depth that motion since the remembered pose explains; the rest is a jump.
  double feltDepth(const TriangleContact& contact, const Candidate& candidate) const {
    if (!options_.memory || memory_.fresh) return contact.depth;
    const double depth = contact.depth;

    double reached = -1.0, base_depth = 0.0, base_advance = 0.0;
    const auto explain = [&](double delta, double advanced) {
      if (delta + advanced <= reached) return;
      reached = delta + advanced;
      base_depth = delta;
      base_advance = advanced;
    };
    for (int i = 0; i < memory_.count; ++i) {
      const CarriedContact& base = memory_.carried[i];
      explain(base.depth, advance(ellipsoid_, memory_, base.nhat_W, base.half_width));
    }
    if (depth <= reached + kExplained) return depth;

    // Only now the triangle's own past is worked out: it is needed once in many steps.
    const TriangleContact before = meet(memory_.posed, candidate.triangle, options_.rule, 0.0);
    double bound = reached;
    if (before) {
      explain(before.depth, advance(ellipsoid_, memory_, before.nhat_W, memory_.posed.halfWidth(before.nhat_W)));
      bound = reached;
    } else {
      const double travel = (ellipsoid_.p_WE - memory_.posed.p_WE).norm();
      const double turn = angleTurned(memory_.posed.R_WE, ellipsoid_.R_WE);
      bound = std::max(reached, travel + kTurnReach * turn * ellipsoid_.radii.maxCoeff());
    }
    if (depth <= bound + kExplained) return depth;

    const double along = advance(ellipsoid_, memory_, contact.nhat_W, memory_.posed.halfWidth(contact.nhat_W));
    if (memory_.count == 0 && !before) return std::min(depth, std::max(0.0, along));
    return std::min(depth, std::max(0.0, base_depth + std::min(base_advance, along)));
  }

 private:
  /// Asked of new triangles only, once in many steps: not among what every query runs through.
  __attribute__((noinline)) bool wasInFront(const Candidate& candidate) const {
    const Triangle& triangle = candidate.triangle;
    if (!centreInFront(memory_.posed, triangle)) return false;
    const TriangleContact before = meet(memory_.posed, triangle, options_.rule, 0.0);
    if (!before) return true;
    if (options_.contacts == ContactsPerEllipsoid::kOne || memory_.count == kMaxContactsPerEllipsoid)
      return before.depth <= memory_.deepest + kSameDepth;
    return meet(moved(memory_.posed, memory_.push), triangle, options_.rule, 0.0).depth <= kSameDepth;
  }

  bool carried(int triangle) const {
    for (int i = 0; i < memory_.count; ++i)
      if (memory_.carried[i].triangle == triangle) return true;
    return false;
  }

  const PosedEllipsoid& ellipsoid_;
  const ContactMemory& memory_;
  const ContactOptions& options_;
};

}  // namespace ellipsoid_vehicle_sim
