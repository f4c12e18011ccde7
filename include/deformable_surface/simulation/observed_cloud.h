// A cloud that a surface is to be drawn towards, made ready to be looked into. Apart from the load that draws, because this takes
// long for large clouds and may be done by any thread beforehand.
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
