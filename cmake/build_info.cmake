# Run at every build with -D source=... -D output=... -D version=... -D compiler=... -D flags=...: writes what run manifests say
# of the program, and touches the file only if something has changed.
set(commit "unknown")
find_program(git_program git)
if(git_program)
  # Only a repository of our own: a copy that lies in somebody else's has no commit.
  execute_process(COMMAND ${git_program} -C ${source} rev-parse --show-toplevel
    OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  get_filename_component(real_source ${source} REALPATH)
  if(top STREQUAL real_source)
    execute_process(COMMAND ${git_program} -C ${source} describe --always --dirty --abbrev=12 --exclude=*
      OUTPUT_VARIABLE described RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT failed)
      set(commit ${described})
    endif()
  endif()
endif()
set(text "#define BUILD_INFO_VERSION \"${version}\"
#define BUILD_INFO_COMMIT \"${commit}\"
#define BUILD_INFO_COMPILER \"${compiler}\"
#define BUILD_INFO_FLAGS \"${flags}\"
")
set(old "")
if(EXISTS ${output})
  file(READ ${output} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${output} "${text}")
endif()
