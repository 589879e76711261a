#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../vehicle/stepped_vehicle.h"
#include "pair_contact.h"

namespace ellipsoid_vehicle_sim {

/// Motions of an island's vehicles, where they lie, and what integrates of their contacts with each other. Assignment
/// copies the values.
struct IslandMotion {
  std::vector<Motion*> of;
  std::vector<Eigen::Vector3d> anchor;  ///< per candidate.

  IslandMotion() = default;
  IslandMotion(IslandMotion&&) = default;
  IslandMotion& operator=(const IslandMotion& other) {
    for (std::size_t i = 0; i < of.size(); ++i) *of[i] = *other.of[i];
    anchor = other.anchor;
    return *this;
  }
};

/// Rates that lie side by side (stages of a method) do so for each of the vehicles, too.
struct IslandRate {
  std::vector<MotionRate*> of;
  std::vector<Eigen::Vector3d> anchor;
};

/// The largest of some numbers that are not negative; no number where one of them is none.
class Largest {
 public:
  void add(double value) {
    sum_ += value;
    largest_ = std::max(largest_, value);
  }
  double value() const { return std::isnan(sum_) ? sum_ : largest_; }

 private:
  double sum_ = 0.0, largest_ = 0.0;
};

/// Vehicles that could touch each other within the tick, advanced by one rate function. A System of integrator.h, and
/// what the methods ask for that size their steps within the tick: see OneVehicle. These steps are those of all.
class IslandStepper {
 public:
  using System = IslandStepper;
  using State = IslandMotion;
  using Rate = IslandRate;
  using Buffers = StepBuffers<IslandMotion, IslandRate>;

  /// Room for so many vehicles.
  void reserve(std::size_t members);
  void clear();
  /// Places in the fleet, in ascending order.
  void addVehicle(const SteppedVehicle& vehicle, int place);
  /// Where the vehicle that was added as number i is in the fleet.
  int place(std::size_t i) const { return places_[i]; }
  /// Both vehicles are there already.
  void addPair(PairCandidate& pair);

  /// One tick of all, as TickStepper::advance; leaves in the pairs the contacts of its end. False: the states are not to be
  /// used.
  bool advance(bool ends_tick = true);
  /// What came of it for the vehicle that was added as number i.
  const TickOutcome& outcome(std::size_t i) const { return vehicles_[i].outcome; }
  /// Contacts and forces of the pairs at the vehicles' states, for states that no tick led to.
  void evaluatePairs();

  // System.
  void rate(const IslandMotion& x, double fraction, IslandRate& k);
  void positionRates(const IslandMotion& x, IslandRate& k);
  void advance(const IslandMotion& x, double h, const IslandRate& k, IslandMotion& result) const;
  void advanceVelocities(IslandMotion& x, double h, const IslandRate& k) const;
  void advancePositions(IslandMotion& x, double h, const IslandRate& k) const;
  void toTangent(double h, const IslandRate& previous, IslandRate& k) const;
  void combine(IslandRate (&k)[4]) const;
  void weightedSum(const double* weights, const IslandRate* k, int n, IslandRate& sum) const;

  // Steps within the tick: island_steps.cpp.
  System& system() { return *this; }
  Buffers& buffers() { return buffers_; }
  double tickLength() const { return config(0).dt; }
  int vehicles() const { return static_cast<int>(vehicles_.size()); }
  const IslandMotion& start() const { return x_; }
  void beginStep(double h);
  bool accept(const IslandMotion& end, double h, bool last);
  bool isSound(const IslandMotion& x) const;
  void countFloorStep();

  // dormand_prince: the largest error of any counts, and the strictest tolerance.
  double tolerance() const;
  double errorOf(const IslandRate& error, double h) const;

  // rk4_events: first the ellipsoids of each vehicle, as they touch the ground, then the pairs. The most sub-steps
  // count.
  double contactSubsteps() const;
  bool hasJoints() const;
  void noteContacts();
  bool anyPressedAtStart() const;
  bool pressedAtStart(int contact) const;
  const Touch& touchAtStart(int contact) const;
  bool pressAsNoted() const { return firstChanged() < 0; }
  int firstChanged() const;
  Touch touchOf(const IslandMotion& x, int contact) const;

  // linearly_implicit: island_speeds.cpp. The speeds of one vehicle change the rates of its own, and of those it
  // touches.
  DenseSystem& matrix() { return matrix_; }
  double& speed(IslandRate& k, int i) const { return speedOf(*k.of[owner_[i].member], owner_[i].speed); }
  double speed(const IslandMotion& x, int i) const { return speedOf(*x.of[owner_[i].member], owner_[i].speed); }
  void findDirections(double h, double delta);
  void beginColumns();
  void findColumn(int j, double way);
  void keepWork(double h);
  double residual(double h) const;

 private:
  // The speed of the island that is a vehicle's.
  struct Owner {
    std::size_t member;
    int speed;
  };
  // What a pair does at the trial of linearly_implicit.
  struct PairForce {
    bool touches = false;
    Eigen::Vector3d p_WC, f_W;  // on the first
    std::size_t directions[2];  // where those of its sides' speeds begin
  };

  const SimConfig& config(std::size_t i) const { return *vehicles_[i].config; }
  VehicleDynamics& dynamics(std::size_t i) const { return *vehicles_[i].dynamics; }
  TickStepper& stepper(std::size_t i) const { return *vehicles_[i].stepper; }
  PairSide side(const PairCandidate& pair, int which, const IslandMotion& x) const;
  void addForce(const PairCandidate& pair, int which, const IslandMotion& x, const Eigen::Vector3d& p_WC,
                const Eigen::Vector3d& f_W);
  std::size_t placeOf(int member) const;
  void setUp();
  // A contact's vehicle, its ellipsoid in `contact`; or vehicles_.size(), and its pair in `contact`.
  std::size_t placeOfContact(int& contact) const;
  void setUpSpeeds();
  // Directions of the speeds of one vehicle, in the anchor of a pair that it is a side of.
  Eigen::Vector3d& anchorDirection(std::size_t p, int which, int speed) {
    return anchor_directions_[pair_forces_[p].directions[which] + static_cast<std::size_t>(speed)];
  }
  void moveAlong(std::size_t m, int speed, double way);
  void rateOfNeighbour(std::size_t n, std::size_t moved);

  std::vector<SteppedVehicle> vehicles_;
  std::vector<int> places_;  ///< in the fleet, of each.
  std::vector<PairCandidate*> pairs_;
  IslandMotion x_;
  Buffers buffers_;  // of the vehicles' steppers
  bool sane_ = true, ends_tick_ = true;

  // Of linearly_implicit.
  DenseSystem matrix_{0};
  std::vector<Owner> owner_;  // of each speed
  std::vector<PairForce> pair_forces_;
  std::vector<Eigen::Vector3d> anchor_directions_;
  std::vector<char> moved_;  // vehicles whose rates a column changes
};

}  // namespace ellipsoid_vehicle_sim
