// The filters that PCL does, without PCL's types.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/simulation/input_filter_params.h"

#include <optional>
#include <vector>

namespace deformable_surface::io {

/// normal . p + offset = 0, |normal| = 1; m.
struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0.0;

  double height(const Vec3& p) const { return normal.dot(p) + offset; }
};

/// The plane that most of the points (finite) lie on within a distance, found among some thousand of them and fitted to those
/// that lie on it; nothing if no three of them span one. One that holds min_share of them is missed once in ten thousand times.
std::optional<Plane> findLargestPlane(const Points& points, double distance, double min_share);

/// Marks those of the points (finite) that are alone.
std::vector<char> findOutliers(const Points& points, const simulation::OutlierParams& params);

}  // namespace deformable_surface::io
