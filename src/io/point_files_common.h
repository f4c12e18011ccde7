// Shared by the readers and writers of point files.
#pragma once

#include "deformable_surface/base/error.h"

#include <string>

namespace deformable_surface::io {

[[noreturn]] inline void refuse(const std::string& file, const std::string& sentence) {
  throw InputError(file + ": " + sentence);
}

inline std::string toLowerExtension(const std::string& file) {
  const std::size_t dot = file.find_last_of("./");
  std::string extension = dot == std::string::npos || file[dot] == '/' ? "" : file.substr(dot);
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

}  // namespace deformable_surface::io
