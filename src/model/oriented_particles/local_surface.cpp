// Weighted fits of normal and height; see the header.
#include "local_surface.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/cloud/links.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_surface::model {
namespace {

// Sine of the largest angle between a line of sight and the plane of the mean normal, 30 degrees: half of the limit for links of
// a fine sampling, because gaps span several spacings.
constexpr double kMaxSlope = 0.5;

// Reach of a fit in its scales: beyond it, weights are below a twentieth.
constexpr double kReach = 2.5;

// Regularisation of the slope of the normals, over the sum of the weights: enough to make a fit on a line of particles
// unique, a few per cent of the slope that two particles in line give.
constexpr double kRidge = 0.01;

// Sum of the x axes over the weights below which they have no common direction.
constexpr double kMinAxis = 0.1;

bool see(const Vec3& position_i, const Vec3& normal_i, const Vec3& position_j, const Vec3& normal_j) {
  if (!(normal_i.dot(normal_j) > 0.0)) return false;
  const Vec3 mean = normal_i + normal_j, line = position_j - position_i;
  return std::abs(mean.dot(line)) <= kMaxSlope * mean.norm() * line.norm();
}

const Points& checked(const Points& positions, const Orientations& orientations) {
  if (positions.size() != orientations.size()) {
    throw InputError("found " + std::to_string(positions.size()) + " positions and " + std::to_string(orientations.size()) +
                     " orientations; accepted: one orientation for each particle");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    constexpr double kUnit = 1e-6;
    if (!positions[i].allFinite() || !(std::abs(orientations[i].squaredNorm() - 1.0) <= kUnit)) {
      throw InputError("found a position or orientation of particle " + std::to_string(i) +
                       " that is no place or no rotation; accepted: finite positions and unit quaternions");
    }
  }
  return positions;
}

}  // namespace

const AreApart LocalSurface::kNoneApart;

LocalSurface::LocalSurface(const Points& positions, const Orientations& orientations, const AreApart& apart)
    : positions_(checked(positions, orientations)), orientations_(orientations), apart_(apart), tree_(positions) {
  for (const Eigen::Quaterniond& q : orientations) normals_.push_back(q * Vec3::UnitZ());
}

bool LocalSurface::sees(Index i, Index j) const {
  return see(positions_[i], normals_[i], positions_[j], normals_[j]) && !(apart_ && apart_(i, j));
}

bool LocalSurface::sees(Index i, const Placed& placed) const {
  return see(positions_[i], normals_[i], placed.position, placed.orientation * Vec3::UnitZ());
}

bool LocalSurface::isClear(const Vec3& point, const Vec3& normal, double radius, const Index (&parents)[2],
                           std::vector<cloud::Neighbor>& found) const {
  tree_.withinRadius(point, (1.0 - kRounding) * radius, found);
  return std::none_of(found.begin(), found.end(), [&](const cloud::Neighbor& q) {
    return q.index != parents[0] && q.index != parents[1] && normals_[q.index].dot(normal) > 0.0;
  });
}

bool LocalSurface::isOpen(const Vec3& point, const Vec3& normal, double radius, double height, const Index (&parents)[2],
                          std::vector<cloud::Neighbor>& found) const {
  tree_.withinRadius(point, std::hypot(radius, height), found);
  const Vec3 up = normal.normalized();
  return std::none_of(found.begin(), found.end(), [&](const cloud::Neighbor& q) {
    const Vec3 offset = positions_[q.index] - point;
    const double above = offset.dot(up);
    return q.index != parents[0] && q.index != parents[1] && normals_[q.index].dot(up) > 0.0 && std::abs(above) <= height &&
           (offset - above * up).norm() <= radius;
  });
}

bool LocalSurface::fits(const Placed& placed, double radius, std::vector<cloud::Neighbor>& found) const {
  tree_.withinRadius(placed.position, radius, found);
  const Vec3 normal = placed.orientation * Vec3::UnitZ();
  return std::none_of(found.begin(), found.end(),
                      [&](const cloud::Neighbor& q) { return normals_[q.index].dot(normal) > 0.0 && !sees(q.index, placed); });
}

double LocalSurface::reachOf(double scale) { return kReach * scale; }

Placed LocalSurface::place(const Vec3& point, double scale, const Index (&parents)[2],
                           std::vector<cloud::Neighbor>& found) const {
  const auto isPart = [&](Index j) {
    return std::any_of(parents, parents + 2, [&](Index p) { return p >= 0 && (p == j || sees(p, j)); });
  };
  tree_.withinRadius(point, kReach * scale, found);
  const auto isNoPart = [&](const cloud::Neighbor& q) { return !isPart(q.index); };
  found.erase(std::remove_if(found.begin(), found.end(), isNoPart), found.end());
  const auto weigh = [&](const cloud::Neighbor& q) { return std::exp(-q.squared_distance / (2.0 * scale * scale)); };

  Vec3 mean = Vec3::Zero();
  for (const cloud::Neighbor& q : found) mean += weigh(q) * normals_[q.index];
  const cloud::TangentPlane plane(point, mean.normalized());

  double sum = 0.0;
  Mat3 matrix = Mat3::Zero(), right = Mat3::Zero();
  for (const cloud::Neighbor& q : found) {
    const double w = weigh(q);
    const Vec2 uv = plane.project(positions_[q.index]) / scale;
    const Vec3 basis(1.0, uv.x(), uv.y());
    sum += w;
    matrix += w * basis * basis.transpose();
    right += w * basis * normals_[q.index].transpose();
  }
  matrix(1, 1) += kRidge * sum;
  matrix(2, 2) += kRidge * sum;
  const Mat3 fitted = matrix.ldlt().solve(right);
  const Vec3 normal = fitted.row(0).transpose().normalized();

  double height = 0.0, total = 0.0;
  Vec3 axis = Vec3::Zero();
  for (const cloud::Neighbor& q : found) {
    const Vec3 bisector = normal + normals_[q.index];
    const double slope = bisector.dot(normal), w = weigh(q);
    height += w * slope * bisector.dot(positions_[q.index] - point);
    total += w * slope * slope;
    axis += w * (Eigen::Quaterniond::FromTwoVectors(normals_[q.index], normal) * xAxis(q.index));
  }
  axis -= axis.dot(normal) * normal;
  if (!(axis.norm() > kMinAxis * sum)) {
    axis = Eigen::Quaterniond::FromTwoVectors(normals_[parents[0]], normal) * xAxis(parents[0]);
    axis -= axis.dot(normal) * normal;
  }
  Mat3 frame;
  frame.col(0) = axis.normalized();
  frame.col(2) = normal;
  frame.col(1) = normal.cross(frame.col(0));
  return {point + height / total * normal, Eigen::Quaterniond(frame).normalized()};
}

}  // namespace deformable_surface::model
