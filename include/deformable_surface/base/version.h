// The version of the running library, for logs and bug reports. The number is in package.xml only.
#pragma once

namespace deformable_surface {

/// As "0.1.0": major, minor and patch (docs/cpp_api.md says what may change between them).
const char* version();

}  // namespace deformable_surface
