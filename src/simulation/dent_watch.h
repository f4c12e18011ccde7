// Detects dents or folds between the simulation points, where neither these nor coarser copies can show them: how fast
// dents would grow on the full surface under the forces at the simulation points, and how sharply it is bent. For the error
// estimator.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/material_params.h"

#include <vector>

namespace deformable_surface::simulation {

/// Whether a surface buckles where its points do not show it. If it is possible, few scenes do. If it is likely, the result is
/// unpredictable.
enum class Buckling { kUnlikely, kPossible, kLikely };

/// A shallow shell of rigidity D (N m), membrane stiffness S = E h (N/m), mass rho (kg/m^2) and damping c (1/s), in which the
/// membrane force is N (N/m, a tensor), answers a small wave of number k (1/m) along the unit vector t with
///   rho (s^2 + c s) = -(D k^4 + S b^2 + (t.N t) k^2),
/// where b is the curvature across t. The wave grows as exp(s time) where the right side is positive. For some k that happens
/// where -t.N t exceeds 2 b sqrt(S D), the classical buckling load [Timoshenko 1961, 11.1]. Only waves count that the full
/// cloud can show and coarser copies of the simulation cannot. N and b are those of the triangles between the simulation points.
/// Buckling is also possible where the normals of two neighbouring points differ by a radian more than at rest.
class DentWatch {
 public:
  DentWatch() = default;  // watches nothing
  /// points (m x 3) and triangles: the simulation points at rest; area: of the surface, m^2; num_full: points of the full cloud.
  /// A curved surface whose dents would be too short for the point spacing is watched closely; any other for folds that are
  /// too short, if the cloud has more points.
  DentWatch(const model::MaterialParams& material, const Points& points, const std::vector<model::WeightedTriangle>& triangles,
            double area, Index num_full);

  void reset();
  /// share: of the stiffness at the beginning.
  void softenMembrane(double share) { stretching_ = share * stated_stretching_; }

  /// After a step (s): judges by how far dents have had time to grow.
  Buckling followStep(const Points& positions, double step);
  /// Judges an equilibrium by the load at which dents begin.
  Buckling judgeEquilibrium(const Points& positions);

  /// Judges a force (N) in any direction on these simulation points, spread over a patch of this radius (m). A surface with
  /// short dents may give way to it, which membrane forces between few points do not show. Criterion: the classical buckling
  /// pressure of a sphere of its curvature, 4 sqrt(S D) b^2.
  Buckling judgeForce(const std::vector<Index>& loaded, const std::vector<double>& shares, double force, double radius) const;

  /// What a snapshot must hold: the logarithm of the growth so far in each triangle. For surfaces without short dents, first that
  /// of folds too short for the points, then that of folds too short for the copies.
  const std::vector<double>& growth() const { return growth_; }
  void setGrowth(const std::vector<double>& growth) { growth_ = growth; }

 private:
  struct Triangle {
    Index corner[3];
    Mat2 inverse;  // of the rest edges (columns) in the triangle's plane
    double weight;
    double turned[3];  // |n_i - n_j| of the normals at both ends of each edge, at rest
  };
  struct Local {
    Mat2 force;      // N/m
    Mat2 curvature;  // 1/m
  };
  void findNormals(const Points& positions);
  Local measure(const Triangle& t, const Points& positions) const;
  double findTurn(const Triangle& t) const;
  double findAcceleration(const Local& local, double least) const;
  double findLoad(const Local& local) const;
  bool hasShortDents(double curvature) const;

  // Constants.
  std::vector<Triangle> triangles_;  // empty: nothing is watched
  bool has_short_dents_ = false;
  double stretching_ = 0.0, stated_stretching_ = 0.0, rigidity_ = 0.0, poisson_ = 0.0, mass_ = 0.0, damping_ = 0.0;
  double least_ = 0.0, least_fold_ = 0.0, largest_ = 0.0;  // k^2, 1/m^2: shown by copies, by points, by the cloud
  double spacing_ = 0.0, full_spacing_ = 0.0;              // m, of the simulation points and of the full cloud
  std::vector<double> curvature_;                          // 1/m, the mean curvature's size at the points at rest
  // Observations so far.
  std::vector<double> growth_;
  // Scratch.
  Points normals_;
};

}  // namespace deformable_surface::simulation
