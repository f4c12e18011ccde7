// Text of notices: counts, places, and the notices of one step in one line. Every room that takes part in a step uses it.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>

namespace deformable_surface {

/// Adds one more sentence to a notice, after a semicolon; an empty one changes nothing.
inline void appendNotice(std::string& notice, const std::string& more) {
  if (!more.empty()) notice += (notice.empty() ? "" : "; ") + more;
}

/// "3 points".
inline std::string formatCount(Index n, const std::string& what) { return std::to_string(n) + " " + what; }

/// "(0.1, 0, 2)": three digits, and far from the origin as many as tell points apart.
std::string formatPlace(const Vec3& p);

/// The part of a sentence that tells its cause from others: quoted names as they are, the rest without characters of numbers.
std::string withoutNumbers(const std::string& sentence);

}  // namespace deformable_surface
