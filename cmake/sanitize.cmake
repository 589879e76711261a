# Builds for looking at the program from inside: scripts/test --sanitize asks for them, each in a build folder of its own. Every finding ends the program: what goes on after one would only hide it.
set(SANITIZE "" CACHE STRING "Sanitizers to build everything with: address,undefined or thread; empty: none")

if(SANITIZE)
  # Assertions stay in, Eigen's among them.
  set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1 -fno-omit-frame-pointer -fsanitize=${SANITIZE} -fno-sanitize-recover=all")
  set(CMAKE_EXE_LINKER_FLAGS_SANITIZE "")
  set(CMAKE_SHARED_LINKER_FLAGS_SANITIZE "")
  set(CMAKE_BUILD_TYPE Sanitize CACHE STRING "Set by SANITIZE" FORCE)
endif()
