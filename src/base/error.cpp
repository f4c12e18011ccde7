// The text of an InputError.
#include "deformable_surface/base/error.h"

#include "deformable_surface/base/value.h"

namespace deformable_surface {

std::string InputError::joinLines(std::vector<std::string>& lines) {
  std::string all;
  for (std::string& line : lines) {
    line = toPrintable(line);
    all += (all.empty() ? "" : "\n") + line;
  }
  return all;
}

}  // namespace deformable_surface
