// CMakeLists.txt reads the number from package.xml and passes it to this file alone.
#include "deformable_surface/base/version.h"

namespace deformable_surface {

const char* version() { return DEFORMABLE_SURFACE_VERSION; }

}  // namespace deformable_surface
