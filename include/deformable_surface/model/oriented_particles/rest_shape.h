// The bent rest shape of particles, and its plastic flow where they are bent too far. Unlike forces, it
// changes between steps only.
#pragma once

#include "deformable_surface/model/deformable_model.h"

#include <optional>

namespace deformable_surface::model {

/// Curvatures are symmetric: n_j - n_i = K (p_j - p_i) for neighbours j of i on the surface, in 1/m; on a sphere of radius R
/// whose normals point outwards 1 / R. In the frame of a particle: (xx, yy, xy) across its normal.
Mat3 turnCurvatureToWorld(const Quaternion& orientation, const Vec3& curvature);
Vec3 turnCurvatureToFrame(const Quaternion& orientation, const Mat3& curvature);

/// Eigenvalues of a curvature, the larger first, and the angle of the first's direction from the x axis of the frame, rad.
struct PrincipalCurvatures {
  double larger = 0.0, smaller = 0.0, angle = 0.0;
};
PrincipalCurvatures findPrincipalCurvatures(const Vec3& curvature);

/// Estimates a particle's curvature from its neighbours: the least squares of n_j - n_i - K (p_j - p_i) across its normal, each
/// with its weight. Exact on spheres and cylinders.
class CurvatureFit {
 public:
  explicit CurvatureFit(const Quaternion& orientation) : to_frame_(orientation.conjugate().toRotationMatrix()) {}
  /// offset: p_j - p_i, m; turn: n_j - n_i.
  void add(double weight, const Vec3& offset, const Vec3& turn);
  /// In the frame; none if the neighbours are collinear or too few.
  std::optional<Vec3> solve() const;

 private:
  const Mat3 to_frame_;
  Mat3 matrix_ = Mat3::Zero();
  Vec3 right_ = Vec3::Zero();
};

/// Perfect plasticity: the new rest curvature after a particle had a curvature. Bending beyond the yield (1/m, > 0) in
/// its most bent direction stays as rest curvature. Below the yield nothing changes.
Vec3 flowToYield(const Vec3& rest, const Vec3& curvature, double yield);

}  // namespace deformable_surface::model
