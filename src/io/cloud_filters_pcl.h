// The filters that use PCL, without PCL's types.
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

/// The plane with the most points (finite) within a distance. It is searched among about a thousand points and fitted to all
/// that lie on it; none if no three points span one. A plane with min_share of the points is missed once in ten thousand times.
std::optional<Plane> findLargestPlane(const Points& points, double distance, double min_share);

/// Marks isolated points; points: finite.
std::vector<char> findOutliers(const Points& points, const simulation::OutlierParams& params);

}  // namespace deformable_surface::io
