# The libraries from the core outwards, and the node. A layer links those before it, never one after.
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)

add_library(${PROJECT_NAME}_warnings INTERFACE)
target_compile_options(${PROJECT_NAME}_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor)

# find_sources(<variable> <folder>...): all sources in src/<folder>, but for the mains.
function(find_sources variable)
  set(sources)
  foreach(folder IN LISTS ARGN)
    file(GLOB found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${folder}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  list(FILTER sources EXCLUDE REGEX "_main\\.cpp$")
  set(${variable} ${sources} PARENT_SCOPE)
endfunction()

# What every library of ours has in common.
function(set_up_library name)
  target_compile_features(${name} PUBLIC cxx_std_17)
  target_include_directories(${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:ellipsoid_vehicle_sim_warnings>)
  # Read once for each library, not once for each of its files.
  target_precompile_headers(${name} PRIVATE
    <Eigen/Core> <Eigen/Geometry> <algorithm> <cmath> <functional> <memory> <optional> <string> <vector>)
  set_target_properties(${name} PROPERTIES
    LIBRARY_OUTPUT_DIRECTORY ${devel_prefix}/lib
    INSTALL_RPATH "$ORIGIN")
endfunction()

# Debian and Ubuntu disagree on the CMake files of these libraries, not on their headers and library files.
function(add_system_library target header library debian_package)
  find_path(${library}_INCLUDE_DIR ${header})
  find_library(${library}_LIBRARY ${library})
  if(NOT ${library}_INCLUDE_DIR OR NOT ${library}_LIBRARY)
    message(FATAL_ERROR "${header} or lib${library} not found: install ${debian_package}")
  endif()
  add_library(${target} UNKNOWN IMPORTED)
  set_target_properties(${target} PROPERTIES
    IMPORTED_LOCATION ${${library}_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${${library}_INCLUDE_DIR})
endfunction()

# Core: geometry -> contact -> world -> dynamics -> vehicle -> fleet. Eigen alone. No ROS.
find_sources(core_sources geometry contact world dynamics vehicle fleet)
add_library(${PROJECT_NAME}_core SHARED ${core_sources})
set_up_library(${PROJECT_NAME}_core)
target_link_libraries(${PROJECT_NAME}_core PUBLIC Eigen3::Eigen PRIVATE Threads::Threads)
# No fused multiply-adds: the same bits on machines that have them and on those that have not. The other two change no
# result; they let the compiler choose without branches and take roots side by side.
target_compile_options(${PROJECT_NAME}_core PRIVATE -ffp-contract=off -fno-math-errno -fno-trapping-math)
# The lanes of its vectors are passed in memory only: the note on their calling convention is beside the point.
set_source_files_properties(src/contact/candidate_filter.cpp PROPERTIES
  COMPILE_OPTIONS -Wno-psabi SKIP_PRECOMPILE_HEADERS ON)
# Pairs made of a 3-vector's parts cost more shuffles than they save, and one that was written as two numbers waits for
# both of them: a near miss took 14 ns without them, 16 with.
set_source_files_properties(src/geometry/minimum_translation.cpp src/geometry/feature_search.cpp
  src/contact/find_contacts.cpp PROPERTIES
  COMPILE_OPTIONS "-fno-tree-slp-vectorize;-Wno-psabi" SKIP_PRECOMPILE_HEADERS ON)
# Fleets on several cores: oneTBB where it is found. Its CMake files are not packaged everywhere (Ubuntu 20.04 has none).
find_path(tbb_INCLUDE_DIR tbb/parallel_for.h)
find_library(tbb_LIBRARY tbb)
if(tbb_INCLUDE_DIR AND tbb_LIBRARY)
  target_link_libraries(${PROJECT_NAME}_core PRIVATE ${tbb_LIBRARY})
  set_source_files_properties(src/fleet/workers.cpp PROPERTIES COMPILE_DEFINITIONS ELLIPSOID_VEHICLE_SIM_HAS_TBB)
else()
  message(STATUS "oneTBB not found (libtbb-dev): fleets run on one core")
endif()
set_target_properties(${PROJECT_NAME}_core PROPERTIES EXPORT_NAME core)
add_library(${PROJECT_NAME}::core ALIAS ${PROJECT_NAME}_core)

# Sensors: rays against the world and the vehicles. Embree where it is found, otherwise the core's own tree. No ROS.
find_sources(sensors_sources sensors)
add_library(${PROJECT_NAME}_sensors SHARED ${sensors_sources})
set_up_library(${PROJECT_NAME}_sensors)
target_link_libraries(${PROJECT_NAME}_sensors PUBLIC ${PROJECT_NAME}_core)
# As for the core: a ray meets the same triangle at the same distance whoever proposed it, and on every machine.
target_compile_options(${PROJECT_NAME}_sensors PRIVATE -ffp-contract=off)
find_path(embree_include embree3/rtcore.h)
find_library(embree_library embree3)
if(embree_include AND embree_library)
  message(STATUS "Rays of lidars: Embree (${embree_library})")
  target_include_directories(${PROJECT_NAME}_sensors SYSTEM PRIVATE ${embree_include})
  target_compile_definitions(${PROJECT_NAME}_sensors PRIVATE WITH_EMBREE)
  target_link_libraries(${PROJECT_NAME}_sensors PRIVATE ${embree_library})
else()
  message(STATUS "Rays of lidars: the simulator's own tree, several times slower; Embree (libembree-dev) was not found")
endif()
install(TARGETS ${PROJECT_NAME}_sensors LIBRARY DESTINATION lib)

# Description: URDF and YAML files -> what the core is built from. No ROS.
add_system_library(urdfdom_model_library urdf_parser/urdf_parser.h urdfdom_model liburdfdom-dev)
add_system_library(tinyxml2_library tinyxml2.h tinyxml2 libtinyxml2-dev)
add_system_library(console_bridge_library console_bridge/console.h console_bridge libconsole-bridge-dev)
add_system_library(yaml_cpp_library yaml-cpp/yaml.h yaml-cpp libyaml-cpp-dev)
find_sources(description_sources description)
add_library(${PROJECT_NAME}_description SHARED ${description_sources})
set_up_library(${PROJECT_NAME}_description)
target_link_libraries(${PROJECT_NAME}_description
  PUBLIC ${PROJECT_NAME}_core
  PRIVATE urdfdom_model_library console_bridge_library tinyxml2_library yaml_cpp_library)

# Scenes: runs described by files, their records, the trade between speed and accuracy. No ROS.
find_package(OpenSSL REQUIRED)
find_sources(scene_sources scene trade)
set(build_info ${PROJECT_BINARY_DIR}/build_info/build_info.inc)
add_custom_target(${PROJECT_NAME}_build_info BYPRODUCTS ${build_info} COMMAND ${CMAKE_COMMAND}
  -D "source=${PROJECT_SOURCE_DIR}" -D "output=${build_info}" -D "version=${PROJECT_VERSION}"
  -D "compiler=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}"
  -D "flags=${CMAKE_BUILD_TYPE} ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELEASE}"
  -P ${PROJECT_SOURCE_DIR}/cmake/build_info.cmake COMMENT "Writing down what is built")
add_library(${PROJECT_NAME}_scene SHARED ${scene_sources})
set_up_library(${PROJECT_NAME}_scene)
add_dependencies(${PROJECT_NAME}_scene ${PROJECT_NAME}_build_info)
target_include_directories(${PROJECT_NAME}_scene PRIVATE ${PROJECT_BINARY_DIR}/build_info)
target_link_libraries(${PROJECT_NAME}_scene PUBLIC ${PROJECT_NAME}_description PRIVATE yaml_cpp_library OpenSSL::Crypto)

# Programs that need no ROS master: rosrun finds them where the node is.
foreach(program IN ITEMS description/urdf_doctor scene/headless scene/vehicle_trial trade/trade_off trade/extremes)
  set(main src/${program}_main.cpp)
  get_filename_component(program ${program} NAME)
  add_executable(${PROJECT_NAME}_${program} ${main})
  target_link_libraries(${PROJECT_NAME}_${program} PRIVATE ${PROJECT_NAME}_scene Threads::Threads ${PROJECT_NAME}_warnings)
  set_target_properties(${PROJECT_NAME}_${program} PROPERTIES OUTPUT_NAME ${program}
    RUNTIME_OUTPUT_DIRECTORY ${devel_prefix}/${package_programs}
    INSTALL_RPATH "$ORIGIN/..")
  install(TARGETS ${PROJECT_NAME}_${program} RUNTIME DESTINATION ${package_programs})
endforeach()
include(cmake/peers.cmake)
install(TARGETS ${PROJECT_NAME}_scene LIBRARY DESTINATION lib)

if(with_ros)
  find_sources(ros_sources ros)
  add_library(${PROJECT_NAME}_ros SHARED ${ros_sources})
  set_up_library(${PROJECT_NAME}_ros)
  # With the thread sanitizer: roscpp calls boost's inline mutexes by name, and must find its own, which the suppressions
  # know as called from there, not a watched copy of ours.
  if(SANITIZE STREQUAL "thread")
    target_compile_options(${PROJECT_NAME}_ros PUBLIC -fvisibility-inlines-hidden)
  endif()
  # SYSTEM: the warnings of roscpp's headers are not ours to fix.
  #catkin_lint: ignore_once external_interface_path
  target_include_directories(${PROJECT_NAME}_ros SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
  target_link_libraries(${PROJECT_NAME}_ros PUBLIC ${PROJECT_NAME}_scene ${PROJECT_NAME}_sensors ${catkin_LIBRARIES})
  target_include_directories(${PROJECT_NAME}_ros SYSTEM PUBLIC $<BUILD_INTERFACE:${devel_prefix}/include>)
  add_dependencies(${PROJECT_NAME}_ros ${PROJECT_NAME}_generate_messages_cpp ${PROJECT_NAME}_gencfg)
  # roscpp's headers are most of what compiling these files costs.
  target_precompile_headers(${PROJECT_NAME}_ros PRIVATE
    <ros/ros.h> <Eigen/Geometry> <nav_msgs/Odometry.h> <sensor_msgs/JointState.h> <visualization_msgs/MarkerArray.h>)

  add_executable(${PROJECT_NAME}_node src/ros/simulator_node_main.cpp)
  target_link_libraries(${PROJECT_NAME}_node PRIVATE ${PROJECT_NAME}_ros ${PROJECT_NAME}_warnings)
  set_target_properties(${PROJECT_NAME}_node PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${devel_prefix}/${package_programs}
    INSTALL_RPATH "$ORIGIN/..")
  install(TARGETS ${PROJECT_NAME}_ros LIBRARY DESTINATION lib)
  install(TARGETS ${PROJECT_NAME}_node RUNTIME DESTINATION ${package_programs})
endif()
install(TARGETS ${PROJECT_NAME}_description LIBRARY DESTINATION lib)

# The core is a CMake package of its own, for programs without ROS:
#   find_package(ellipsoid_vehicle_sim_core) ... target_link_libraries(mine ellipsoid_vehicle_sim::core)
include(CMakePackageConfigHelpers)
set(core_config lib/cmake/${PROJECT_NAME}_core)
install(TARGETS ${PROJECT_NAME}_core EXPORT ${PROJECT_NAME}_core_targets LIBRARY DESTINATION lib COMPONENT core)
install(DIRECTORY include/${PROJECT_NAME} DESTINATION include COMPONENT core FILES_MATCHING PATTERN "*.h")
install(EXPORT ${PROJECT_NAME}_core_targets NAMESPACE ellipsoid_vehicle_sim:: DESTINATION ${core_config} COMPONENT core)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/${PROJECT_NAME}_core-config-version.cmake
  COMPATIBILITY SameMinorVersion)
configure_file(cmake/${PROJECT_NAME}_core-config.cmake ${PROJECT_BINARY_DIR} COPYONLY)
#catkin_lint: ignore_once missing_file external_file
install(FILES ${PROJECT_BINARY_DIR}/${PROJECT_NAME}_core-config-version.cmake
  cmake/${PROJECT_NAME}_core-config.cmake DESTINATION ${core_config} COMPONENT core)
