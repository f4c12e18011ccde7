// Folders of ROS packages, for the functions of io that take package://NAME/PATH.
#pragma once

#include <string>

namespace deformable_surface::node {

/// The folder of a package by ROS, else of this one beside the program in an install space without a ROS environment. An
/// io::FindPackage. Throws InputError.
std::string findPackage(const std::string& package);

}  // namespace deformable_surface::node
