// A copy of points with four numbers each, so that one vector instruction loads a point.
#pragma once

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface {

class PaddedPoints {
 public:
  /// Allocates only when there are more points than before.
  void assign(const Points& points) {
    values_.resize(4 * points.size());
    constexpr Index kBlock = 1024;  // points per task: about a microsecond of work
    parallelFor(static_cast<Index>(points.size()), kBlock, [&](Index begin, Index end) {
      double* to = values_.data() + 4 * begin;
      for (Index i = begin; i < end; ++i, to += 4) {
        to[0] = points[i].x();
        to[1] = points[i].y();
        to[2] = points[i].z();
        to[3] = 0.0;
      }
    });
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
