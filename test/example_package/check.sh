#!/usr/bin/env bash
# Installs what a build folder holds below a temporary folder, builds an example package against it, and runs it there.
# Usage: check.sh BUILD_FOLDER example_package|example_catkin_package
set -euo pipefail
build=$1 example=$2
repository=$(cd -P "$(dirname "$0")/../.." && pwd)
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
fail() { echo "$example: $*" >&2; exit 1; }

# Setup scripts of Python packages know the configured prefix only, so the tree lies at that path below the temporary folder.
DESTDIR=$temporary cmake --install "$build" >"$temporary/install.log" 2>&1 || { cat "$temporary/install.log"; fail "cannot be installed"; }
configured=$(sed -n 's/^CMAKE_INSTALL_PREFIX:PATH=//p' "$build/CMakeCache.txt")
prefix=$temporary$configured
[ ! -e "$prefix/include/deformable_surface/simulation/loads.h" ] || fail "found an internal header in the installed tree"
# catkin writes the configured prefix into its file; this is what it would say if the tree were there.
find "$prefix/share" -name 'deformable_surfaceConfig.cmake' -exec sed -i "s|$configured|$prefix|g" {} + 2>/dev/null || true

# A copy, whose version can be changed. What the workspace holds (CMAKE_PREFIX_PATH) is not to be found before what is installed.
cp -r "$repository/test/$example" "$temporary/source"
export PATH=/usr/bin:/bin:$PATH  # the Python that catkin belongs to
configure() { cmake -S "$temporary/source" -B "$1" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix;/opt/ros/noetic" >"$1.log" 2>&1; }
configure "$temporary/build" || { cat "$temporary/build.log"; fail "cannot be configured"; }
found=$(sed -n 's/^deformable_surface_DIR:PATH=//p' "$temporary/build/CMakeCache.txt")
[[ $found == "$prefix"/* ]] || fail "found the package in $found; accepted: below $prefix"
cmake --build "$temporary/build"

export LD_LIBRARY_PATH=$prefix/lib:${LD_LIBRARY_PATH:-}
cd "$temporary"
case $example in
  example_package)
    output=$(build/hanging_sheet)
    version=$(sed -n 's|.*<version>\(.*\)</version>.*|\1|p' "$repository/package.xml")
    [[ $output == *"deformable_surface $version"* ]] || fail "found another version than $version in: $output"
    # A version with other public names is refused.
    sed -i -E 's/(find_package\(deformable_surface) [0-9.]+/\1 0.0/' source/CMakeLists.txt
    ! configure "$temporary/other" || fail "found version 0.0 accepted"
    grep -q 'version: ' "$temporary/other.log" || { cat "$temporary/other.log"; fail "found another reason to refuse version 0.0"; }
    ;;
  example_catkin_package)
    output=$(build/devel/lib/run_scene/run_scene "$repository/scenes/sheet_hanging.yaml" result.ply)
    [ -s result.ply ] || fail "found no result"
    ;;
esac
echo "$output"
# Infinite where it cannot be told.
[[ $output =~ estimated\ error:?\ ([0-9.e-]+|inf)\ m ]] || fail "found no error estimate"
