// The rotation and the invariants of a triangle's deformation, also where it is collapsed. Its forces and its stiffness share
// them.
#pragma once

#include "deformable_surface/model/mass_spring/incidence.h"

#include <cmath>

namespace deformable_surface::model {

using Mat32 = Eigen::Matrix<double, 3, 2>;

// Rotation and invariants of F.
struct Polar {
  Mat32 rotation;
  Vec3 normal;
  double trace;        // T = tr S, the sum of the two stretches
  double determinant;  // J
};

inline Polar decompose(const Mat32& F, Index element) {
  Polar p;
  const Vec3 cross = F.col(0).cross(F.col(1));
  p.determinant = cross.norm();
  p.trace = std::sqrt(F.squaredNorm() + 2.0 * p.determinant);
  if (p.determinant > 0.0) {
    p.normal = cross / p.determinant;
  } else {
    // Collapsed to a line or a point: a normal perpendicular to the line, always the same one.
    const Vec3 line = F.col(F.col(0).squaredNorm() >= F.col(1).squaredNorm() ? 0 : 1);
    const Vec3 aside = fixedDirection(element, element + 1);
    p.normal = line.squaredNorm() > 0.0 ? Vec3(line.cross(aside)) : aside;
    const double length = p.normal.norm();
    p.normal = length > 0.0 ? Vec3(p.normal / length) : line.unitOrthogonal();
  }
  if (p.trace > 0.0) {
    Mat32 cofactor;
    cofactor << F.col(1).cross(p.normal), p.normal.cross(F.col(0));
    p.rotation = (F + cofactor) / p.trace;
  } else {
    const Vec3 first = p.normal.unitOrthogonal();
    p.rotation << first, p.normal.cross(first);
  }
  return p;
}

}  // namespace deformable_surface::model
