# find_package(ellipsoid_vehicle_sim_core): the target ellipsoid_vehicle_sim::core.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.3 NO_MODULE)
include(${CMAKE_CURRENT_LIST_DIR}/ellipsoid_vehicle_sim_core_targets.cmake)
