// A scalar field sampled on a regular grid, such as a computed tomography or a distance field, and how far a place is from one of
// its iso-surfaces.
#pragma once

#include "deformable_surface/base/types.h"

#include <array>
#include <vector>

namespace deformable_surface::geometry {

class Volume {
 public:
  /// size: samples along each axis; origin: place of the first, m; axes: the columns lead from a sample to the next along each
  /// axis, m; values: the first axis is the fastest. Throws InputError if there are fewer than two samples along an axis or not
  /// as many values as samples, if one is not finite, or if the axes are not at right angles.
  Volume(const std::array<Index, 3>& size, const Vec3& origin, const Mat3& axes, std::vector<float> values);

  const std::array<Index, 3>& size() const { return size_; }
  const std::vector<float>& values() const { return values_; }
  double least() const { return least_; }
  double largest() const { return largest_; }
  /// Place of a sample, m.
  Vec3 place(Index i, Index j, Index k) const { return origin_ + axes_ * Vec3(i, j, k); }

  struct Sample {
    double value;     // between samples linear along each axis
    Vec3 gradient;    // per m: differences over a sample to both sides, which are continuous
    double distance;  // m, from the border of the grid; negative outside, where value and gradient are those of the border
  };
  Sample sample(const Vec3& place) const;

 private:
  double interpolate(const Vec3& grid_place) const;

  std::array<Index, 3> size_;
  Vec3 origin_;
  Mat3 axes_, to_grid_;
  Vec3 steps_;  // m, lengths of the axes
  std::vector<float> values_;
  double least_ = 0.0, largest_ = 0.0;
};

/// Distance of a place from the iso-surface by one step of Newton's method along the gradient, (value - iso) / |gradient|, m;
/// positive inside, which is where the values are larger (side: 1) or smaller (-1). The grid ends the inside: nowhere is the
/// distance larger than that from its border. Where the gradient vanishes it is infinite.
double findIsoDistance(const Volume& volume, double iso_value, double side, const Vec3& place);

}  // namespace deformable_surface::geometry
