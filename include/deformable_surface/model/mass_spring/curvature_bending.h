// A bending energy of the point set that converges to a stated rigidity, holds curved rest shapes and needs nothing special at
// free edges. The published bending springs have no stiffness at a flat rest state: their energy grows with the fourth power of
// curvature.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/mass_spring/part_index.h"

namespace deformable_surface::model {

/// At rest a quadratic x(a, b) is fitted through every point to its neighbours (weights (1 - s^2)^2, s = distance over reach),
/// in coordinates a, b of its tangent plane. The fit is linear in the positions: fixed rows g^a_j and c^ab_j give tangents
/// t_a = sum_j g^a_j x_j and second derivatives b_ab = sum_j c^ab_j x_j; with n = t_1 x t_2 / |.| the curvature is n . b_ab, and
///   W = D/2 sum_i A_i [(1 - nu) sum_ab k_ab^2 + nu (k_11 + k_22)^2],  k_ab = n . b_ab - II0_ab,
/// a plate of rigidity D and Poisson's ratio nu. With nu = 0 a strip of any width has rigidity D per width.
///
/// Where the surface is crushed the direction of n means nothing and changes without bound. So where |t_1 x t_2| is below e, a
/// tenth of what it is at rest, n = t_1 x t_2 / s with s = (|t_1 x t_2|^2 + e^2) / (2 e), which goes on smoothly and ends at
/// zero.
class CurvatureBending {
 public:
  static constexpr Index kFitPoints = 16;  // neighbours in a fit: about two rings, enough for one-sided fits at edges

  CurvatureBending() = default;

  /// rings: neighbours of neighbours are the fit's points. areas (n) m^2; rigidity D, N m. Points whose neighbourhood does
  /// not determine a quadratic (fewer than five neighbours, collinear) get no bending energy; numWithoutFit() counts them.
  /// poisson_ratio: above -1, below 1.
  /// held (n), or empty: points that do not move. At the edge of a held patch fits stay on one side and the patch gives the
  /// slope.
  CurvatureBending(const Points& rest, const Points& normals, const Lists& ring, const std::vector<double>& areas,
                   double rigidity, double poisson_ratio, const std::vector<char>& held = {});

  /// Marks the other points of the fits that use points.
  void markPartners(const std::vector<Index>& points, std::vector<char>& marked) const;
  /// The fits that use a wanted point; the others have no energy.
  CurvatureBending makePart(const PartIndex& part) const;

  void addForces(const PaddedPoints& positions, Points& forces) const;
  double energy(const PaddedPoints& positions) const;
  /// kPositive: the Gauss-Newton part alone, which is positive semidefinite.
  void addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const;
  void addRowBounds(std::vector<double>& stiffness) const;
  /// Springs across the surface that together are the stiffness at rest of a flat one: visit(k, N/m) for what each fit couples
  /// point j with points k > j.
  template <typename Visit>
  void forEachSpring(Index j, const Visit& visit) const;
  /// All of them, N/m.
  double sumSprings() const;
  /// Upper bound of the largest eigenvalue of M^-1 K, with K the Gauss-Newton part at a state, 1/s^2. masses (n), kg.
  double boundRate(const State& state, const std::vector<double>& masses) const;

  Index numWithoutFit() const { return num_without_fit_; }

 private:
  // The rows of the fit for one neighbour: five numbers side by side.
  struct Row {
    Eigen::Matrix<double, 2, 1, Eigen::DontAlign> first;  // g^1, g^2, 1/m
    Vec3 second;                                          // c^11, c^12, c^22, 1/m^2
  };
  // The deformed shape at a point.
  struct Shape {
    Vec3 normal;
    Vec3 change;       // n . b_ab - II0_ab for ab = 11, 12, 22; 1/m
    Vec3 curvature;            // n . b_ab
    Vec3 dual[2];              // t^c: t^c . t_d = 1 if c = d, else 0
    Eigen::Matrix<double, 2, 3> christoffel;  // Gamma^c_ab = t^c . b_ab
  };
  struct Derivatives {
    Vec3 t[2];  // t_1, t_2
    Mat3 b;     // b_11, b_12, b_22 in columns, 1/m
  };
  // The deformed shape at a crushed point.
  struct CrushedShape {
    Vec3 normal;       // n, no unit vector
    Vec3 change;       // n . b_ab - II0_ab for ab = 11, 12, 22; 1/m
    Mat3 by_first[2];  // by the tangents t_1, t_2: the gradients of the three in columns
    /// The gradients of the three by the position of a neighbour, in columns.
    Mat3 changeBy(const Row& row) const;
  };
  // Of positions that lie stride numbers apart.
  Derivatives sumDerivativesAt(Index i, const double* positions, Index stride) const;
  static bool isCrushed(const Derivatives& derivatives);
  // M over D A: the moments that belong to changes of curvature, 11, both of 12 and 21, 22; the matrix that
  // gives them; its symmetric root.
  Vec3 momentOf(const Vec3& change) const {
    const double nu = poisson_ratio_;
    return {change[0] + nu * change[2], 2.0 * (1.0 - nu) * change[1], change[2] + nu * change[0]};
  }
  Mat3 momentMatrix() const;
  Mat3 momentRoot() const;
  Shape shapeAt(Index i, const Derivatives& derivatives) const;
  CrushedShape crushedShapeAt(Index i, const Derivatives& derivatives) const;
  void addCrushedForces(const PaddedPoints& positions, Points& forces) const;
  void addCrushedStiffness(Index i, const CrushedShape& shape, BlockSparse& stiffness) const;
  void prepareForceLoop();

  // Constants. The point itself is the first of its own list.
  Lists neighbors_;
  std::vector<Row> rows_;           // one per item of neighbors_
  std::vector<Vec3> rest_curvature_;
  std::vector<double> weight_;      // D * A_i; 0 where there is no fit
  double poisson_ratio_ = 0.0;
  // The same once more for the force loop: four points side by side, each with as many neighbours as a fit can have and rows of
  // zero in the place of those that it has not.
  std::vector<Index> group_neighbors_;   // (neighbours x 4) a group: where their positions are among the padded ones
  std::vector<double> group_rows_;       // (neighbours x 5 x 4)
  std::vector<double> group_constants_;  // (4 x 4) D A and the rest curvature
  Lists users_;                          // per point j: 2 items a fit that uses it, the places in along_ and normals_
  Index num_without_fit_ = 0;
  // Scratch: minus the force on each neighbour along the normal of the fit's point, (neighbours x 4) a group, and those normals,
  // padded to four numbers.
  mutable std::vector<double> along_, normals_;
  mutable std::vector<double> rate_;  // (n)
};

// At rest a fit's energy is of w, the motions along its normal, and entry jk is D A c_j . M(c_k); as the rows sum to zero it is
// that of springs of minus the entries.
template <typename Visit>
void CurvatureBending::forEachSpring(Index j, const Visit& visit) const {
  if (neighbors_.size() == 0) return;
  for (const Index* user = users_.begin(j); user != users_.end(j); user += 2) {
    const Index i = user[1] / 4, begin = neighbors_.offsets[i], end = neighbors_.offsets[i + 1];
    Index own = begin;
    while (neighbors_.items[own] != j) ++own;
    const Vec3 scaled = -weight_[i] * momentOf(rows_[own].second);
    for (Index r = begin; r < end; ++r)
      if (neighbors_.items[r] > j) visit(neighbors_.items[r], scaled.dot(rows_[r].second));
  }
}

}  // namespace deformable_surface::model
