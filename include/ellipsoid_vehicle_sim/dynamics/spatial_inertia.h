#pragma once

#include <Eigen/Core>

namespace ellipsoid_vehicle_sim {

/// A vector of motion or force, taken at the base's origin O, axes of W.
struct Spatial {
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< turning, or moment about O.
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< of the point at O, or force.
};

inline double dot(const Spatial& motion, const Spatial& force) {
  return motion.angular.dot(force.angular) + motion.linear.dot(force.linear);
}

/// Rigid or articulated inertia at O: moment = J a + H l, force = H' a + M l for an acceleration (a, l). J and M are
/// symmetric: 21 numbers, packed, because adding these up is most of what the dynamics does.
class SpatialInertia {
 public:
  /// A rigid body of mass m with its centre of mass at c and inertia I_cm about it, axes of W.
  void setRigid(double m, const Eigen::Vector3d& c, const Eigen::Matrix3d& I_cm) {
    const double x = c.x(), y = c.y(), z = c.z();
    j_[kXX] = I_cm(0, 0) + m * (y * y + z * z);
    j_[kYY] = I_cm(1, 1) + m * (x * x + z * z);
    j_[kZZ] = I_cm(2, 2) + m * (x * x + y * y);
    j_[kXY] = I_cm(0, 1) - m * x * y;
    j_[kXZ] = I_cm(0, 2) - m * x * z;
    j_[kYZ] = I_cm(1, 2) - m * y * z;
    // H = m [c]x, row by row.
    h_[0] = h_[4] = h_[8] = 0.0;
    h_[1] = -m * z;
    h_[2] = m * y;
    h_[3] = m * z;
    h_[5] = -m * x;
    h_[6] = -m * y;
    h_[7] = m * x;
    m_[kXX] = m_[kYY] = m_[kZZ] = m;
    m_[kXY] = m_[kXZ] = m_[kYZ] = 0.0;
  }

  void add(const SpatialInertia& other) {
    for (int i = 0; i < 6; ++i) j_[i] += other.j_[i];
    for (int i = 0; i < 9; ++i) h_[i] += other.h_[i];
    for (int i = 0; i < 6; ++i) m_[i] += other.m_[i];
  }

  /// this += other - U U' / D: what remains of an inertia when the motion whose force is U and own inertia D is free.
  void addWithout(const SpatialInertia& other, const Spatial& U, double inverse_D) {
    const double a0 = U.angular.x(), a1 = U.angular.y(), a2 = U.angular.z();
    const double l0 = U.linear.x(), l1 = U.linear.y(), l2 = U.linear.z();
    const double b0 = inverse_D * a0, b1 = inverse_D * a1, b2 = inverse_D * a2;
    const double k0 = inverse_D * l0, k1 = inverse_D * l1, k2 = inverse_D * l2;
    j_[kXX] += other.j_[kXX] - b0 * a0;
    j_[kYY] += other.j_[kYY] - b1 * a1;
    j_[kZZ] += other.j_[kZZ] - b2 * a2;
    j_[kXY] += other.j_[kXY] - b0 * a1;
    j_[kXZ] += other.j_[kXZ] - b0 * a2;
    j_[kYZ] += other.j_[kYZ] - b1 * a2;
    h_[0] += other.h_[0] - b0 * l0;
    h_[1] += other.h_[1] - b0 * l1;
    h_[2] += other.h_[2] - b0 * l2;
    h_[3] += other.h_[3] - b1 * l0;
    h_[4] += other.h_[4] - b1 * l1;
    h_[5] += other.h_[5] - b1 * l2;
    h_[6] += other.h_[6] - b2 * l0;
    h_[7] += other.h_[7] - b2 * l1;
    h_[8] += other.h_[8] - b2 * l2;
    m_[kXX] += other.m_[kXX] - k0 * l0;
    m_[kYY] += other.m_[kYY] - k1 * l1;
    m_[kZZ] += other.m_[kZZ] - k2 * l2;
    m_[kXY] += other.m_[kXY] - k0 * l1;
    m_[kXZ] += other.m_[kXZ] - k0 * l2;
    m_[kYZ] += other.m_[kYZ] - k1 * l2;
  }

  /// The same where that motion is a turn about the unit axis k through the centre of mass, of inertia `along`.
  void addWithoutTurning(const SpatialInertia& other, const Eigen::Vector3d& k, double along) {
    add(other);
    const Eigen::Vector3d s = along * k;
    j_[kXX] -= s.x() * k.x();
    j_[kYY] -= s.y() * k.y();
    j_[kZZ] -= s.z() * k.z();
    j_[kXY] -= s.x() * k.y();
    j_[kXZ] -= s.x() * k.z();
    j_[kYZ] -= s.y() * k.z();
  }

  /// Force for an acceleration that is only linear.
  Spatial timesLinear(const Eigen::Vector3d& l) const {
    return {{h_[0] * l.x() + h_[1] * l.y() + h_[2] * l.z(), h_[3] * l.x() + h_[4] * l.y() + h_[5] * l.z(),
             h_[6] * l.x() + h_[7] * l.y() + h_[8] * l.z()},
            symmetric(m_, l)};
  }

  Spatial operator*(const Spatial& acceleration) const {
    const Eigen::Vector3d& a = acceleration.angular;
    Spatial force = timesLinear(acceleration.linear);
    force.angular += symmetric(j_, a);
    force.linear += Eigen::Vector3d(h_[0] * a.x() + h_[3] * a.y() + h_[6] * a.z(), h_[1] * a.x() + h_[4] * a.y() + h_[7] * a.z(),
                                    h_[2] * a.x() + h_[5] * a.y() + h_[8] * a.z());
    return force;
  }

  Eigen::Matrix3d J() const { return full(j_); }
  Eigen::Matrix3d M() const { return full(m_); }
  Eigen::Matrix3d H() const {
    Eigen::Matrix3d h;
    h << h_[0], h_[1], h_[2], h_[3], h_[4], h_[5], h_[6], h_[7], h_[8];
    return h;
  }

 private:
  enum { kXX, kYY, kZZ, kXY, kXZ, kYZ };

  static Eigen::Vector3d symmetric(const double (&s)[6], const Eigen::Vector3d& v) {
    return {s[kXX] * v.x() + s[kXY] * v.y() + s[kXZ] * v.z(), s[kXY] * v.x() + s[kYY] * v.y() + s[kYZ] * v.z(),
            s[kXZ] * v.x() + s[kYZ] * v.y() + s[kZZ] * v.z()};
  }
  static Eigen::Matrix3d full(const double (&s)[6]) {
    Eigen::Matrix3d m;
    m << s[kXX], s[kXY], s[kXZ], s[kXY], s[kYY], s[kYZ], s[kXZ], s[kYZ], s[kZZ];
    return m;
  }

  double j_[6], h_[9], m_[6];
};

}  // namespace ellipsoid_vehicle_sim
