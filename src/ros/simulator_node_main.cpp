#include <ros/ros.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "ellipsoid_vehicle_sim/ros/interrupt.h"
#include "ellipsoid_vehicle_sim/ros/master_watch.h"
#include "ellipsoid_vehicle_sim/ros/node_setup.h"
#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

int main(int argc, char** argv) {
  namespace sim = ellipsoid_vehicle_sim;
#ifdef __GLIBC__
  // One heap for all threads, before there are any. SimulatorNode gives free memory back, which reaches the end of the
  // main heap alone: roscpp's threads would each keep what a flood once needed in a heap of their own.
  mallopt(M_ARENA_MAX, 1);
#endif
  ros::init(argc, argv, "ellipsoid_vehicle_sim", ros::init_options::NoSigintHandler);
  sim::InterruptGuard guard;
  ros::NodeHandle nh, nh_priv("~");

  sim::Loaded<sim::NodeSetup> setup = sim::loadSetup(nh, nh_priv);
  if (!setup) {
    sim::logProblems(setup.problems);
    return 1;
  }
  sim::SimulatorNode node(nh, nh_priv, std::move(*setup.value));
  const sim::MasterWatch watch(nh);
  guard.runBegins();
  const int code = node.run();
  guard.runEnded();
  return code;
}
