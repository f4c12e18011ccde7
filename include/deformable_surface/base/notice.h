// Joins the notices of one step in one line. Every room that takes part in a step uses it.
#pragma once

#include <string>

namespace deformable_surface {

/// Adds one more sentence to a notice, after a semicolon; an empty one changes nothing.
inline void appendNotice(std::string& notice, const std::string& more) {
  if (!more.empty()) notice += (notice.empty() ? "" : "; ") + more;
}

/// The part of a sentence that tells its cause from others: quoted names as they are, the rest without characters of numbers.
std::string withoutNumbers(const std::string& sentence);

}  // namespace deformable_surface
