# Not all of scripts/ is meant to be installed; the include path is used, but catkin_lint does not look into functions.
#catkin_lint: ignore uninstalled_script unused_include_path

# Launch files, vehicles, worlds and programs; the same layout in the build tree (links) and below the prefix (copies), so
# that names and relative paths resolve in both.
file(GLOB_RECURSE share_files CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}
  ${PROJECT_SOURCE_DIR}/launch/* ${PROJECT_SOURCE_DIR}/urdf/* ${PROJECT_SOURCE_DIR}/meshes/*)
foreach(file IN LISTS share_files)
  get_filename_component(folder ${file} DIRECTORY)
  # Not the launch files: roslaunch finds them in the sources, and two of one name are an error to it.
  if(NOT file MATCHES "\\.launch$")
    file(MAKE_DIRECTORY ${devel_prefix}/${package_share}/${folder})
    file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${file} ${devel_prefix}/${package_share}/${file} SYMBOLIC)
  endif()
  install(FILES ${file} DESTINATION ${package_share}/${folder})
endforeach()

# The rolling terrain is too large to commit: made at build, beside the links to the other meshes.
set(rolling_mesh ${devel_prefix}/${package_share}/meshes/rolling.stl)
file(MAKE_DIRECTORY ${devel_prefix}/${package_share}/meshes)
find_program(mesh_python NAMES python3 HINTS /usr/bin REQUIRED)
add_custom_command(OUTPUT ${rolling_mesh}
  COMMAND ${mesh_python} ${PROJECT_SOURCE_DIR}/scripts/make_meshes.py --rolling ${rolling_mesh}
  DEPENDS ${PROJECT_SOURCE_DIR}/scripts/make_meshes.py
  COMMENT "Making the rolling terrain")
add_custom_target(${PROJECT_NAME}_meshes ALL DEPENDS ${rolling_mesh})
#catkin_lint: ignore_once external_file
install(FILES ${rolling_mesh} DESTINATION ${package_share}/meshes)

# trade_off draws its plots with it, wherever it runs.
file(MAKE_DIRECTORY ${devel_prefix}/${package_share}/scripts)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/scripts/plot_trade_off ${devel_prefix}/${package_share}/scripts/plot_trade_off SYMBOLIC)
install(PROGRAMS scripts/plot_trade_off DESTINATION ${package_share}/scripts)

if(with_ros)
  # Python programs run by roslaunch and rosrun; catkin makes them callable from the build tree too.
  catkin_install_python(PROGRAMS scripts/convoy_follower scripts/path_follower scripts/place_vehicle scripts/plot_run scripts/scripted_driver
    scripts/square_driver scripts/teleop_keyboard scripts/vehicle_description scripts/wheel_speed_controller
    DESTINATION ${package_programs})
  install(PROGRAMS scripts/record_bag DESTINATION ${package_programs})
  install(FILES scripts/ackermann_message.py scripts/shipped_files.py DESTINATION ${package_programs})
  # simulator.launch calls it by the same path below the package, whether that is the checkout or installed.
  install(PROGRAMS scripts/vehicle_description DESTINATION ${package_share}/scripts)
  install(FILES scripts/shipped_files.py DESTINATION ${package_share}/scripts)
endif()
