// The folder of clouds and meshes that developers have and that are not shipped. scripts/common.sh looks for it.
#pragma once

#include <cstdlib>
#include <string>

namespace deformable_surface::test {

/// Empty if the folder is not known.
inline std::string sharedFolder() {
  const char* given = std::getenv("DEFORMABLE_SURFACE_DATA");
  return given ? given : "";
}

}  // namespace deformable_surface::test
