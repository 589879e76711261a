# Finds catkin and the message packages without a sourced ROS environment, and calls catkin_package().
# Sets with_ros. On Debian everything is in /usr; a Noetic in /opt is used where it exists.
set(with_ros FALSE)
# Where programs and shared files are put in the build tree, laid out as if installed.
set(devel_prefix ${PROJECT_BINARY_DIR}/devel)

# catkin's scripts need a Python that has catkin_pkg; a pyenv's python3 that comes first in PATH usually does not.
# Both variables: catkin looks at the first, the ament files that some ROS packages pull in look at the second.
function(find_ros_python out)
  foreach(candidate IN ITEMS "${PYTHON_EXECUTABLE}" /usr/bin/python3 python3)
    if(candidate)
      execute_process(COMMAND ${candidate} -c "import catkin_pkg" RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
      if(NOT failed)
        set(${out} ${candidate} PARENT_SCOPE)
        return()
      endif()
    endif()
  endforeach()
  set(${out} "" PARENT_SCOPE)
endfunction()

if(BUILD_ROS)  # ON or AUTO
  if(NOT DEFINED ENV{ROS_DISTRO} AND EXISTS "/opt/ros/noetic")
    #catkin_lint: ignore_once critical_var_append
    list(APPEND CMAKE_PREFIX_PATH /opt/ros/noetic)
  endif()
  find_ros_python(ros_python)
  if(ros_python)
    set(PYTHON_EXECUTABLE ${ros_python} CACHE FILEPATH "Python with catkin_pkg")
    set(Python3_EXECUTABLE ${ros_python} CACHE FILEPATH "Python with catkin_pkg")
    set(ros_components diagnostic_msgs dynamic_reconfigure geometry_msgs nav_msgs roscpp rosgraph_msgs roslib sensor_msgs
      std_msgs std_srvs tf2_msgs visualization_msgs)
    set(or_not REQUIRED)
    if(BUILD_ROS STREQUAL "AUTO")
      set(or_not QUIET)
    endif()
    #catkin_lint: ignore_once missing_required
    find_package(catkin ${or_not} COMPONENTS ${ros_components} message_generation)
    set(with_ros ${catkin_FOUND})
  elseif(NOT BUILD_ROS STREQUAL "AUTO")
    message(FATAL_ERROR "BUILD_ROS=${BUILD_ROS}, but no Python with catkin_pkg was found: install python3-catkin-pkg, or set "
      "PYTHON_EXECUTABLE")
  endif()
endif()

if(with_ros)
  # Own messages and services, and what may change while running; catkin wants them before catkin_package().
  add_message_files(FILES ContactCandidate.msg ContactState.msg ContactStates.msg ParameterChange.msg)
  add_service_files(FILES ExplainContact.srv Remove.srv RestoreState.srv SaveState.srv SetPose.srv
    Spawn.srv Step.srv)
  generate_messages(DEPENDENCIES geometry_msgs std_msgs)
  generate_dynamic_reconfigure_options(cfg/Running.cfg)
  # Both hand the folder of the generated headers to every target; the core shall not see it.
  set_property(DIRECTORY PROPERTY INCLUDE_DIRECTORIES "")
  #catkin_lint: ignore_once unused_include_path
  catkin_package(
    INCLUDE_DIRS include
    LIBRARIES ${PROJECT_NAME}_ros ${PROJECT_NAME}_scene ${PROJECT_NAME}_sensors ${PROJECT_NAME}_description ${PROJECT_NAME}_core
    CATKIN_DEPENDS ${ros_components} message_runtime)
  set(devel_prefix ${CATKIN_DEVEL_PREFIX})
else()
  message(STATUS "${PROJECT_NAME}: without ROS, only the core and the description libraries")
endif()
