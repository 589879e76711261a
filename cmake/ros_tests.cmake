# Each test/ros/*.test is one rostest. rostest starts its own master on a free port, so they may run side by side.
# test/ros/*_test.cpp are gtests of the ROS layer that need no master.
file(GLOB ros_test_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/ros/*_test.cpp)
foreach(source IN LISTS ros_test_sources)
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/test)
  target_compile_definitions(${name} PRIVATE
    TEST_DATA_DIR="${PROJECT_SOURCE_DIR}/test/data" PACKAGE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${PROJECT_NAME}_ros GTest::gtest_main ${PROJECT_NAME}_warnings)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${timeout})
endforeach()

set(ros_timeout 300)
if(SANITIZE)
  set(ros_timeout ${timeout})
endif()
file(GLOB ros_tests CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/ros/*.test)
foreach(file IN LISTS ros_tests)
  get_filename_component(name ${file} NAME_WE)
  add_test(NAME ros_${name} COMMAND ${PROJECT_SOURCE_DIR}/test/ros/run_rostest ${devel_prefix} ${file})
  set_tests_properties(ros_${name} PROPERTIES TIMEOUT ${ros_timeout})
endforeach()

# Bothers the node for a few simulated minutes; scripts/soak does it for hours.
foreach(program soak_client soak_caller)
  add_executable(${program} ${PROJECT_SOURCE_DIR}/test/soak/${program}.cpp)
  target_link_libraries(${program} PRIVATE ${PROJECT_NAME}_ros ${PROJECT_NAME}_warnings)
  set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test)
endforeach()
add_test(NAME soak COMMAND ${PROJECT_SOURCE_DIR}/test/soak/short_soak ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR} ${devel_prefix})
set_tests_properties(soak PROPERTIES TIMEOUT 200)

# Every command of the documents. They build (nothing, when all is built) and start masters of their own.
add_test(NAME documented_commands COMMAND ${mesh_python} ${PROJECT_SOURCE_DIR}/test/docs/run_commands.py
  ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR} ${devel_prefix})
set_tests_properties(documented_commands PROPERTIES TIMEOUT 400)

# Installs into a fresh prefix, looks for paths of the source tree in it, and drives from there.
add_test(NAME installed_launch COMMAND ${PROJECT_SOURCE_DIR}/test/install/install_and_launch
  ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR})
set_tests_properties(installed_launch PROPERTIES TIMEOUT 300)
