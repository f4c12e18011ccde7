#include "deformable_surface/model/oriented_particles/rest_shape.h"

#include <cmath>

namespace deformable_surface::model {

Mat3 turnCurvatureToWorld(const Quaternion& orientation, const Vec3& curvature) {
  Mat3 in_frame = Mat3::Zero();
  in_frame.topLeftCorner<2, 2>() << curvature[0], curvature[2], curvature[2], curvature[1];
  const Mat3 frame = orientation.toRotationMatrix();
  return frame * in_frame * frame.transpose();
}

Vec3 turnCurvatureToFrame(const Quaternion& orientation, const Mat3& curvature) {
  const Mat3 frame = orientation.toRotationMatrix(), in_frame = frame.transpose() * curvature * frame;
  return {in_frame(0, 0), in_frame(1, 1), 0.5 * (in_frame(0, 1) + in_frame(1, 0))};
}

PrincipalCurvatures findPrincipalCurvatures(const Vec3& curvature) {
  const double mean = 0.5 * (curvature[0] + curvature[1]), half = 0.5 * (curvature[0] - curvature[1]);
  const double radius = std::hypot(half, curvature[2]);
  return {mean + radius, mean - radius, 0.5 * std::atan2(curvature[2], half)};
}

void CurvatureFit::add(double weight, const Vec3& offset, const Vec3& turn) {
  const Vec3 r = to_frame_ * offset, n = to_frame_ * turn;
  const double x = r.x(), y = r.y();
  Mat3 term;
  term << x * x, 0.0, x * y, 0.0, y * y, x * y, x * y, x * y, x * x + y * y;
  matrix_ += weight * term;
  right_ += weight * Vec3(n.x() * x, n.y() * y, n.x() * y + n.y() * x);
}

std::optional<Vec3> CurvatureFit::solve() const {
  constexpr double kInLine = 1e-6;  // of the determinant with neighbours all around: collinear ones leave only rounding
  const double size = matrix_.trace() / 4.0;
  if (!(matrix_.determinant() > kInLine * 2.0 * size * size * size)) return std::nullopt;
  return Vec3(matrix_.ldlt().solve(right_));
}

Vec3 flowToYield(const Vec3& rest, const Vec3& curvature, double yield) {
  const Vec3 bent = curvature - rest;
  const PrincipalCurvatures principal = findPrincipalCurvatures(bent);
  const double most = std::max(std::abs(principal.larger), std::abs(principal.smaller));
  if (!(most > yield)) return rest;
  return rest + (1.0 - yield / most) * bent;
}

}  // namespace deformable_surface::model
