#include "broad_phase.h"

#include <algorithm>
#include <tuple>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// Share of the speed at the tick's start that a way may be longer by, and what no speed accounts for: a push of fifty
// times gravity, and a millimetre. What moves further is met in the next tick, as deep as it is then.
constexpr double kFaster = 1.5;
constexpr double kPush = 500.0;   // [m/s^2]
constexpr double kMargin = 1e-3;  // [m]

}  // namespace

void BroadPhase::reserve(std::size_t members) {
  order_.reserve(members);
  pairs_.reserve(64 * members);
}

void BroadPhase::sweep(FleetMember& member, double dt) const {
  Simulator::Impl& s = *member.simulator->impl_;
  s.dynamics->poseAt(s.state);
  const std::vector<PosedEllipsoid>& posed = s.dynamics->posedEllipsoids();
  member.box.setEmpty();
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const int ellipsoid = static_cast<int>(i);
    const Vector3d way = kFaster * dt * s.dynamics->centreVelocity(s.state.motion, ellipsoid);
    const double largest = posed[i].radii.maxCoeff();
    const double turn = kFaster * dt * s.dynamics->turning(ellipsoid).norm() * (largest - posed[i].radii.minCoeff());
    const Vector3d grown = posed[i].halfBox().array() + turn;
    const Vector3d half = grown.cwiseMin(largest).array() + (kPush * dt * dt + kMargin);
    AlignedBox3d& box = member.boxes[i];
    box = AlignedBox3d(Vector3d(posed[i].p_WE - half), Vector3d(posed[i].p_WE + half));
    box.extend(Vector3d(box.min() + way.cwiseMin(0.0)));
    box.extend(Vector3d(box.max() + way.cwiseMax(0.0)));
    member.box.extend(box);
  }
}

void BroadPhase::addPairs(const std::vector<FleetMember>& members, int a, int b) {
  const auto &first = members[static_cast<std::size_t>(a)], &second = members[static_cast<std::size_t>(b)];
  for (std::size_t i = 0; i < first.boxes.size(); ++i) {
    if (!first.boxes[i].intersects(second.box)) continue;
    for (std::size_t j = 0; j < second.boxes.size(); ++j) {
      if (!first.boxes[i].intersects(second.boxes[j])) continue;
      pairs_.emplace_back();
      PairCandidate& pair = pairs_.back();
      pair.member[0] = a;
      pair.member[1] = b;
      pair.memory.vehicle[0] = first.id;
      pair.memory.vehicle[1] = second.id;
      pair.memory.ellipsoid[0] = static_cast<int>(i);
      pair.memory.ellipsoid[1] = static_cast<int>(j);
      pair.p_start = first.simulator->impl_->dynamics->posedEllipsoids()[i].p_WE -
                     second.simulator->impl_->dynamics->posedEllipsoids()[j].p_WE;
    }
  }
}

void BroadPhase::find(std::vector<FleetMember>& members, double dt) {
  pairs_.clear();
  order_.clear();
  for (std::size_t i = 0; i < members.size(); ++i) {
    sweep(members[i], dt);
    order_.push_back(static_cast<int>(i));
  }
  const auto box = [&members](int i) -> const AlignedBox3d& { return members[static_cast<std::size_t>(i)].box; };
  std::sort(order_.begin(), order_.end(),
            [&box](int a, int b) { return std::make_pair(box(a).min().x(), a) < std::make_pair(box(b).min().x(), b); });
  for (std::size_t i = 0; i < order_.size(); ++i)
    for (std::size_t j = i + 1; j < order_.size() && box(order_[j]).min().x() <= box(order_[i]).max().x(); ++j)
      if (box(order_[i]).intersects(box(order_[j])))
        addPairs(members, std::min(order_[i], order_[j]), std::max(order_[i], order_[j]));
  std::sort(pairs_.begin(), pairs_.end(), [](const PairCandidate& a, const PairCandidate& b) {
    return std::tie(a.member[0], a.member[1], a.memory.ellipsoid[0], a.memory.ellipsoid[1]) <
           std::tie(b.member[0], b.member[1], b.memory.ellipsoid[0], b.memory.ellipsoid[1]);
  });
}

}  // namespace ellipsoid_vehicle_sim
