#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Where every link of a vehicle is, as robot_state_publisher would tell it from the joint positions that the simulator
/// publishes: so what is drawn and what is sensed stand at one place. Keeps its buffers from call to call.
class LinkPoses {
 public:
  explicit LinkPoses(const VehicleDescription& description);

  /// Index into poses() of a link; -1 if there is none.
  int find(const std::string& link) const;
  /// X_WL of every link, in the description's order, at the simulator's present state.
  const std::vector<Pose>& update(const Simulator& simulator);
  const std::vector<Pose>& poses() const { return poses_; }

 private:
  struct Joint {
    int parent = 0;
    int reading = -1;  ///< index into the readings; -1: does not move.
    Pose X_PJ;
    Eigen::Vector3d axis;
    bool prismatic = false;
  };
  std::vector<std::string> names_;
  std::vector<Joint> joints_;  ///< of link i + 1.
  std::vector<JointReading> readings_;
  std::vector<Pose> poses_;
};

/// Appends the ellipsoids of a vehicle where they are now, in the order of Simulator::ellipsoids().
void appendPosedEllipsoids(const Simulator& simulator, LinkPoses& links, std::vector<PosedEllipsoid>& ellipsoids);

}  // namespace ellipsoid_vehicle_sim
