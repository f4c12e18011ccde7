// The surface of oriented particles near a point: which particles see each other, and the place and orientation of a new
// particle. Both growth rules use it.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/growth.h"

namespace deformable_surface::model {

/// Relative rounding error of distances between float coordinates. With this tolerance a perfect lattice has its nominal
/// distances, and the neighbours of a vacancy leave it clear.
constexpr double kRounding = 1e-6;

struct Placed {
  Vec3 position;
  Eigen::Quaterniond orientation;
};

class LocalSurface {
 public:
  /// Throws InputError for arrays of different lengths and for numbers that are not finite.
  /// apart: as in growth.h; all are kept by reference.
  LocalSurface(const Points& positions, const Orientations& orientations, const AreApart& apart = kNoneApart);

  /// True if two particles may be parts of one sheet: normals less than 90 degrees apart, line at most 30 degrees from the
  /// plane of their mean, and no cut between them. Circles are seen whatever their curvature: there the line lies in that plane.
  /// [cf. eq. 8]
  bool sees(Index i, Index j) const;

  /// The same for a particle and a new one. A place that its parent does not see is not on its surface.
  bool sees(Index i, const Placed& placed) const;

  /// True if no particle that faces the way of `normal`, except the parents, lies within radius of the point.
  bool isClear(const Vec3& point, const Vec3& normal, double radius, const Index (&parents)[2],
               std::vector<cloud::Neighbor>& found) const;

  /// True if no particle that faces the way of `normal`, except the parents, lies in the cylinder about the point along it: as
  /// wide as radius, up to height above and below.
  bool isOpen(const Vec3& point, const Vec3& normal, double radius, double height, const Index (&parents)[2],
              std::vector<cloud::Neighbor>& found) const;

  /// True if all particles within radius of a new one that face its way see it. Beside the surface none would.
  bool fits(const Placed& placed, double radius, std::vector<cloud::Neighbor>& found) const;

  /// A particle at the point, moved along the normal n to where the co-circularity (eq. 8) with its neighbours is least:
  ///   min over h of  sum_j w_j ((n + n_j) . (p_j - point - h n))^2,   w_j = exp(-|p_j - point|^2 / (2 scale^2)),
  /// which is exact on spheres, and second order on every smooth surface, even with particles on one side only. n is the
  /// value at the point of the linear function of the tangential coordinates that fits the normals n_j with the same weights.
  /// Where they do not determine its slope (a single particle, a line of them) the slope is zero. The x axis is the weighted
  /// mean of theirs, each turned with its normal. Neighbours: seen by one parent, within two and a half scales; the parent
  /// itself always counts.
  Placed place(const Vec3& point, double scale, const Index (&parents)[2], std::vector<cloud::Neighbor>& found) const;
  /// How far from the point those neighbours lie at most, m.
  static double reachOf(double scale);

  const Points& positions() const { return positions_; }
  const Points& normals() const { return normals_; }
  Vec3 xAxis(Index i) const { return orientations_[i] * Vec3::UnitX(); }
  const cloud::KdTree& tree() const { return tree_; }
  Index size() const { return static_cast<Index>(positions_.size()); }

 private:
  static const AreApart kNoneApart;

  const Points& positions_;
  const Orientations& orientations_;
  const AreApart& apart_;
  Points normals_;
  cloud::KdTree tree_;
};

}  // namespace deformable_surface::model
