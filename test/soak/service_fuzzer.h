#pragma once

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>
#include <ros/service.h>
#include <std_srvs/Trigger.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "command_fuzzer.h"
#include "ellipsoid_vehicle_sim/ExplainContact.h"
#include "ellipsoid_vehicle_sim/Remove.h"
#include "ellipsoid_vehicle_sim/RestoreState.h"
#include "ellipsoid_vehicle_sim/SaveState.h"
#include "ellipsoid_vehicle_sim/SetPose.h"
#include "ellipsoid_vehicle_sim/Spawn.h"
#include "ellipsoid_vehicle_sim/Step.h"
#include "machine_time.h"
#include "nan_search.h"

namespace ellipsoid_vehicle_sim {

/// Calls every service with valid and absurd arguments, and times the answers.
class ServiceFuzzer {
 public:
  struct Latency {
    long calls = 0;
    double worst = 0.0;                 ///< by the wall clock [s]
    MachineTime::Kept kept_from_worst;  ///< in that one, from simulator, master and caller
    double worst_served = 0.0;          ///< the longest of all less what the machine kept from it [s]
    long late = 0;                      ///< that took longer than is allowed by the wall clock
    long late_served = 0;               ///< and of these, less what the machine kept
  };

  /// `pids`: of the simulator and of the master, which is asked for the way before every call. `allowed`: for an answer [s].
  ServiceFuzzer(std::string node, std::vector<std::string> ellipsoids, std::vector<long> pids, std::uint64_t seed, double allowed)
      : node_(std::move(node)),
        ellipsoids_(std::move(ellipsoids)),
        machine_(withOurs(std::move(pids))),
        random_(seed),
        allowed_(allowed) {}

  void round() {
    switch (random_.index(12)) {
      case 0:
        return trigger("reset");
      case 1:
        return pauseAndStep();
      case 2:
        return setPose();
      case 3:
        return save();
      case 4:
      case 5:
        return restore();
      case 6:
        return explain();
      case 7:
        return trigger("state_hash");
      case 8:
        return trigger("resume");
      case 9:
        return spawnOrRemove();
      default:
        return reconfigure();
    }
  }
  const std::map<std::string, Latency>& latencies() const { return latencies_; }
  long lost() const { return lost_; }
  const std::vector<std::string>& faults() const { return faults_; }

