// A bending energy of the point set that converges to a stated rigidity, supports curved rest shapes and needs no special case at
// free edges. The published bending springs have no stiffness at a flat rest state: their energy grows with the fourth power of
// curvature.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/mass_spring/curvature_loop.h"
#include "deformable_surface/model/mass_spring/part_index.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::model {

/// The rest surface of the bending energy.
struct PlateRest {
  Points points, normals;                   // (n x 3) m
  Lists ring;                               // (n) neighbours, symmetric
  std::vector<WeightedTriangle> triangles;  // cover the surface once
  double rigidity = 0.0;                    // D, N m
  double poisson_ratio = 0.0;               // above -1, below 1
  std::vector<double> shares = {};          // (n) of D, of each point; empty: 1
};

/// A point on the edge of a clamp, which follows three held points: any function that is linear on them is sum of weights *
/// values there, and has the gradient sum of gradients * values.
struct EdgePoint {
  Index points[3];
  double weights[3];
  Vec3 gradients[3];  // 1/m
};

struct BalancedPlate;

/// At rest a quadratic x(a, b) is fitted through every point to its neighbours (weights (1 - s^2)^2, s = distance over reach),
/// in coordinates a, b of its tangent plane. The fit is linear in the positions: fixed rows g^a_j and c^ab_j give tangents
/// t_a = sum_j g^a_j x_j and second derivatives b_ab = sum_j c^ab_j x_j; with n = t_1 x t_2 / |.| the curvature is n . b_ab, and
///   W = D/2 sum_i A_i [(1 - nu) sum_ab k_ab^2 + nu (k_11 + k_22)^2],  k_ab = n . b_ab - II0_ab,
/// a plate of rigidity D and Poisson's ratio nu. With nu = 0 a strip of any width has rigidity D per width.
///
/// The rows c^ab are those of the fits with the smallest change that balances a constant moment at every point
/// (balanceMoments()). Without it, scattered points are some per cent too soft at any resolution. A_i: thirds of the triangles.
///
/// Where the surface is crushed (degenerate), the direction of n is meaningless and changes without bound. So where |t_1 x t_2|
/// is below e, a tenth of its value at rest, n = t_1 x t_2 / s with s = (|t_1 x t_2|^2 + e^2) / (2 e), a smooth continuation that
/// ends at zero.
class CurvatureBending {
 public:
  static constexpr Index kFitPoints =
      CurvatureLoop::kSlots - 1;  // neighbours in a fit: about two rings, enough for one-sided fits at edges

  CurvatureBending() = default;

  /// Points whose neighbourhood does not determine a quadratic (fewer than five neighbours, collinear) get no bending energy;
  /// numWithoutFit() counts them. held (n), or empty: points that do not move; edges: see DeformableModel::setHeld(), they say
  /// where a clamp ends. Fits beside it use the points of its edge. Fits at the edge are one-sided, with the slope of the patch.
  explicit CurvatureBending(const PlateRest& plate, const std::vector<char>& held = {}, const std::vector<ClampEdge>& edges = {});
  /// Of a plate with cuts, from the whole one with the same clamps: the rows are found anew near cuts only.
  CurvatureBending(const BalancedPlate& whole, const PlateRest& cut, const std::vector<char>& held,
                   const std::vector<ClampEdge>& edges);

  /// Marks the other points of the fits that use points.
  void markPartners(const std::vector<Index>& points, std::vector<char>& marked) const;
  /// Only the fits that use a wanted point; the others have no energy.
  CurvatureBending makePart(const PartIndex& part) const;

  /// positions are unchanged on return.
  void addForces(PaddedPoints& positions, Points& forces) const;
  double energy(PaddedPoints& positions) const;
  /// kPositive: only the Gauss-Newton part, which is positive semidefinite.
  void addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const;
  void addRowBounds(std::vector<double>& stiffness) const;
  /// Springs across the surface whose sum is the stiffness of a flat one at rest: visit(k, N/m) for the couplings of each fit
  /// between point j and points k > j.
  template <typename Visit>
  void forEachSpring(Index j, const Visit& visit) const;
  /// Sum of all springs, N/m.
  double sumSprings() const;
  /// Upper bound of the largest eigenvalue of M^-1 K, with K the Gauss-Newton part at a state, 1/s^2. masses (n), kg.
  double boundRate(const State& state, const std::vector<double>& masses) const;

  Index numWithoutFit() const { return num_without_fit_; }
  /// Edges of clamps at which the surface turns freely, since all points held there are collinear.
  Index numHinged() const { return num_hinged_; }

 private:
  explicit CurvatureBending(BalancedPlate&& balanced);

