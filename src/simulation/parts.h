// The parts that a surface or body is in: what is connected with nothing else. Private, and apart from how they are built and
// stepped, because both ask which of them nothing holds.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

/// Parts of n points, numbered in the order of their smallest index.
struct Parts {
  std::vector<Index> label;  // (n) the part of each point
  std::vector<Index> size;   // points of each part

  Index count() const { return static_cast<Index>(size.size()); }
};

Parts findParts(Index n, const std::vector<std::pair<Index, Index>>& links);

/// Marks (n, 1) the points of that many largest parts, of equal ones the first.
std::vector<char> markLargest(const Parts& parts, Index most);

/// Of a scene with input.keep_parts: leaves only that many largest parts of the dense points. The points of the others become
/// holes of the input.
void keepLargestParts(const SceneParams& params, const Parts& parts, RestSurface& s);

/// Adds to the notes or warnings how many parts there are, if several, and which of them neither a pin nor an anchor holds.
void noteParts(const SceneParams& params, RestSurface& s);

/// Of an equilibrium: the parts that neither a held point nor a load that resists motion (marked in resisted) holds, though their
/// loads do not sum to zero.
struct LooseParts {
  std::vector<char> is_loose;  // (n)
  Index parts = 0, points = 0;
  bool are_all = false;        // all parts that there are
  double load = 0.0;           // N, the sum of the loads on the first of them
  Vec3 place = Vec3::Zero();   // m, one of its points

  /// What a user should know of those that stay where they are.
  std::string describe() const;
};
LooseParts findLooseParts(const Parts& parts, const std::vector<char>& held, const std::vector<char>& resisted,
                          const Points& loads, const Points& positions);

}  // namespace deformable_surface::simulation
