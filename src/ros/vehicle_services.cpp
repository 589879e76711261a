#include "ellipsoid_vehicle_sim/ros/vehicle_services.h"

#include <ros/console.h>

#include <cstdio>

#include "ellipsoid_vehicle_sim/ros/contact_publisher.h"
#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

const char* featureName(Feature feature) {
  if (feature == Feature::kNone) return "none";
  if (feature == Feature::kFace) return "face";
  return feature >= Feature::kVertex0 ? "corner" : "edge";
}

ContactCandidate toCandidate(const CandidateReport& report, const Terrain& terrain) {
  ContactCandidate message;
  message.triangle = report.triangle;
  message.surface = terrain.surface(report.triangle).name;
  const Triangle triangle = terrain.triangle(report.triangle);
  for (std::size_t i = 0; i < 3; ++i) message.corners[i] = toPoint(triangle.v[i]);
  message.rank = report.rank;
  message.touches = static_cast<bool>(report.alone);
  message.admitted = report.admitted;
  message.feature = featureName(report.alone.feature);
  message.plane_depth = report.plane_depth;
  message.depth = report.alone.depth;
  message.normal = toVector(report.alone.nhat_W);
  message.reason = report.reason;
  return message;
}

std::string summaryOf(const ContactExplanation& explanation, const std::string& name) {
  char text[300];
  if (explanation.contacts.empty()) {
    std::snprintf(text, sizeof text, "'%s' touches nothing; %zu triangles are near", name.c_str(),
                  explanation.candidates.size());
    return text;
  }
  const ContactReport& first = explanation.contacts.front();
  std::snprintf(text, sizeof text,
                "'%s' is pushed by triangle %d: %.4g mm deep, normal force %.4g N, friction %.4g N, %s", name.c_str(),
                first.triangle, 1e3 * first.depth, first.normal_force, first.friction_W.norm(),
                first.sliding ? "slipping" : "sticking");
  return text;
}

}  // namespace

VehicleServices::VehicleServices(ros::NodeHandle& nh, ros::NodeHandle& nh_priv, bool named, VehicleControl& control)
    : control_(control) {
  servers_.push_back(nh_priv.advertiseService("set_pose", &VehicleServices::onSetPose, this));
  servers_.push_back(nh_priv.advertiseService("explain_contact", &VehicleServices::onExplainContact, this));
  if (named) {
    servers_.push_back(nh_priv.advertiseService("reset", &VehicleServices::onReset, this));
    servers_.push_back(nh_priv.advertiseService("state_hash", &VehicleServices::onStateHash, this));
  }
  initial_pose_ = nh.subscribe("initialpose", 1, &VehicleServices::onInitialPose, this);
}

bool VehicleServices::onReset(Trigger::Request&, Trigger::Response& response) {
  const Outcome outcome = control_.resetVehicle();
  response.success = outcome.success;
  response.message = outcome.message;
  return true;
}

bool VehicleServices::onStateHash(Trigger::Request&, Trigger::Response& response) {
  response.success = true;
  response.message = hashText(control_.simulator().stateHash());
  return true;
}

bool VehicleServices::onSetPose(SetPose::Request& request, SetPose::Response& response) {
  const Placement placement{request.pose.header.frame_id, fromPose(request.pose.pose), fromVector(request.twist.linear),
                            fromVector(request.twist.angular), request.settle != 0};
  const Outcome outcome = control_.put(placement);
  response.success = outcome.success;
  response.message = outcome.message;
  response.pose.header.stamp = control_.now();
  response.pose.header.frame_id = control_.worldFrame();
  response.pose.pose = toPose(control_.simulator().rootPose());
  return true;
}

void VehicleServices::onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Outcome outcome = control_.put({message.header.frame_id, fromPose(message.pose.pose), zero, zero, true});
  if (outcome.success) {
    ROS_INFO("initialpose: %s", outcome.message.c_str());
  } else {
    ROS_WARN("initialpose refused: %s", outcome.message.c_str());
  }
}

bool VehicleServices::onExplainContact(ExplainContact::Request& request, ExplainContact::Response& response) {
  const Simulator& simulator = control_.simulator();
  std::string known;
  for (std::size_t i = 0; i < simulator.ellipsoids().size(); ++i) {
    const EllipsoidPlacement& ellipsoid = simulator.ellipsoids()[i];
    if (ellipsoid.name == request.ellipsoid) {
      const ContactExplanation explanation = simulator.explainContact(static_cast<int>(i));
      for (const CandidateReport& candidate : explanation.candidates) {
        response.candidates.push_back(toCandidate(candidate, simulator.terrain()));
      }
      for (const ContactReport& contact : explanation.contacts) {
        response.contacts.push_back(namedContact(contact, simulator, control_.fleet()));
      }
      response.margin = explanation.margin;
      response.slack = explanation.slack;
      response.message = summaryOf(explanation, ellipsoid.name);
      response.success = true;
      return true;
    }
    known += (known.empty() ? "" : ", ") + ellipsoid.name;
  }
  response.message = "there is no ellipsoid '" + request.ellipsoid + "'; there are: " + known;
  return true;
}

}  // namespace ellipsoid_vehicle_sim
