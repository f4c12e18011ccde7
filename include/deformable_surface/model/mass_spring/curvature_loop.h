// Forces and energy of CurvatureBending for all points, four fits at a time. The data are laid out for this loop alone.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

/// The rows of a fit for one of its points.
struct CurvatureRow {
  Eigen::Matrix<double, 2, 1, Eigen::DontAlign> first;  // g^1, g^2, 1/m
  Vec3 second;                                          // c^11, c^12, c^22, 1/m^2
};

/// f_j = -sum_i n_i (M_i^ab c^ab_ij - M_i^ab Gamma^c_ab g^c_ij), M = D A [(1 - nu) k + nu tr(k) I], k = n . b - II0; see
/// CurvatureBending for the symbols. First each fit i finds its terms, then each point j adds up those of the fits that use it,
/// always in the same order. No allocation.
class CurvatureLoop {
 public:
  static constexpr Index kSlots = 17;      // largest number of points of a fit, with the point itself
  static constexpr double kCrushed = 0.1;  // |t_1 x t_2|, the present area of a unit area at rest, below which a point is crushed

  CurvatureLoop() = default;
  /// points: of each fit (n lists), the fit's own first; rows: one per item of points; weights (n): D A, N m^3, 0 where there is
  /// no fit; rest (n): II0_ab for ab = 11, 12, 22, 1/m.
  CurvatureLoop(const Lists& points, const std::vector<CurvatureRow>& rows, const std::vector<double>& weights,
                const std::vector<Vec3>& rest, double poisson_ratio);

  /// Finds the terms of all fits at these positions (n). Returns whether any point is crushed; such points have no terms.
  bool computeMoments(const PaddedPoints& positions) const;
  /// Adds the forces (N) of the last computeMoments() on the first num_points points.
  void addForces(Index num_points, Points& forces) const;
  /// The force of the last computeMoments() on one point, N.
  Vec3 findForce(Index point) const;
  /// False for points that were crushed in the last computeMoments(), and for those without a fit.
  bool hasNormal(Index i) const { return normals_[4 * i] != 0.0 || normals_[4 * i + 1] != 0.0 || normals_[4 * i + 2] != 0.0; }
  /// J.
  double energy(const PaddedPoints& positions) const;

  /// The fits that use each point: two items per fit, which fitOf() reads from the first.
  const Lists& users() const { return users_; }
  Index fitOf(Index item) const { return users_.items[item + 1] / 4; }

 private:
  Index numGroups() const { return static_cast<Index>(constants_.size() / 16); }

  double poisson_ratio_ = 0.0;
  // Groups of four fits side by side, each with kSlots points; the rows of missing ones are zero.
  std::vector<Index> neighbors_;   // (kSlots x 4) per group: indices of their positions in the padded ones
  std::vector<double> rows_;       // (kSlots x 5 x 4) per group
  std::vector<double> constants_;  // (4 x 4) per group: D A and the rest curvature
  Lists users_;                    // per point: 2 items per fit that uses it, indices into along_ and normals_
  // Scratch: minus the force on each point of a fit along the normal of the fit, (kSlots x 4) per group, and those normals,
  // padded to four numbers.
  mutable std::vector<double> along_, normals_;
};

}  // namespace deformable_surface::model
