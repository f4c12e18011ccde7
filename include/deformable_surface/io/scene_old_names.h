// Names that scenes, topics and quantities had in the last version. They work for one more version, with a notice of the
// new name. Then this file and its uses are deleted.
#pragma once

#include "deformable_surface/base/value.h"

#include <string>
#include <vector>

namespace deformable_surface::io {

/// "OLD is now called NEW; the old name goes with version ...".
std::string describeNewName(const std::string& old_name, const std::string& name);

/// Renames old keys of a scene. Returns a notice for each. Throws InputError if a value is given
/// under both names; a default beside the old name does not count: scenes that state every value are loaded below others.
std::vector<std::string> renameOldKeys(Value& scene);

/// The present name of a quantity of `expect`; the name itself if it is not an old one.
std::string findNewQuantity(const std::string& name);

}  // namespace deformable_surface::io
