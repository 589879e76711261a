#include "ellipsoid_vehicle_sim/ros/contact_trail.h"

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

// 40 bytes a corner: 64 kB a message, which goes out about as often as the vehicle moves by one spacing.
constexpr std::size_t kMostPieces = 800;
// After a pause in the messages nobody knows where the contact went meanwhile.
constexpr double kLongestPause = 0.5;  // [s], simulated
// Above the ground, or the two would flicker in turn.
constexpr double kLiftShare = 0.05;  // of the spacing

}  // namespace

ContactTrail::ContactTrail(double spacing, double longest) : spacing_(spacing), longest_(longest) {}

bool ContactTrail::update(const std::vector<ContactReport>& contacts, const ros::Time& stamp) {
  if (stamp < last_ || (stamp - last_).toSec() > kLongestPause) ends_.clear();
  last_ = stamp;
  bool changed = false;
  std::map<int, End> ends;
  for (const ContactReport& contact : contacts) {
    if (contact.triangle < 0) continue;  // another vehicle: no track on the ground
    if (ends.count(contact.ellipsoid) > 0) continue;  // the first of an ellipsoid's contacts is the one that carries
    const Eigen::Vector3d p = contact.p_WC + kLiftShare * spacing_ * contact.nhat_W;
    End end{p, contact.sliding};
    const auto before = ends_.find(contact.ellipsoid);
    if (before != ends_.end()) {
      const double distance = (p - before->second.p).norm();
      const bool slid = before->second.slid || contact.sliding;
      if (distance < spacing_) {
        end = {before->second.p, slid};
      } else if (distance <= longest_) {
        pieces_.push_back({before->second.p, p, slid});
        changed = true;
      }
    }
    ends[contact.ellipsoid] = end;
  }
  ends_ = std::move(ends);
  while (pieces_.size() > kMostPieces) pieces_.pop_front();
  return changed;
}

void ContactTrail::draw(visualization_msgs::Marker& marker) const {
  for (const Piece& piece : pieces_) {
    const std_msgs::ColorRGBA color = piece.sliding ? toColor(0.8, 0.1, 0.1, 1.0) : toColor(0.08, 0.08, 0.1, 1.0);
    marker.points.push_back(toPoint(piece.from));
    marker.points.push_back(toPoint(piece.to));
    marker.colors.push_back(color);
    marker.colors.push_back(color);
  }
}

}  // namespace ellipsoid_vehicle_sim
