#include <ros/ros.h>

#include "ellipsoid_vehicle_sim/ros/master_watch.h"
#include "ellipsoid_vehicle_sim/ros/node_setup.h"
#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

int main(int argc, char** argv) {
  namespace sim = ellipsoid_vehicle_sim;
  ros::init(argc, argv, "ellipsoid_vehicle_sim");
  ros::NodeHandle nh, nh_priv("~");

  sim::Loaded<sim::NodeSetup> setup = sim::loadSetup(nh, nh_priv);
  if (!setup) {
    sim::logProblems(setup.problems);
    return 1;
  }
  sim::SimulatorNode node(nh, nh_priv, std::move(*setup.value));
  const sim::MasterWatch watch(nh);
  return node.run();
}
