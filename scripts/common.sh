# Sourced by the other scripts: paths, needed packages, and the build of the workspace, the same for demo, tests and
# pictures. bash only.
set -euo pipefail

repository=$(cd -P "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
workspace=${DEFORMABLE_SURFACE_WORKSPACE:-$repository/.ws}  # ignored by git
jobs=${DEFORMABLE_SURFACE_JOBS:-$(nproc)}
# The system's Python first: ROS programs start with "env python3", and another Python in front of it lacks their modules.
export PATH=/usr/bin:/bin:$PATH

fail() { echo "$(basename "$0"): $*" >&2; exit 1; }

# Real scans, where a folder of them is beside the repository: tests and benchmarks that need one leave it out without it.
if [ -z "${DEFORMABLE_SURFACE_DATA:-}" ] && [ -d "$repository/../shared/data" ]; then
  DEFORMABLE_SURFACE_DATA=$(cd "$repository/../shared/data" && pwd)
fi
export DEFORMABLE_SURFACE_DATA=${DEFORMABLE_SURFACE_DATA:-}

# ---- packages ----

debian_packages=(
  catkin cmake make g++ python3-minimal
  libroscpp-dev libroslib-dev libxmlrpcpp-dev libtf2-ros-dev libtf2-geometry-msgs-dev libtf2-msgs-dev tf2-tools
  libdynamic-reconfigure-config-init-mutex-dev python3-dynamic-reconfigure
  libactionlib-dev libactionlib-msgs-dev ros-actionlib-msgs python3-actionlib python3-actionlib-msgs
  libstd-msgs-dev ros-std-msgs libstd-srvs-dev ros-std-srvs
  libgeometry-msgs-dev ros-geometry-msgs libsensor-msgs-dev ros-sensor-msgs libshape-msgs-dev ros-shape-msgs
  libvisualization-msgs-dev ros-visualization-msgs libdiagnostic-msgs-dev ros-diagnostic-msgs ros-message-generation
  libdiagnostic-updater-dev libnodelet-dev libnodeletlib-dev libnodeletlib-tools pluginlib-dev
  libinteractive-markers-dev python3-tf2-ros
  librosbag-dev python3-rosbag python3-roslaunch python3-rostopic rosbash
  python3-rosservice python3-rosnode python3-rosmsg python3-std-srvs python3-visualization-msgs python3-diagnostic-msgs
  python3-rospy python3-std-msgs python3-geometry-msgs python3-sensor-msgs python3-shape-msgs
  libros-rosgraph-msgs-dev
  librostest-dev python3-rostest libgtest-dev libgmock-dev
  libeigen3-dev libyaml-cpp-dev libpcl-dev libassimp-dev liburdf-dev
  python3-matplotlib python3-numpy python3-yaml python3-scipy python3-distributed python3-setuptools catkin-lint iproute2
)
noetic_packages=(
  build-essential ros-noetic-ros-base ros-noetic-dynamic-reconfigure ros-noetic-actionlib ros-noetic-actionlib-msgs
  ros-noetic-tf2-geometry-msgs ros-noetic-tf2-msgs ros-noetic-rosgraph-msgs ros-noetic-shape-msgs ros-noetic-visualization-msgs
  ros-noetic-diagnostic-updater ros-noetic-interactive-markers ros-noetic-nodelet ros-noetic-pluginlib ros-noetic-rosbag ros-noetic-rostest
  ros-noetic-urdf libgtest-dev libgmock-dev libeigen3-dev libyaml-cpp-dev libpcl-dev libassimp-dev
  python3-matplotlib python3-numpy python3-yaml python3-scipy python3-distributed python3-setuptools iproute2
)
debian_rviz_packages=(rviz)
noetic_rviz_packages=(ros-noetic-rviz)
picture_packages=(xvfb x11-utils imagemagick xdotool)

have_noetic() { [ -f /opt/ros/noetic/setup.bash ] || apt-cache show ros-noetic-ros-base >/dev/null 2>&1; }

# Root needs no sudo, and containers have none.
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else fail "this needs root or sudo: $*"; fi
}