  using Row = CurvatureRow;
  // The rows of a fit in terms of the actual points: those of edge points are distributed to the points that these follow.
  struct WholeFit {
    Index size = 0;
    Index points[3 * (kFitPoints + 1)];
    Row rows[3 * (kFitPoints + 1)];
  };
  WholeFit wholeFit(Index i) const;
  Index numPoints() const { return neighbors_.size() - static_cast<Index>(edge_points_.size()); }
  void appendEdge(PaddedPoints& positions) const;
  std::vector<std::pair<Index, Index>>::const_iterator firstRider(Index point) const {
    return std::lower_bound(riders_.begin(), riders_.end(), std::pair(point, Index{0}));
  }
  // The deformed shape at a point.
  struct Shape {
    Vec3 normal;
    Vec3 change;                              // n . b_ab - II0_ab for ab = 11, 12, 22; 1/m
    Vec3 curvature;                           // n . b_ab
    Vec3 dual[2];                             // t^c: t^c . t_d = 1 if c = d, else 0
    Eigen::Matrix<double, 2, 3> christoffel;  // Gamma^c_ab = t^c . b_ab
  };
  struct Derivatives {
    Vec3 t[2];  // t_1, t_2
    Mat3 b;     // b_11, b_12, b_22 in columns, 1/m
  };
  // The deformed shape at a crushed point.
  struct CrushedShape {
    Vec3 normal;       // n, not a unit vector
    Vec3 change;       // n . b_ab - II0_ab for ab = 11, 12, 22; 1/m
    Mat3 by_first[2];  // derivatives by the tangents t_1, t_2: the gradients of the three components of change, in columns
    /// The gradients of the three components of change by the position of a neighbour, in columns.
    Mat3 changeBy(const Row& row) const;
  };
  // positions: with a stride between points.
  static Derivatives sumDerivatives(const WholeFit& fit, const double* positions, Index stride);
  static bool isCrushed(const Derivatives& derivatives);
  // M over D A: the moments conjugate to changes of curvature, 11, both of 12 and 21, 22; the matrix that gives them; its
  // symmetric root.
  Vec3 momentOf(const Vec3& change) const {
    const double nu = poisson_ratio_;
    return {change[0] + nu * change[2], 2.0 * (1.0 - nu) * change[1], change[2] + nu * change[0]};
  }
  Mat3 momentMatrix() const;
  Mat3 momentRoot() const;
  Shape shapeAt(Index i, const Derivatives& derivatives) const;
  CrushedShape crushedShapeAt(Index i, const Derivatives& derivatives) const;
  void addCrushedForces(const double* positions, Points& forces) const;
  void addCrushedStiffness(const WholeFit& fit, double weight, const CrushedShape& shape, BlockSparse& stiffness) const;
  void prepareForceLoop();

  // Constants. Points on edges of clamps come after the others. A point is the first of its own list.
  std::vector<EdgePoint> edge_points_;
  std::vector<std::pair<Index, Index>> riders_;  // ascending (held point, point on an edge that follows it)
  Lists neighbors_;
  std::vector<Row> rows_;  // one per item of neighbors_
  std::vector<Vec3> rest_curvature_;
  std::vector<double> weight_;  // D * A_i; 0 where there is no fit
  double poisson_ratio_ = 0.0;
  CurvatureLoop loop_;
  Index num_without_fit_ = 0, num_hinged_ = 0;
  mutable std::vector<double> rate_;  // (n), scratch
};

// At rest, the energy of a fit depends on w, the motions along its normal, and entry jk is D A c_j . M(c_k). As the rows sum to
// zero, it equals that of springs with minus the entries. Points on edges are taken to move as the first of the points that they
// follow.
template <typename Visit>
void CurvatureBending::forEachSpring(Index j, const Visit& visit) const {
  if (neighbors_.size() == 0) return;
  const auto pointOf = [&](Index k) { return k < numPoints() ? k : edge_points_[k - numPoints()].points[0]; };
  const auto visitFitsOf = [&](Index point) {
    for (Index k = loop_.users().offsets[point]; k < loop_.users().offsets[point + 1]; k += 2) {
      const Index i = loop_.fitOf(k), begin = neighbors_.offsets[i], end = neighbors_.offsets[i + 1];
      Index own = begin;
      while (neighbors_.items[own] != point) ++own;
      const Vec3 scaled = -weight_[i] * momentOf(rows_[own].second);
      for (Index r = begin; r < end; ++r)
        if (pointOf(neighbors_.items[r]) > j) visit(pointOf(neighbors_.items[r]), scaled.dot(rows_[r].second));
    }
  };
  visitFitsOf(j);
  for (auto rider = firstRider(j); rider != riders_.end() && rider->first == j; ++rider)
    if (pointOf(rider->second) == j) visitFitsOf(rider->second);
}

}  // namespace deformable_surface::model
