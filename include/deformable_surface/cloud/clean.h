// From the raw cloud to the points that can be simulated: finite and distinct. Keeps the map back to the user's order.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/point_cloud.h"

#include <memory>

namespace deformable_surface::cloud {

struct CleanCloud {
  Points positions;                    // (m x 3) finite, pairwise distinct
  Points normals;                      // (m x 3) or empty; unit; rows that the input left zero or not finite are zero
  std::vector<Index> point_of_input;   // (n) index into positions, -1 for holes; coincident input points share one
  Index num_not_finite = 0;            // input points that are holes
  Index num_coincident = 0;            // input points that share another's position exactly
  std::shared_ptr<const KdTree> tree;  // of the positions when they were last searched; null: none is kept
};

/// Filters the cloud. Points with a coordinate above max_coordinate (m) in magnitude count as not finite: squared distances
/// would lose the surface in rounding. The order of the first occurrences is kept. O(n log n).
CleanCloud clean(const PointCloud& input, double max_coordinate = 1e6);

/// A tree of the positions: the one that is kept, unless they have changed since. O(n), else O(n log n).
std::shared_ptr<const KdTree> findTree(const CleanCloud& cloud);

}  // namespace deformable_surface::cloud
