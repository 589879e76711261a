#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"

#include <cmath>
#include <cstdio>

namespace ellipsoid_vehicle_sim {
namespace {

class Ranges {
 public:
  explicit Ranges(Problems& problems) : problems_(problems) {}

  void within(const char* name, double value, double low, double high, const char* unit) {
    if (value >= low && value <= high) return;
    char text[200];
    std::snprintf(text, sizeof text, "is %.6g %s; allowed are %.6g to %.6g %s", value, unit, low, high, unit);
    problems_.push_back({std::string("parameter '") + name + "'", text});
  }
  void within(const char* name, const std::optional<double>& value, double low, double high, const char* unit) {
    if (value) within(name, *value, low, high, unit);
  }
  void fail(const char* name, const std::string& message) {
    problems_.push_back({std::string("parameter '") + name + "'", message});
  }

 private:
  Problems& problems_;
};

}  // namespace

Problems SimConfig::validate() const {
  Problems problems;
  Ranges range(problems);
  range.within("dt", dt, 1e-6, 0.1, "s");
  range.within("gravity", gravity, 0.0, 100.0, "m/s^2");
  range.within("stiffness", stiffness, 1.0, 1e12, "N/m");
  range.within("damping", damping, 0.0, 1e9, "N s/m");
  range.within("contact_time", contact_time, 1e-6, 10.0, "s");
  range.within("restitution", restitution, 1e-6, 1.0, "");
  if (damping && !stiffness) range.fail("damping", "is given without stiffness; give both, or contact_time and restitution");
  if (stiffness && contact_time) range.fail("contact_time", "is given together with stiffness; give one of them");
  range.within("mu_static", mu_static, 0.0, 10.0, "");
  range.within("mu_kinetic", mu_kinetic, 0.0, 10.0, "");
  if (mu_kinetic > mu_static)
    range.fail("mu_kinetic", "is " + std::to_string(mu_kinetic) + ", above mu_static = " + std::to_string(mu_static) +
                                 "; sliding friction cannot exceed the static one");
  range.within("stribeck_speed", stribeck_speed, 1e-6, 100.0, "m/s");
  range.within("viscous_friction", viscous_friction, 0.0, 1e9, "N s/m");
  range.within("tangential_stiffness", tangential_stiffness, 1e-3, 1e12, "N/m");
  range.within("tangential_damping", tangential_damping, 0.0, 1e9, "N s/m");
  range.within("brush_length", brush_length, 1e-6, 10.0, "m");
  range.within("relaxation_time", relaxation_time, 1e-6, 10.0, "s");
  range.within("max_speed", max_speed, 1e-3, 1000.0, "m/s");
  range.within("max_acceleration", max_acceleration, 1e-3, 1000.0, "m/s^2");
  range.within("max_deceleration", max_deceleration, 1e-3, 1000.0, "m/s^2");
  range.within("max_drive_torque", max_drive_torque, 0.0, 1e9, "N m");
  range.within("max_power", max_power, 0.0, 1e9, "W");
  range.within("brake_balance", brake_balance, 0.0, 1.0, "");
  range.within("steer_rate", steer_rate, 1e-3, 100.0, "rad/s");
  range.within("steer_acceleration", steer_acceleration, 1e-3, 1e5, "rad/s^2");
  range.within("command_timeout", command_timeout, 1e-6, 1e6, "s");
  range.within("ride_frequency", ride_frequency, 0.01, 100.0, "Hz");
  range.within("ride_damping_ratio", ride_damping_ratio, 0.0, 10.0, "");
  return problems;
}

}  // namespace ellipsoid_vehicle_sim