 private:
  static std::vector<long> withOurs(std::vector<long> pids) {
    pids.push_back(getpid());
    return pids;
  }
  template <typename Service>
  bool call(const std::string& name, Service& service) {
    using Clock = std::chrono::steady_clock;
    const MachineTime::Reading before = machine_.read();
    const auto start = Clock::now();
    bool answered = ros::service::call(node_ + "/" + name, service);
    // A roscpp client that asks on a connection of its own throws an answer away now and then that comes before it
    // begins to read (ros_comm issue 1976). One that keeps its connection does not: what it is not told was not said.
    if (!answered && ros::ok()) {
      ++lost_;
      answered = ros::NodeHandle().serviceClient<Service>(node_ + "/" + name, true).call(service);
    }
    const double took = std::chrono::duration<double>(Clock::now() - start).count();
    const MachineTime::Kept kept = machine_.since(before);
    Latency& latency = latencies_[name];
    ++latency.calls;
    latency.worst_served = std::max(latency.worst_served, took - kept.sum());
    if (took > allowed_) ++latency.late;
    if (took - kept.sum() > allowed_) ++latency.late_served;
    if (took > latency.worst) {
      latency.worst = took;
      latency.kept_from_worst = kept;
    }
    if (!answered && ros::ok())
      fault(name + " was not answered after " + std::to_string(std::lround(1e3 * took)) + " ms; the master " +
            (ros::service::exists(node_ + "/" + name, false) ? "knows it" : "does not know it"));
    if (answered && NanSearch::finds(service.response)) fault("NaN in the answer of " + name);
    return answered;
  }
  void fault(const std::string& text) {
    if (faults_.size() < 20) faults_.push_back(text);
  }
  void trigger(const std::string& name) {
    std_srvs::Trigger service;
    call(name, service);
  }
  void pauseAndStep() {
    trigger("pause");
    for (int i = random_.index(4); i >= 0; --i) {
      Step service;
      // What is asked for in earnest is answered when it is done: 200 ticks at most here.
      service.request.steps =
          random_.one(4) ? (random_.one(2) ? 0u : 4294967295u) : static_cast<std::uint32_t>(1 + random_.index(200));
      call("step", service);
    }
    trigger("resume");
  }
  void setPose() {
    SetPose service;
    auto& request = service.request;
    request.pose.header.frame_id = random_.one(4) ? "no_such_frame" : random_.one(2) ? "odom" : "";
    request.pose.header.stamp = random_.stamp(ros::Time::now());
    request.pose.pose.position.x = random_.number(20.0);
    request.pose.pose.position.y = random_.number(3.0);
    request.pose.pose.position.z = random_.uniform(0.3, 2.0);
    if (random_.one(5)) request.pose.pose.position.z = random_.number(100.0);
    request.pose.pose.orientation.z = random_.number(1.0);
    request.pose.pose.orientation.w = random_.number(1.0);
    request.settle = random_.one(2);
    if (random_.one(3)) {
      request.twist.linear.x = random_.number(10.0);
      request.twist.angular.z = random_.number(3.0);
    }
    call("set_pose", service);
  }
  void save() {
    SaveState service;
    if (random_.one(3)) service.request.file = "/no_such_folder/state";
    if (call("save_state", service) && service.response.success) saved_ = service.response.state;
  }
  void restore() {
    RestoreState service;
    service.request.state = saved_;
    auto& state = service.request.state;
    if (!state.empty() && random_.one(2)) {
      if (random_.one(2)) {
        state.resize(static_cast<std::size_t>(random_.index(static_cast<int>(state.size()))));
      } else {
        for (int i = 0; i < 5; ++i)
          state[static_cast<std::size_t>(random_.index(static_cast<int>(state.size())))] =
              static_cast<std::uint8_t>(random_.index(256));
      }
    }
    if (random_.one(8)) service.request.file = random_.one(2) ? "/no_such_file" : "/dev/zero";
    call("restore_state", service);
  }
  void explain() {
    ExplainContact service;
    service.request.ellipsoid =
        ellipsoids_.empty() || random_.one(4)
            ? std::string(static_cast<std::size_t>(random_.index(100000)), 'x')
            : ellipsoids_[static_cast<std::size_t>(random_.index(static_cast<int>(ellipsoids_.size())))];
    call("explain_contact", service);
  }
  /// Nothing that could come: a vehicle that is loaded takes its time, and stays.
  void spawnOrRemove() {
    if (random_.one(2)) {
      Remove service;
      service.request.name =
          random_.one(2) ? "nobody" : std::string(static_cast<std::size_t>(random_.index(1000)), 'y');
      call("remove", service);
      return;
    }
    Spawn service;
    service.request.name = random_.one(2) ? "a/b" : "other";
    service.request.vehicle = random_.one(2) ? "/dev/zero" : "no_such_vehicle";
    if (random_.one(2))
      service.request.urdf = "<robot name=\"" + std::string(static_cast<std::size_t>(random_.index(50000)), 'x');
    service.request.x = random_.number(20.0);
    service.request.yaw = random_.number(3.0);
    if (random_.one(3)) service.request.parameters = "{[: no yaml";
    if (call("spawn", service) && service.response.success) fault("spawn took what is none");
  }
  void set(const char* key, double value) {
    dynamic_reconfigure::Reconfigure service;
    service.request.config.doubles.resize(1);
    service.request.config.doubles[0].name = key;
    service.request.config.doubles[0].value = value;
    call("set_parameters", service);
  }
  void reconfigure() {
    static const char* const kKeys[] = {"publish_rate", "imu_rate",       "marker_rate",      "clock_rate",
                                        "marker_scale", "friction_scale", "no_such_parameter"};
    set(kKeys[random_.index(7)], random_.one(3) ? random_.number(1e6) : random_.uniform(0.5, 200.0));
    if (!random_.one(20)) return;
    set("real_time_factor", random_.number(10.0));
    set("real_time_factor", 0.0);
  }

  std::string node_;
  std::vector<std::string> ellipsoids_;
  MachineTime machine_;
  AbsurdNumbers random_;
  double allowed_;
  std::vector<std::uint8_t> saved_;
  std::map<std::string, Latency> latencies_;
  long lost_ = 0;
  std::vector<std::string> faults_;
};

}  // namespace ellipsoid_vehicle_sim
