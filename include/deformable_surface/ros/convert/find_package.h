// Folders of ROS packages, for the functions of io that take package://NAME/PATH.
#pragma once

#include <string>

namespace deformable_surface::node {

/// The folder of a package, found by ROS. In an install space without a ROS environment, the folder of this package beside the
/// program. An io::FindPackage. Throws InputError.
std::string findPackage(const std::string& package);

}  // namespace deformable_surface::node
