# Sourced by scripts/test and scripts/demo: packages, build, environment. Needs `checkout` to be set.

# Debian's programs and its Python first: a pyenv's python3 knows no ROS.
PATH=/usr/bin:/bin:/usr/sbin:/sbin:$PATH
# Somebody else's ROS network is none of ours.
unset ROS_MASTER_URI ROS_IP ROS_NAMESPACE
# No __pycache__ in the checkout.
export PATH ROS_HOSTNAME=localhost PYTHONDONTWRITEBYTECODE=1
build=${ELLIPSOID_VEHICLE_SIM_BUILD:-$checkout/build}
configure_options=()

say() { printf '%s\n' "$*"; }
fail() { # exit code, text
  printf '%s\n' "${*:2}" >&2
  exit "$1"
}

# Installs what is missing of scripts/packages.txt, or of another list there; asks the package lists only then.
install_missing_packages() {
  local list=${1:-packages.txt}
  if [ -e /opt/ros/noetic/setup.bash ]; then
    return  # Ubuntu: rosdep knows the names there (README)
  fi
  command -v dpkg-query > /dev/null || fail 2 "this is no Debian: install by hand what scripts/$list lists"
  local wanted missing sudo=()
  mapfile -t wanted < <(sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$checkout/scripts/$list")
  # A package that dpkg has never heard of gives an error line and no output: it is missing too.
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}" | sort) \
    <(dpkg-query -W -f='${db:Status-Abbrev} ${Package}\n' "${wanted[@]}" 2> /dev/null | sed -n 's/^ii *//p' | sort))
  [ ${#missing[@]} -eq 0 ] && return
  local options=(-y --no-install-recommends -o DPkg::Lock::Timeout=300)
  if [ "$(id -u)" -ne 0 ]; then
    if ! sudo -n true 2> /dev/null; then
      fail 2 "packages are missing, and installing them needs root. As root:
apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install ${options[*]} ${missing[*]}"
    fi
    sudo=(sudo -n)
  fi
  say "installing ${#missing[@]} packages: ${missing[*]}"
  "${sudo[@]}" apt-get -o DPkg::Lock::Timeout=300 update -q || fail 2 "apt-get update failed"
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q "${options[@]}" "${missing[@]}" ||
    fail 2 "apt-get install failed"
}

# Configures (with configure_options too) and builds the given targets (none: all). One at a time for each build folder, whoever asks.
# With ELLIPSOID_VEHICLE_SIM_NO_BUILD what is there is taken as it is: for tests, while others use the build folder.
build_checkout() {
  [ -n "${ELLIPSOID_VEHICLE_SIM_NO_BUILD:-}" ] && return
  mkdir -p "$build" || fail 2 "cannot write to $build; set ELLIPSOID_VEHICLE_SIM_BUILD to another folder"
  exec 9> "$build/.lock"
  flock -n 9 || { say "waiting for another build in $build"; flock 9; }
  # A checkout that was moved or copied brings a cache that points to its old place.
  if [ -e "$build/CMakeCache.txt" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$checkout" "$build/CMakeCache.txt"; then
    find "$build" -mindepth 1 -maxdepth 1 ! -name .lock -exec rm -rf {} +
  fi
  local log=$build/build.log targets=()
  [ $# -gt 0 ] && targets=(--target "$@")
  say "building in $build (log: $log)"
  if ! { cmake -S "$checkout" -B "$build" -DBUILD_ROS=ON -DCMAKE_INSTALL_PREFIX="$build/install" "${configure_options[@]}" &&
    cmake --build "$build" -j "$(nproc)" "${targets[@]}"; } > "$log" 2>&1; then
    tail -n 60 "$log" >&2
    fail 1 "the build failed; the whole log is in $log"
  fi
  flock -u 9
  exec 9>&-
}

# Programs of scripts/fuzz in $build/fuzz, from this checkout and the libraries of its ordinary build.
build_fuzzers() {
  mkdir -p "$build/fuzz" || fail 2 "cannot write to $build/fuzz"
  exec 9> "$build/fuzz/.lock"
  flock 9
  local log=$build/fuzz/build.log
  say "building in $build/fuzz (log: $log)"
  if ! { cmake -S "$checkout/test/fuzz" -B "$build/fuzz" -DCMAKE_CXX_COMPILER=clang++ -DLIBRARIES="$build/devel/lib" &&
    cmake --build "$build/fuzz" -j "$(nproc)"; } > "$log" 2>&1; then
    tail -n 60 "$log" >&2
    fail 2 "the build of the fuzzers failed; the whole log is in $log"
  fi
  flock -u 9
  exec 9>&-
}

# ROS as the build tree offers it. Its scripts trip over `set -u`.
enter_ros_environment() {
  set +u
  if [ -e /opt/ros/noetic/setup.bash ]; then
    . /opt/ros/noetic/setup.bash
  fi
  . "$build/devel/setup.bash"
  set -u
  export ROS_HOSTNAME=localhost
}
