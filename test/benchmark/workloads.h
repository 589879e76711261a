#pragma once

#include <cmath>
#include <vector>

#include "support/meshes.h"
#include "support/random_contact_cases.h"

/// The workloads that we and the peers are measured on, so that all of them are asked the same questions.
namespace ellipsoid_vehicle_sim::test {

/// Semi-axes of the wheel [m]; its axle is y.
inline Eigen::Vector3d benchmarkWheel() { return {0.35, 0.12, 0.35}; }

enum class ContactKind { kNearMiss, kMissBeside, kFace, kEdge, kVertex };

/// The wheel steered and leaning a little over a triangle that lies nearly level, edges of about 1 m, depths of 0.1 to
/// 50 mm.
inline ContactCase wheelCase(ContactKind kind, RandomContactCases& random) {
  const Eigen::Matrix3d tilt = Eigen::AngleAxisd(random.uniform(-0.3, 0.3), random.unitVector()).toRotationMatrix();
  const Triangle triangle = makeTriangle(tilt * Eigen::Vector3d(0.0, 0.0, 0.0), tilt * Eigen::Vector3d(1.1, 0.1, 0.0),
                                         tilt * Eigen::Vector3d(0.3, 0.9, 0.0));
  const auto& v = triangle.v;
  const Eigen::Vector3d& n = triangle.nhat_W;
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(random.uniform(-3.1, 3.1), Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(random.uniform(-0.1, 0.1), Eigen::Vector3d::UnitX()) *
                             Eigen::AngleAxisd(random.uniform(-3.1, 3.1), Eigen::Vector3d::UnitY()))
                                .toRotationMatrix();
  const double depth = random.logUniform(1e-4, 0.05);
  const auto k = static_cast<std::size_t>(random.index(3));
  const Eigen::Vector3d e = (v[(k + 1) % 3] - v[k]).normalized(), m = e.cross(n);
  const Eigen::Vector3d inside = 0.4 * v[0] + 0.3 * v[1] + 0.3 * v[2];
  const Eigen::Vector3d on_edge = v[k] + random.uniform(0.2, 0.8) * (v[(k + 1) % 3] - v[k]);
  const Eigen::Vector3d outwards = (2.0 * v[k] - v[(k + 1) % 3] - v[(k + 2) % 3]).normalized();
  const Eigen::Vector3d r = benchmarkWheel();
  const double angle = random.uniform(0.05, 1.2);
  const Eigen::Vector3d u_edge = std::cos(angle) * n + std::sin(angle) * m;
  const Eigen::Vector3d u_vertex = (n + random.uniform(0.05, 2.0) * outwards).normalized();
  const auto placed = RandomContactCases::placed;
  switch (kind) {
    case ContactKind::kNearMiss:
      return {placed(R, r, inside, n, -depth), triangle};
    case ContactKind::kMissBeside:
      return {placed(R, r, on_edge, u_edge, -depth), triangle};
    case ContactKind::kFace:
      return {placed(R, r, inside, n, depth), triangle};
    case ContactKind::kEdge:
      return {placed(R, r, on_edge, u_edge, depth), triangle};
    default:
      return {placed(R, r, v[k], u_vertex, depth), triangle};
  }
}

inline bool isOf(ContactKind kind, const TriangleContact& contact, const ContactCase& c) {
  switch (kind) {
    case ContactKind::kNearMiss:
      return !contact;
    case ContactKind::kMissBeside:  // the plane is reached, the triangle is not.
      return !contact && c.ellipsoid.halfWidth(c.triangle.nhat_W) >
                             c.triangle.nhat_W.dot(c.ellipsoid.p_WE - c.triangle.v[0]) + 1e-4;
    case ContactKind::kFace:
      return contact.feature == Feature::kFace;
    case ContactKind::kEdge:
      return contact.feature >= Feature::kEdge0 && contact.feature <= Feature::kEdge2;
    default:
      return contact.feature >= Feature::kVertex0;
  }
}

/// A power of two of cases of one kind: enough that the branch predictor learns no single one.
inline std::vector<ContactCase> wheelCases(ContactKind kind, std::size_t count = 64) {
  RandomContactCases random(7);
  std::vector<ContactCase> cases;
  while (cases.size() < count) {
    const ContactCase c = wheelCase(kind, random);
    if (isOf(kind, minimumTranslation(c.ellipsoid, c.triangle), c)) cases.push_back(c);
  }
  return cases;
}

constexpr std::pair<const char*, ContactKind> kContactFigures[] = {{"near_miss", ContactKind::kNearMiss},
                                                                   {"face", ContactKind::kFace},
                                                                   {"edge", ContactKind::kEdge},
                                                                   {"vertex", ContactKind::kVertex}};

/// Height of the hills [m]: a sum of sines to 0.5 m.
inline double hillHeight(double x, double y) {
  return 0.2 * std::sin(0.21 * x) + 0.15 * std::sin(0.33 * y + 1.0) + 0.1 * std::sin(0.5 * x + 0.3 * y) +
         0.05 * std::sin(0.8 * x - 0.6 * y);
}

/// Cells per side of the hills with 199,712 and with two million triangles.
constexpr int kHillCells = 316, kManyHillCells = 1000;

/// n x n cells of 1 m around the origin, 2 n^2 triangles; n even, so that worlds of all sizes are the same near the
/// origin.
inline TriangleSoup hills(int n) {
  const double half = 0.5 * n;
  return gridSoup(n, 1.0, [half](double x, double y) { return hillHeight(x - half, y - half); }, {-half, -half, 0.0});
}

/// A wheel that stands in the hills, about a centimetre deep.
inline PosedEllipsoid wheelOnHills(double x, double y) {
  return {{x, y, hillHeight(x, y) + 0.34}, Eigen::Matrix3d::Identity(), benchmarkWheel()};
}

/// Where the wheel is asked for: every millisecond of a drive at 10 m/s along x, lane by lane.
class DrivingPath {
 public:
  explicit DrivingPath(int cells) : limit_(0.5 * cells - 2.0), x_(-limit_), y_(-limit_) {}
  PosedEllipsoid next() {
    x_ += 0.01;
    if (x_ > limit_) {
      x_ = -limit_;
      y_ = y_ + 7.3 > limit_ ? -limit_ : y_ + 7.3;
    }
    return wheelOnHills(x_, y_);
  }

