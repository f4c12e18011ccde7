#include "deformable_surface/ros/convert/find_package.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <ros/package.h>

#include <algorithm>
#include <filesystem>
#include <vector>

namespace deformable_surface::node {

namespace fs = std::filesystem;

std::string findPackage(const std::string& package) {
  // Asking for a package that does not exist would write to the terminal.
  std::vector<std::string> known;
  ros::package::getAll(known);
  if (std::find(known.begin(), known.end(), package) != known.end()) return ros::package::getPath(package);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path() / "../../share" / package;
  if (!error && fs::is_directory(installed, error)) return installed.lexically_normal().string();
  throw InputError("package " + quote(package) + ": not found; accepted: packages on ROS_PACKAGE_PATH");
}

}  // namespace deformable_surface::node
