// Greedy thinning with lazily updated keys: the point with the smallest ring is removed, until few are left.
#pragma once

#include "deformable_surface/cloud/simplification.h"

namespace deformable_surface::cloud {

/// Fewer points span no surface: smaller parts are not thinned further.
constexpr Index kMinPartPoints = 3;

/// What is to be thinned; n points in parts.
struct RingCloud {
  const Points &positions, &normals;  // (n x 3), m; unit
  const std::vector<double>& wanted;  // (n) spacings over the mean, or empty: everywhere the same
  Index k;                            // neighbours of a star
  Lists neighbors;                    // (n) nearest first, also of other parts
  std::vector<Index> part;            // (n) below the number of parts
  const std::vector<char>& left_out;  // (parts) go first, and wholly
  bool over_surface;                  // stars never look across a gap that the neighbours show
};

/// See simplify(): keys, ties and parts are stated there. Ends at min_points, or once only points that stay are left; stays: (n)
/// never removed. The same for any number of threads. O(n k log n).
Simplification thinByRings(RingCloud cloud, Index min_points, const std::vector<char>& stays);

}  // namespace deformable_surface::cloud
