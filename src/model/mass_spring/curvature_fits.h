// The fits of curvature at rest: balanced by moment_balance.h and used by CurvatureBending.
#pragma once

#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include <array>

#include "clamped_plate.h"

namespace deformable_surface::model {

/// The two axes of the tangent plane for the coordinates of a fit.
struct TangentAxes {
  explicit TangentAxes(const Vec3& normal) : first(normal.unitOrthogonal()), second(normal.cross(first)) {}
  Vec3 first, second;
};

struct CurvatureFits {
  /// The weighted design of a fit is Q R with rows root_m (a, b, a^2/2, ab, b^2/2) [of the last three alone at the edge of a
  /// clamp]: root (1 - Q Q^T) root takes from differences what the fit explains. Root is zero where the curvature does not look.
  struct Basis {
    std::array<double, CurvatureBending::kFitPoints> root;
    Eigen::Matrix<double, CurvatureBending::kFitPoints, 5> q;
  };
  Lists points;                    // of each fit: the point itself, then its neighbours, of a point on an edge then those that it
                                   // rides on; the point alone where there is no fit
  std::vector<CurvatureRow> rows;  // (items of points)
  std::vector<double> reach;       // (n) m, the support of the weights; 0: no fit
  std::vector<Basis> bases;        // (n)

  bool has(Index i) const { return reach[i] > 0.0; }
};

/// The fits of some points, in their order. Parallel.
CurvatureFits fitCurvatures(const ClampedPlate& clamped, const std::vector<Index>& points);

/// Marks all points within so many rings of marked ones, (n).
void growRings(const Lists& ring, int rings, std::vector<char>& marked);

/// (n) 1: within a few rings of a clamp's edge, where fits are smaller.
std::vector<char> markBesideClamps(const ClampedPlate& clamped);

}  // namespace deformable_surface::model
