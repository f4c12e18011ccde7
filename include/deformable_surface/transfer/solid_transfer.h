// From the simulation points of a body to all points of its cloud. A body has no tangent planes, which the transfer of surfaces
// needs.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::transfer {

/// Moving least squares with linear functions [Lancaster and Salkauskas 1981], kept as rows: u = sum_j a_j u_j and grad u =
/// sum_j u_j b_j^T over the simulation points near a point, weighted by (1 - s^2)^2 / s^2 with the distance s over that of the
/// farthest. Linear motions are exact, and a point that is a simulation point moves with it. A normal turns by the cofactors
/// of I + grad u; a point without one (zero, inside the body) gets none.
class SolidTransfer {
 public:
  SolidTransfer() = default;

  /// dense (n x 3), normals (n x 3, unit or zero), simulation (m x 3): at rest. followed: (n) the simulation points that each
  /// point follows, nearest first. If these do not span the body, the motion across them is constant. Parallel; O(n k).
  SolidTransfer(const Points& dense, const Points& normals, const Points& simulation, const Lists& followed);

  bool isEmpty() const { return rest_.empty(); }
  /// positions (m x 3) of the simulation points now -> dense positions (n x 3) and, if not null, normals (n x 3). At rest they
  /// are the rest positions to the bit. Parallel.
  void apply(const Points& simulation_now, Points& dense_now, std::vector<Eigen::Vector3f>* normals_now) const;

 private:
  Points rest_, normals_, simulation_rest_;
  Lists followed_;
  std::vector<double> row_;  // (4 x followed) a_j and b_j, 1/m
};

}  // namespace deformable_surface::transfer
