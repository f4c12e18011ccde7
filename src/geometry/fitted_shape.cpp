#include "deformable_surface/geometry/fitted_shape.h"

#include "deformable_surface/base/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_surface::geometry {
namespace {

constexpr int kUnknowns = 7;          // centre (3), tilt of the axis (2), radius, radius of the tube
constexpr int kSphereUnknowns = 4;    // centre and radius
constexpr int kMaxIterations = 100;   // near shapes take a handful
constexpr double kConverged = 1e-12;  // of the squares, in one iteration

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// A torus or, with a ring of fixed radius zero, a sphere whose radius is that of the tube. The columns of `frame`
// are two directions across the axis and the axis.
struct Shape {
  Vec3 center;
  Mat3 frame;
  double ring, tube;
  bool is_sphere;

  // Signed distance of a point, and its derivatives by the unknowns. A tilt turns the frame about its first two columns.
  double findDistance(const Vec3& point, Unknowns& slope) const {
    const Vec3 p = frame.transpose() * (point - center);
    const double across = std::hypot(p.x(), p.y());
    const Vec3 radial = across > 0.0 ? Vec3(p.x() / across, p.y() / across, 0.0) : Vec3::UnitX();
    const Vec3 from_circle = p - ring * radial;
    const double away = from_circle.norm();
    const Vec3 direction = away > 0.0 ? Vec3(from_circle / away) : Vec3::UnitZ();
    const Vec3 turned = p.cross(direction);
    slope.setZero();
    slope.head<3>() = -(frame * direction);
    if (!is_sphere) slope.segment<3>(3) << -turned.x(), -turned.y(), -radial.dot(direction);
    slope[6] = -1.0;
    return away - tube;
  }

  Shape moved(const Unknowns& step) const {
    const Vec3 tilt = frame * Vec3(step[3], step[4], 0.0);
    const double angle = tilt.norm();
    const Mat3 turn = angle > 0.0 ? Eigen::AngleAxisd(angle, tilt / angle).toRotationMatrix() : Mat3::Identity();
    return {center + step.head<3>(), turn * frame, ring + step[5], tube + step[6], is_sphere};
  }
};

struct Sums {
  Matrix normal = Matrix::Zero();
  Unknowns descent = Unknowns::Zero();
  double squares = 0.0, largest = 0.0;
};

Sums sumUp(const Shape& shape, const Points& points) {
  Sums sums;
  Unknowns slope;
  for (const Vec3& p : points) {
    const double distance = shape.findDistance(p, slope);
    sums.normal += slope * slope.transpose();
    sums.descent -= distance * slope;
    sums.squares += distance * distance;
    sums.largest = std::max(sums.largest, std::abs(distance));
  }
  return sums;
}

FittedShape fit(const char* name, const Points& points, bool is_sphere) {
  const int needed = is_sphere ? kSphereUnknowns : kUnknowns;
  const double n = static_cast<double>(points.size());
  if (points.size() < static_cast<std::size_t>(needed))
    throw InputError(std::string(name) + ": found " + std::to_string(points.size()) + " points; accepted: at least " +
                     std::to_string(needed));
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / n;
  if (!mean.allFinite()) throw InputError(std::string(name) + ": found a point that is not finite; accepted: finite ones");
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) covariance += (p - mean) * (p - mean).transpose() / n;
  Shape shape{mean, Mat3::Identity(), 0.0, 0.0, is_sphere};
  if (is_sphere) {
    // Least squares of |p - c|^2 - r^2, which is linear in c and r^2 - |c|^2: exact for points of a sphere, or of a part of one.
    Vec3 skew = Vec3::Zero();
    for (const Vec3& p : points) skew += (p - mean).squaredNorm() / n * (p - mean);
    const Vec3 off = covariance.ldlt().solve(0.5 * skew);
    if (off.allFinite()) shape.center += off;
    shape.tube = std::sqrt(covariance.trace() + (shape.center - mean).squaredNorm());
  } else {
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(covariance);
    shape.frame << axes.eigenvectors().col(1), axes.eigenvectors().col(2), axes.eigenvectors().col(0);
    // Of a torus, the mean square along its axis is half of the tube's squared radius.
    shape.tube = std::sqrt(2.0 * std::max(0.0, axes.eigenvalues()[0]));
    for (const Vec3& p : points) shape.ring += (shape.frame.leftCols<2>().transpose() * (p - mean)).norm() / n;
  }
  Sums sums = sumUp(shape, points);
  for (int k = 0; k < kMaxIterations; ++k) {
    // Unknowns without a derivative (a sphere's tilt) do not change: the factorisation skips zero pivots.
    const Shape next = shape.moved(sums.normal.ldlt().solve(sums.descent));
    const Sums next_sums = sumUp(next, points);
    if (!(next_sums.squares < sums.squares)) break;
    const bool has_converged = sums.squares - next_sums.squares < kConverged * sums.squares;
    shape = next;
    sums = next_sums;
    if (has_converged) break;
  }
  FittedShape found;
  found.radius = is_sphere ? shape.tube : shape.ring;
  found.tube_radius = is_sphere ? 0.0 : shape.tube;
  found.root_mean_square = std::sqrt(sums.squares / n);
  found.largest = sums.largest;
  return found;
}

}  // namespace

FittedShape fitSphere(const Points& points) { return fit("sphere", points, true); }

FittedShape fitTorus(const Points& points) { return fit("torus", points, false); }

}  // namespace deformable_surface::geometry
