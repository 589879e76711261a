#include "ellipsoid_vehicle_sim/ros/sim_clock.h"

#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>

#include <cmath>

#include "ellipsoid_vehicle_sim/ros/conversions.h"
#include "ellipsoid_vehicle_sim/ros/interrupt.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kClockQueue = 100;
constexpr double kLongestJump = 10.0;       // [s] of a followed clock that is still simulated
constexpr double kLongestStandstill = 5.0;  // [s] of wall time, then it is said that the followed clock stands

}  // namespace

SimClock::SimClock(ros::NodeHandle& nh, const NodeOptions& options, double dt)
    : mode_(options.clock), factor_(options.real_time_factor), dt_(dt), pacer_(factor_, dt) {
  if (mode_ == ClockMode::kPublish) publisher_ = nh.advertise<rosgraph_msgs::Clock>("/clock", kClockQueue);
}

bool SimClock::start(std::int64_t step) {
  if (mode_ == ClockMode::kFollow) {
    while (ros::ok() && !interrupted() && ros::Time::now().isZero()) {
      if (standing_.due()) ROS_WARN("waiting for somebody to publish /clock");
      ros::WallDuration(0.02).sleep();
    }
  }
  skip(step);
  return ros::ok() && !interrupted();
}

ros::Time SimClock::stamp(std::int64_t step) const {
  return anchor_stamp_ + simulatedDuration(step - anchor_step_, dt_);
}

void SimClock::publish(std::int64_t step) {
  if (mode_ != ClockMode::kPublish) return;
  rosgraph_msgs::Clock message;
  message.clock = stamp(step);
  publisher_.publish(message);
}

void SimClock::anchor(std::int64_t step) {
  anchor_stamp_ = ros::Time::now();
  anchor_step_ = step;
  anchored_ = true;
}

void SimClock::skip(std::int64_t step) {
  pacer_.start(WallPacer::Clock::now(), step);
  last_change_ = WallPacer::Clock::now();
  if (mode_ == ClockMode::kPublish) return;
  if (mode_ == ClockMode::kFollow) last_followed_ = ros::Time::now();
  // Forward only: a wall clock that was set back does not take us along.
  if (mode_ == ClockMode::kFollow || !anchored_ || ros::Time::now() > stamp(step)) anchor(step);
}

void SimClock::setFactor(double factor, std::int64_t step) {
  if (factor == factor_) return;
  factor_ = factor;
  lost_ += pacer_.lost();
  pacer_ = WallPacer(factor, dt_);
  skip(step);
}

std::int64_t SimClock::due(std::int64_t step) {
  if (mode_ != ClockMode::kFollow) {
    const double before = pacer_.lost();
    const std::int64_t ticks = pacer_.due(WallPacer::Clock::now(), step);
    // What is given up is not simulated: the stamps go on with the wall clock.
    if (mode_ == ClockMode::kWall && pacer_.lost() > before) anchor_stamp_ += ros::Duration(pacer_.lost() - before);
    return ticks;
  }
  const ros::Time now = ros::Time::now();
  const auto wall_now = WallPacer::Clock::now();
  if (now != last_followed_) {
    last_change_ = wall_now;
  } else if (std::chrono::duration<double>(wall_now - last_change_).count() > kLongestStandstill && standing_.due()) {
    ROS_INFO("/clock stands still at %.3f s, and so does the simulation", now.toSec());
  }
  const double change = (now - last_followed_).toSec();
  last_followed_ = now;
  if (change < 0.0 || change > kLongestJump) {
    ++jumps_;
    ROS_WARN("/clock jumped %s by %.3f s to %.3f s: the simulation goes on from there, nothing is simulated for it",
             change < 0.0 ? "back" : "ahead", std::abs(change), now.toSec());
    anchor(step);
    return 0;
  }
  return static_cast<std::int64_t>(std::floor((now - stamp(step)).toSec() / dt_ + 1e-6));
}

double SimClock::wait(std::int64_t step) const {
  // Nobody knows when a followed clock moves next: look again after a millisecond.
  if (mode_ == ClockMode::kFollow) return 1e-3;
  return pacer_.wait(WallPacer::Clock::now(), step);
}

}  // namespace ellipsoid_vehicle_sim
