# One program per test file, named like it; ctest runs them all. Test data is read where it lies in the sources.
# By CMake's own module: GTest's configuration of Noetic's time is an error where GMock is not installed.
find_package(GTest REQUIRED)
if(NOT TARGET GTest::gtest_main)  # its name in the find module of CMake before 3.20
  add_library(GTest::gtest_main INTERFACE IMPORTED)
  target_link_libraries(GTest::gtest_main INTERFACE GTest::GTest GTest::Main)
endif()

# The work is in the libraries: tests are compiled with little optimisation, and read the headers they share once. Both
# together halve the time of a build from nothing.
set(timeout 600)
if(SANITIZE)
  set(timeout 3600)  # the same slow-down as ELLIPSOID_VEHICLE_SIM_SLOWDOWN in scripts/sanitizers.sh, and some
endif()
set(first_test)
file(GLOB test_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/*/*_test.cpp)
list(FILTER test_sources EXCLUDE REGEX "/test/(ros|consumer|benchmark)/")
foreach(source IN LISTS test_sources)
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/test)
  target_compile_definitions(${name} PRIVATE
    TEST_DATA_DIR="${PROJECT_SOURCE_DIR}/test/data" PACKAGE_DIR="${PROJECT_SOURCE_DIR}"
    SHARE_DIR="${devel_prefix}/${package_share}"
    PROGRAM_DIR="${devel_prefix}/${package_programs}")
  target_link_libraries(${name} PRIVATE
    ${PROJECT_NAME}_scene ${PROJECT_NAME}_sensors ${PROJECT_NAME}_description ${PROJECT_NAME}_core GTest::gtest_main
    ${PROJECT_NAME}_warnings)
  target_compile_options(${name} PRIVATE $<$<OR:$<CONFIG:Release>,$<CONFIG:Sanitize>>:-O1>)
  if(NOT first_test)
    set(first_test ${name})
    target_precompile_headers(${name} PRIVATE
      <Eigen/Core> <Eigen/Geometry> <gtest/gtest.h> <array> <cmath> <memory> <string> <vector>)
  else()
    target_precompile_headers(${name} REUSE_FROM ${first_test})
  endif()
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${timeout})
endforeach()

# The targets of scripts/fuzz, with the inputs that are kept.
file(GLOB fuzz_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/test/fuzz/*.cpp)
list(FILTER fuzz_sources EXCLUDE REGEX "(_test|/entry)\\.cpp$")
target_sources(fuzz_replay_test PRIVATE ${fuzz_sources})
# A minute of them with changed input; scripts/test builds the programs. The longest test starts first.
add_test(NAME fuzz COMMAND ${PROJECT_SOURCE_DIR}/scripts/fuzz --no-build --seconds 6 --seed 1)
set_tests_properties(fuzz PROPERTIES TIMEOUT 600 COST 1000 SKIP_RETURN_CODE 77
  ENVIRONMENT ELLIPSOID_VEHICLE_SIM_BUILD=${PROJECT_BINARY_DIR})

# A run with sanitizers is worth nothing if it would not see a fault: these are planted, and have to be seen, with the
# suppressions that everything else runs with. Their reports stand in the output, not with those of real faults.
if(SANITIZE)
  add_executable(planted_fault ${PROJECT_SOURCE_DIR}/test/sanitizers/planted_fault.cpp)
  target_link_libraries(planted_fault PRIVATE Threads::Threads)
  target_compile_options(planted_fault PRIVATE -O0)
  if(SANITIZE STREQUAL "thread")
    set(planted "race=WARNING: ThreadSanitizer: data race")
  else()
    set(planted "overflow=ERROR: AddressSanitizer: heap-buffer-overflow" "undefined=runtime error: signed integer overflow"
      "leak=ERROR: LeakSanitizer: detected memory leaks")
  endif()
  foreach(pair IN LISTS planted)
    string(REGEX MATCH "^[a-z]+" kind "${pair}")
    string(REGEX REPLACE "^[a-z]+=" "" report "${pair}")
    add_test(NAME planted_${kind} COMMAND planted_fault ${kind})
    set(suppressions ${PROJECT_SOURCE_DIR}/test/sanitizers)
    set_tests_properties(planted_${kind} PROPERTIES PASS_REGULAR_EXPRESSION "${report}" ENVIRONMENT
      "TSAN_OPTIONS=suppressions=${suppressions}/thread.txt;ASAN_OPTIONS=;UBSAN_OPTIONS=;LSAN_OPTIONS=suppressions=${suppressions}/leak.txt")
  endforeach()
endif()

# Runs the programs that need no ROS.
add_dependencies(scene_test ${PROJECT_NAME}_headless ${PROJECT_NAME}_meshes)
add_dependencies(inertia_lint_test ${PROJECT_NAME}_urdf_doctor)
target_link_libraries(peers_test PRIVATE ${PROJECT_NAME}_peers)
add_dependencies(vehicle_trial_test ${PROJECT_NAME}_vehicle_trial ${PROJECT_NAME}_meshes)

# A ten-line program against the installed core, built apart from this project.
add_test(NAME consumer COMMAND ${CMAKE_COMMAND}
  -D build=${PROJECT_BINARY_DIR} -D source=${PROJECT_SOURCE_DIR}/test/consumer -D compiler=${CMAKE_CXX_COMPILER}
  -P ${PROJECT_SOURCE_DIR}/test/consumer/build_and_run.cmake)
set_tests_properties(consumer PROPERTIES TIMEOUT 300)

include(cmake/benchmarks.cmake)

if(with_ros)
  include(cmake/ros_tests.cmake)
endif()
