# cmake -D build=<build tree of the project> -D source=<this folder> -D compiler=<c++> -P build_and_run.cmake
# Installs the core into a folder of its own, builds the consumer against it alone, runs it, and looks for ROS libraries.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "failed (${failed}): ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(mktemp -d)
string(STRIP "${output}" scratch)
run(${CMAKE_COMMAND} --install ${build} --prefix ${scratch}/prefix --component core)
run(${CMAKE_COMMAND} -S ${source} -B ${scratch}/build -DCMAKE_PREFIX_PATH=${scratch}/prefix
  -DCMAKE_CXX_COMPILER=${compiler} -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${scratch}/build)
run(${scratch}/build/consumer)
if(NOT output STREQUAL "height 2\n")
  message(FATAL_ERROR "the consumer printed '${output}', expected 'height 2'")
endif()
run(ldd ${scratch}/build/consumer)
if(output MATCHES "not found")
  message(FATAL_ERROR "unresolved libraries:\n${output}")
endif()
# Libraries that come from ROS packages; the core must need none of them.
if(output MATCHES "lib(ros|tf2?|urdf|xmlrpcpp|cpp_common|class_loader|catkin)[a-z0-9_]*\\.so")
  message(FATAL_ERROR "the core pulls in a ROS library:\n${output}")
endif()
file(REMOVE_RECURSE ${scratch})