# Installs the named packages that are missing. Uses no network if there are none.
install_packages() {
  local package missing=()
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)" = installed ] || missing+=("$package")
  done
  if [ ${#missing[@]} = 0 ]; then
    echo "packages: all $# are there"
    return
  fi
  echo "packages: installing ${#missing[@]} of $#: ${missing[*]}"
  as_root apt-get update -qq
  # Its progress comes on the standard output, since sudo closes all other files.
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends -o APT::Status-Fd=1 "${missing[@]}" |
    show_progress
}

# Of what apt prints: how much there is to be installed, and every tenth of its progress. That comes as lines
# "dlstatus:N:PERCENT:TEXT" and "pmstatus:PACKAGE:PERCENT:TEXT", where a package may have a colon in its name.
show_progress() {
  awk -F: '
    / newly installed,|^Need to get |^After this operation,/ { print "packages: " $0; fflush() }
    $1 != "dlstatus" && $1 != "pmstatus" { next }
    {
      for (i = 2; i <= 4; ++i) if ($i ~ /^[0-9.]+$/) percent = $i
      tenth = int(percent / 10)
    }
    $1 != stage || tenth > last {
      printf "packages: %s %d %%\n", $1 == "dlstatus" ? "downloaded" : "installed", 10 * tenth
      fflush()
      stage = $1
      last = tenth
    }'
}

# Everything the build, the tests and the demo need; "install_deps rviz" and "install_deps rviz pictures" add to it.
install_deps() {
  local packages=() part
  command -v apt-get >/dev/null || fail "no apt-get here; install the dependencies of package.xml by hand"
  if have_noetic; then packages=("${noetic_packages[@]}"); else packages=("${debian_packages[@]}"); fi
  for part in "$@"; do
    case $part in
      rviz) if have_noetic; then packages+=("${noetic_rviz_packages[@]}"); else packages+=("${debian_rviz_packages[@]}"); fi ;;
      pictures) packages+=("${picture_packages[@]}") ;;
      *) fail "install_deps: unknown part '$part'; accepted: rviz, pictures" ;;
    esac
  done
  install_packages "${packages[@]}"
}

# ---- ROS ----

# ROS's setup files read variables that are not set, hence set +u.
# shellcheck disable=SC1090  # which file, only the run knows
source_setup() { set +u; . "$1"; set -u; }

enter_ros() {
  if [ -f /opt/ros/noetic/setup.bash ]; then source_setup /opt/ros/noetic/setup.bash; fi
  # The name of a container often does not resolve, and then no node reaches another.
  if [ -z "${ROS_IP:-}" ] && [ -z "${ROS_HOSTNAME:-}" ]; then
    case ${ROS_MASTER_URI:-http://localhost:11311} in
      *//localhost:* | *//127.0.0.1:*) export ROS_IP=127.0.0.1 ;;
    esac
  fi
}

# build [target ...]: builds the workspace, whose only package is this repository, and enters it. Both Python variables are
# needed: catkin reads the first, the ament macros that Debian's pluginlib calls read the second.
build() {
  # The package in the workspace is a folder of links to what the repository holds: a link to the repository itself would contain
  # the workspace again, and tools that follow links would go round in it.
  local package=$workspace/src/deformable_surface entry
  [ ! -L "$package" ] || rm "$package"
  mkdir -p "$package"
  find "$package" -mindepth 1 -maxdepth 1 -type l -delete
  for entry in "$repository"/*; do ln -s "$entry" "$package/"; done
  enter_ros
  (cd "$workspace" && catkin_make -j"$jobs" -DCMAKE_BUILD_TYPE=Release \
    -DPYTHON_EXECUTABLE=/usr/bin/python3 -DPython3_EXECUTABLE=/usr/bin/python3 "$@")
  source_setup "$workspace/devel/setup.bash"
}
