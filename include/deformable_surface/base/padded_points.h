// A copy of points with four numbers each, so that one vector instruction loads a point.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface {

class PaddedPoints {
 public:
  /// Allocates only when there are more points than before.
  void assign(const Points& points) {
    values_.resize(4 * points.size());
    double* to = values_.data();
    for (const Vec3& p : points) {
      to[0] = p.x();
      to[1] = p.y();
      to[2] = p.z();
      to[3] = 0.0;
      to += 4;
    }
  }

  /// Appends a point. Allocates only when there are more than ever before.
  void append(const Vec3& p) { values_.insert(values_.end(), {p.x(), p.y(), p.z(), 0.0}); }
  /// Keeps the first `size` points.
  void shorten(std::size_t size) { values_.resize(4 * size); }

  std::size_t size() const { return values_.size() / 4; }
  /// x, y, z, 0 of point i are at data() + 4 i.
  const double* data() const { return values_.data(); }

 private:
  std::vector<double> values_;
};

}  // namespace deformable_surface