 private:
  double limit_, x_, y_;
};

/// The same anywhere in the world: nothing is near in memory.
inline std::vector<PosedEllipsoid> coldPlaces(int cells) {
  RandomContactCases random(7);
  const double limit = 0.5 * cells - 2.0;
  std::vector<PosedEllipsoid> places;
  for (int i = 0; i < 65536; ++i) {
    const double x = random.uniform(-limit, limit);
    places.push_back(wheelOnHills(x, random.uniform(-limit, limit)));
  }
  return places;
}

/// The box a wheel is looked for with [m].
inline Eigen::AlignedBox3d boxOf(const PosedEllipsoid& e) {
  const Eigen::Vector3d half = e.halfBox();
  return {e.p_WE - half, e.p_WE + half};
}

/// W1 *drop*: one 1000 kg body of a chassis and four wheels, from 1 m onto 20 x 20 flat cells of 1 m, 5 s at 1 kHz.
namespace drop {
constexpr int kCells = 20;
constexpr double kMass = 1000.0, kSeconds = 5.0, kTick = 1e-3, kStartHeight = 1.75;
inline Eigen::Vector3d chassis() { return {2.0, 0.8, 0.5}; }
inline std::vector<Eigen::Vector3d> wheels() {
  return {{-1.3, -0.75, -0.4}, {-1.3, 0.75, -0.4}, {1.3, -0.75, -0.4}, {1.3, 0.75, -0.4}};
}
}  // namespace drop

/// W2 *drive*: a 1200 kg car with suspension, steering and wheel spin, friction 1, 15 m/s for 20 s on a circle.
namespace ride {
constexpr double kTick = 1e-3, kSeconds = 20.0, kRunUp = 6.0, kSpeed = 15.0, kCircle = 60.0;
constexpr double kMass = 1200.0, kWheelMass = 20.0, kSpring = 25e3, kDamper = 2e3;
constexpr double kAxle = 1.3, kHalfTrack = 0.75, kWheelRadius = 0.35;
/// The peers' cars have no Ackermann geometry: both front wheels take the angle of the middle [rad].
inline double steeringAngle() { return std::atan(2.0 * kAxle / kCircle); }
}  // namespace ride

}  // namespace ellipsoid_vehicle_sim::test
