// A cloud to track, prepared for searches. For large clouds the preparation takes long. Any thread may do it before the load
// (track_load.h) gets it.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/point_cloud.h"

namespace deformable_surface::simulation {

class ObservedCloud {
 public:
  /// Throws InputError for fewer than three points that are finite and distinct. O(n log n).
  explicit ObservedCloud(const cloud::PointCloud& cloud);

  const Points& points() const { return points_; }     // finite, distinct
  const cloud::KdTree& tree() const { return tree_; }  // of these

 private:
  Points points_;
  cloud::KdTree tree_;
};

}  // namespace deformable_surface::simulation
