// The surface that oriented particles suggest near a point: who sees whom, and the place and orientation of a particle put
// there. Both rules of growth stand on it.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/growth.h"

namespace deformable_surface::model {

/// Share of a distance that rounding of float coordinates may take from it: the particles of a perfect lattice are as far apart
/// as they should be, and the neighbours of a vacancy in it leave it clear.
constexpr double kRounding = 1e-6;

struct Placed {
  Vec3 position;
  Eigen::Quaterniond orientation;
};

class LocalSurface {
 public:
  /// Throws InputError for arrays of different lengths and for numbers that are not finite.
  LocalSurface(const Points& positions, const Orientations& orientations);

  /// True if two particles may be parts of one sheet: normals less than 90 degrees apart, line at most 30 degrees from the
  /// plane of their mean. Circles are seen whatever their curvature: there the line lies in that plane. [cf. eq. 8]
  bool sees(Index i, Index j) const;

  /// The same of a particle and a new one: a place that its parent would not see is none on its surface.
  bool sees(Index i, const Placed& placed) const;

  /// True if nobody who faces the way of `normal` lies within radius of the point, parents apart.
  bool isClear(const Vec3& point, const Vec3& normal, double radius, const Index (&parents)[2],
               std::vector<cloud::Neighbor>& found) const;

  /// True if nobody who faces the way of `normal` lies in the cylinder about the point along it: radius wide, up to height above
  /// and below, parents apart.
  bool isOpen(const Vec3& point, const Vec3& normal, double radius, double height, const Index (&parents)[2],
              std::vector<cloud::Neighbor>& found) const;

  /// True if all within radius of a new particle who face its way see it: beside a surface instead of on it nobody would.
  bool fits(const Placed& placed, double radius, std::vector<cloud::Neighbor>& found) const;

  /// A particle at the point, moved along the normal n to where the co-circularity (eq. 8) with those nearby is least:
  ///   min over h of  sum_j w_j ((n + n_j) . (p_j - point - h n))^2,   w_j = exp(-|p_j - point|^2 / (2 scale^2)),
  /// which is exact on spheres, and to second order on every smooth surface, with particles on one side only too. n is the
  /// value at the point of the linear function of the tangential coordinates that fits the normals n_j with the same weights;
  /// where they say nothing of its slope (a single particle, a line of them) that is zero. The x axis is the weighted mean of
  /// theirs, each turned with its normal. Those nearby: seen by one parent, within two and a half scales. The parent itself
  /// always is.
  Placed place(const Vec3& point, double scale, const Index (&parents)[2], std::vector<cloud::Neighbor>& found) const;

  const Points& positions() const { return positions_; }
  const Points& normals() const { return normals_; }
  Vec3 xAxis(Index i) const { return orientations_[i] * Vec3::UnitX(); }
  const cloud::KdTree& tree() const { return tree_; }
  Index size() const { return static_cast<Index>(positions_.size()); }

 private:
  const Points& positions_;
  const Orientations& orientations_;
  Points normals_;
  cloud::KdTree tree_;
};

}  // namespace deformable_surface::model
