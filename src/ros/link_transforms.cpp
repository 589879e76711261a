#include "ellipsoid_vehicle_sim/ros/link_transforms.h"

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {

LinkTransforms::LinkTransforms(const VehicleDescription& vehicle, const std::string& prefix) {
  int readings = 0;
  for (const JointDescription& joint : vehicle.joints) {
    const bool fixed = joint.type == JointType::kFixed;
    links_.push_back({prefix + joint.parent, prefix + joint.child, joint.X_PJ, joint.axis, joint.type,
                      fixed ? -1 : readings});
    readings += fixed ? 0 : 1;
  }
}

void LinkTransforms::add(const std::vector<JointReading>& readings, const ros::Time& stamp,
                         std::vector<geometry_msgs::TransformStamped>& transforms) const {
  for (const Link& link : links_) {
    Pose X_JL;
    const double q = link.reading < 0 ? 0.0 : readings[static_cast<std::size_t>(link.reading)].position;
    if (link.type == JointType::kPrismatic) {
      X_JL.p = q * link.axis;
    } else {
      X_JL.q = Eigen::Quaterniond(Eigen::AngleAxisd(q, link.axis));
    }
    transforms.push_back(toTransform(link.X_PJ * X_JL, link.parent, link.child, stamp));
  }
}

}  // namespace ellipsoid_vehicle_sim
