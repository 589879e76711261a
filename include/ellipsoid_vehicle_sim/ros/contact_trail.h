#pragma once

#include <ros/time.h>
#include <visualization_msgs/Marker.h>

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <map>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Where each ellipsoid touched the ground: tyre tracks, dark where the contact stuck, red where it slid. They end
/// where a contact ends, and where the vehicle is put elsewhere. Old pieces go.
class ContactTrail {
 public:
  /// A piece is about `spacing` [m] long; a contact that moved more than `longest` [m] between two updates was carried.
  ContactTrail(double spacing, double longest);

  /// True: there is something new to draw.
  bool update(const std::vector<ContactReport>& contacts, const ros::Time& stamp);
  /// The pieces as a list of lines with colours; scale and everything about the header is the caller's.
  void draw(visualization_msgs::Marker& marker) const;
  bool empty() const { return pieces_.empty(); }

 private:
  struct Piece {
    Eigen::Vector3d from, to;
    bool sliding = false;
  };
  /// An ellipsoid's end of the trail.
  struct End {
    Eigen::Vector3d p;
    bool slid = false;  ///< at any time since p
  };

  double spacing_, longest_;
  ros::Time last_;
  std::map<int, End> ends_;
  std::deque<Piece> pieces_;
};

}  // namespace ellipsoid_vehicle_sim
