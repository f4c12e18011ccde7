// Checks names that come over ROS and become names of files or of stored items: they cannot leave a directory, be hidden or
// look like an option.
#pragma once

#include <algorithm>
#include <string>

namespace deformable_surface::node {

constexpr std::size_t kLongestName = 64;
constexpr char kBareNames[] = "up to 64 letters, digits, '.', '_' and '-', the first a letter or digit";

inline bool isBareName(const std::string& name) {
  const auto isAlphanumeric = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); };
  return !name.empty() && name.size() <= kLongestName && isAlphanumeric(name[0]) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return isAlphanumeric(c) || c == '.' || c == '_' || c == '-'; });
}

}  // namespace deformable_surface::node
