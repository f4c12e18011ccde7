// The membrane as co-rotated triangles on the rings: plane stress with any Poisson's ratio, valid under large rotations. With the
// same points, springs are 10 to 25 percent softer.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/mass_spring/part_index.h"

#include <array>

namespace deformable_surface::model {

/// Per triangle, with F (3 x 2) the derivative of the position by the coordinates in the triangle's plane at rest, R its rotation
/// (polar decomposition) and S = R^T F:
///   W = w A [ mu |S - I|^2 + lambda/2 tr(S - I)^2 ],  mu = E h / (2 (1 + nu)), lambda = E h nu / (1 - nu^2)   (plane stress).
/// With J = |f1 x f2| = det S and T = tr S = sqrt(|F|^2 + 2 J): R = (F + cof F) / T, where cof F = dJ/dF. The forces
/// need no eigenvalues. With F = E D, where E = (e1 e2) are the edges from the first corner and D the inverse
/// of theirs at rest, G = D D^T and L = |e1 x e2|:
///   J = L det D,  T^2 = sum_ab G_ab e_a.e_b + 2 J,  s = lambda - 2 (lambda + mu) / T,
///   force on corner a = -sum_b K_ab e_b,  K = w A [ (2 mu + s) G + s det D / L ( e2.e2  -e1.e2 ; -e1.e2  e1.e1 ) ].
class TriangleMembrane {
 public:
  TriangleMembrane() = default;

  /// membrane_stiffness = E h, N/m. Triangles without area are omitted. whole, or null: a membrane with the same triangles and
  /// more, in the same order; which of them act together is then taken from it, which is quicker than finding it anew.
  TriangleMembrane(const std::vector<WeightedTriangle>& triangles, const Points& rest, double membrane_stiffness,
                   double poisson_ratio, const TriangleMembrane* whole = nullptr);

  /// Marks the other corners of the triangles at points, and of those that act together with these.
  void markPartners(const std::vector<Index>& points, std::vector<char>& marked) const;
  /// The triangles that touch a wanted point, and those on the same four points as one, in their order.
  TriangleMembrane makePart(const PartIndex& part) const;

  /// positions: those of the state.
  void addForces(const State& state, const PaddedPoints& positions, Points& forces) const;
  double energy(const State& state) const;
  /// Its eigenvalues are known in closed form from the stretches; kPositive raises negative ones to zero.
  void addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const;
  void addRowBounds(std::vector<double>& stiffness) const;

  /// The three edges of each triangle, the smaller index first, with springs in them, N/m: those in the surface resist like the
  /// membrane, regardless of direction; those across it resist like its tension at a state. (3 x triangles) each, overwritten.
  std::vector<std::pair<Index, Index>> findEdges() const;
  void computeSpringsAlong(std::vector<double>& stiffness) const;
  void computeSpringsAcross(const State& state, std::vector<double>& stiffness) const;

 private:
  using Mat32 = Eigen::Matrix<double, 3, 2>;
  struct Element {
    Index corner[3];
    Mat2 inverse;  // of the rest edges (columns) in the triangle's plane
    double area;   // weight * area at rest, m^2
  };
  static Mat32 gradient(const Element& e, const State& state);
  Mat32 cornerForces(Index t, const State& state) const;
  // Triangles on the same four points act as one: first fours, on every three of the points, then pairs, (0, 1, 2) and (0, 2, 3).
  // Most of the time goes into reading points and distributing forces, of which there are then fewer.
  struct Patch {
    Index points[4];
    Index elements[4];  // of (0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3); -1: not there
  };
  Patch makeSingle(Index t) const;
  Patch makePair(Index t, Index u) const;
  void groupTriangles();
  void takePatches(const TriangleMembrane& whole);
  void prepareForceLoop(Index num_points);
  static std::array<double, 6> constantsOf(const Element& e, Index p, Index q, Index r);
  Index patchOf(Index item) const;  // of incidence_
  void repairCollapsed(Index begin, Index end, const State& state) const;

  // Constants.
  std::vector<Element> elements_;
  std::vector<Patch> patches_;
  Index num_fours_ = 0;
  // Four patches of a kind side by side, the last ones of each kind repeated: (4 x 4) points, and per triangle (6 x 4) constants
  // for the force loop.
  std::vector<Index> group_points_;
  std::vector<double> group_constants_;
  Lists incidence_;  // per point: 16 * group + 4 * corner + lane, where its forces are
  double mu_ = 0.0, lambda_ = 0.0;
  // Scratch: forces on the corners, in the order of group_points_, padded to four numbers.
  mutable std::vector<double> corner_force_;
};

}  // namespace deformable_surface::model
