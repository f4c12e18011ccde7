// Whether a surface dents or folds between its simulation points, where neither they nor coarser copies can show it: how fast
// dents would grow on the full surface under the forces that the simulation points feel, and how sharply it is bent. Apart from
// the error estimator, which only asks.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/material_params.h"

#include <vector>

namespace deformable_surface::simulation {

/// Whether a surface buckles where its points do not show it. Where it is possible only few do; where it is likely nobody can say
/// where it ends.
enum class Buckling { kUnlikely, kPossible, kLikely };

/// A shallow shell of rigidity D (N m), membrane stiffness S = E h (N/m), mass rho (kg/m^2) and damping c (1/s), in which the
/// membrane force is N (N/m, a tensor), answers a small wave of number k (1/m) along the unit vector t with
///   rho (s^2 + c s) = -(D k^4 + S b^2 + (t.N t) k^2),
/// where b is the curvature across t: the wave grows as exp(s time) where the right side is positive, and for some k that is
/// where -t.N t exceeds 2 b sqrt(S D), the classical buckling load [Timoshenko 1961, 11.1]. Looked at are waves that the full
/// cloud can show and coarser copies of the simulation cannot. N and b are those of the triangles between the simulation points.
/// Buckling is possible, too, where the difference of the normals of two neighbouring points has grown by that of a radian.
class DentWatch {
 public:
  DentWatch() = default;  // sees nothing
  /// points (m x 3) and triangles: the simulation points at rest; area: of the surface, m^2; num_full: points of the full cloud.
  /// A curved surface whose dents would be too short for the spacing of the points is watched closely; any other for folds that
  /// are too short for them, if there are more points.
  DentWatch(const model::MaterialParams& material, const Points& points, const std::vector<model::WeightedTriangle>& triangles,
            double area, Index num_full);

  void reset();
  /// Of the stiffness at the beginning.
  void softenMembrane(double share) { stretching_ = share * stated_stretching_; }

  /// After a step of so many seconds, by how far dents have had the time to grow.
  Buckling followStep(const Points& positions, double step);
  /// Of an equilibrium, by the load at which dents begin.
  Buckling judgeEquilibrium(const Points& positions);

  /// Of a force (N) in any direction on these simulation points, spread over a patch of this radius (m), to which a surface with
  /// short dents may give way, which the membrane forces between few points do not tell: by the classical buckling pressure of a
  /// sphere of its curvature, 4 sqrt(S D) b^2.
  Buckling judgeForce(const std::vector<Index>& loaded, double force, double radius) const;

  /// What a snapshot must hold: of each triangle the logarithm of the growth so far; of surfaces without short dents first that
  /// of folds too short for the points, then that of those too short for the copies.
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
  double least_ = 0.0, least_fold_ = 0.0, largest_ = 0.0;  // k^2, 1/m^2: of what copies show, of what points show, of the cloud
  double spacing_ = 0.0, full_spacing_ = 0.0;              // m, of the simulation points and of the full cloud
  std::vector<double> curvature_;                          // 1/m, the mean curvature's size at the points at rest
  // What has been seen.
  std::vector<double> growth_;
  // Scratch.
  Points normals_;
};

}  // namespace deformable_surface::simulation
