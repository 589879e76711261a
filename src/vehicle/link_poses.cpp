#include "ellipsoid_vehicle_sim/vehicle/link_poses.h"

#include <algorithm>

namespace ellipsoid_vehicle_sim {

LinkPoses::LinkPoses(const VehicleDescription& description) : poses_(description.links.size()) {
  for (const LinkDescription& link : description.links) names_.push_back(link.name);
  int reading = 0;  // the simulator reports every joint that is not fixed, in the description's order
  for (const JointDescription& description_joint : description.joints) {
    Joint joint;
    joint.parent = find(description_joint.parent);
    joint.X_PJ = description_joint.X_PJ;
    joint.axis = description_joint.axis.normalized();
    joint.prismatic = description_joint.type == JointType::kPrismatic;
    if (description_joint.type != JointType::kFixed) joint.reading = reading++;
    joints_.push_back(joint);
  }
}

int LinkPoses::find(const std::string& link) const {
  const auto found = std::find(names_.begin(), names_.end(), link);
  return found == names_.end() ? -1 : static_cast<int>(found - names_.begin());
}

const std::vector<Pose>& LinkPoses::update(const Simulator& simulator) {
  simulator.jointReadings(readings_);
  poses_[0] = simulator.rootPose();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = joints_[i];
    Pose X_JL;
    if (joint.reading >= 0) {
      const double position = readings_[static_cast<std::size_t>(joint.reading)].position;
      if (joint.prismatic) {
        X_JL.p = position * joint.axis;
      } else {
        X_JL.q = Eigen::AngleAxisd(position, joint.axis);
      }
    }
    poses_[i + 1] = poses_[static_cast<std::size_t>(joint.parent)] * joint.X_PJ * X_JL;
  }
  return poses_;
}

void appendPosedEllipsoids(const Simulator& simulator, LinkPoses& links, std::vector<PosedEllipsoid>& ellipsoids) {
  const std::vector<Pose>& X_WL = links.update(simulator);
  for (const EllipsoidPlacement& placement : simulator.ellipsoids()) {
    const Pose X_WE = X_WL[static_cast<std::size_t>(links.find(placement.link))] * placement.X_LE;
    ellipsoids.emplace_back(X_WE.p, X_WE.q.toRotationMatrix(), placement.radii);
  }
}

}  // namespace ellipsoid_vehicle_sim
