# Sourced by scripts/test --sanitize: build and surroundings of programs that watch themselves.

# What is left out of a run with sanitizers, and why.
tests_without_sanitizers=(
  "consumer: builds a program of somebody else's, without sanitizers, against the installed library"
  "installed_launch: builds and installs once more"
  "fuzz: has its own sanitizers"
  "soak: memory and answering times are those of the sanitizer"
  "documented_commands: its programs run in the tests of their own"
)

use_sanitizers() { # address,undefined | thread
  case $1 in
    address,undefined | thread) ;;
    *) fail 2 "--sanitize is '$1'; allowed are 'address,undefined' and 'thread'" ;;
  esac
  build=$build-${1%%,*}
  configure_options=("-DSANITIZE=$1" -DBUILD_BENCHMARKS=OFF)
  local line names=
  for line in "${tests_without_sanitizers[@]}"; do
    say "left out: $line"
    names+=${names:+|}${line%%:*}
  done
  left_out=(-E "^($names)\$")
  # Deadlines, not physics, are this much longer (test/support/slowdown.h, test/ros/sim_test_tools.py).
  export ELLIPSOID_VEHICLE_SIM_SLOWDOWN=10
  # Reports go to files: a node that roslaunch started has nobody who reads its exit code.
  sanitizer_reports=$(mktemp -d) || exit 1
  local suppressions=$checkout/test/sanitizers
  export ASAN_OPTIONS=log_path=$sanitizer_reports/address:detect_stack_use_after_return=1:strict_string_checks=1
  export LSAN_OPTIONS=suppressions=$suppressions/leak.txt:print_suppressions=0
  export UBSAN_OPTIONS=log_path=$sanitizer_reports/undefined:print_stacktrace=1
  export TSAN_OPTIONS=log_path=$sanitizer_reports/thread:suppressions=$suppressions/thread.txt:history_size=4
}

# Prints what the sanitizers found; fails if they found anything.
tell_sanitizer_reports() {
  local reports=("$sanitizer_reports"/*)
  if [ ! -e "${reports[0]}" ]; then
    rmdir "$sanitizer_reports"
    say "the sanitizers found nothing"
    return 0
  fi
  head -n 60 "${reports[@]:0:5}"
  say "the sanitizers left ${#reports[@]} reports in $sanitizer_reports"
  return 1
}
