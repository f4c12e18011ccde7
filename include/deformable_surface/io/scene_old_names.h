// Names that scenes, topics and quantities had in the version before. They go on working for one version, with a notice that
// names the new one; then this file and what uses it go.
#pragma once

#include "deformable_surface/base/value.h"

#include <string>
#include <vector>

namespace deformable_surface::io {

/// "OLD is now called NEW; the old name goes with version ...".
std::string tellNewName(const std::string& old_name, const std::string& name);

/// Puts what a scene gives under old names under the new ones. Returns a notice for each. Throws InputError if a value is given
/// under both; a default beside the old name does not count, since scenes that state every value are loaded below others.
std::vector<std::string> renameOldKeys(Value& scene);

/// What a quantity of `expect` is called now; the same if that is no old name.
std::string findNewQuantity(const std::string& name);

}  // namespace deformable_surface::io
