#include "depth_image.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "pixel_grid.h"

namespace deformable_surface::cloud {
namespace {

constexpr Index kFewestPixels = 100;
constexpr Index kSampled = 2000;    // pixels used to fit the camera
constexpr double kOffRay = 0.1;     // fraction of a pixel: tolerance of a point's distance from its ray
constexpr double kStraying = 0.02;  // fraction of the pixels that may lie farther off: some drivers move single points
// Least ratio of the second smallest eigenvalue to the smallest for a single camera to fit. Points in one plane, and those
// without depth, fit many: there it is about 1.
constexpr double kUnique = 1e3;
constexpr double kRounding = 1e-13;  // of the largest eigenvalue: smaller ones are zero
constexpr double kFarthest = 1e3;    // radii of the cloud to the eye: from farther all lines of sight are parallel

struct Sighting {
  Vec3 pixel;      // (u, v, 1), scaled
  Vec3 direction;  // unit, from the eye
};

// The matrix A that minimises the sum of |d x A m|^2, up to its length.
Mat3 fitView(const std::vector<Sighting>& sightings) {
  using Mat9 = Eigen::Matrix<double, 9, 9>;
  Mat9 normal = Mat9::Zero();
  for (const Sighting& s : sightings) {
    const Mat3 off = Mat3::Identity() - s.direction * s.direction.transpose();  // a projection, hence its own square
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) normal.block<3, 3>(3 * a, 3 * b) += s.pixel[a] * s.pixel[b] * off;
  }
  const Eigen::SelfAdjointEigenSolver<Mat9> solver(normal);
  const Eigen::Matrix<double, 9, 1> least = solver.eigenvectors().col(0);
  return Eigen::Map<const Mat3>(least.data());
}

// The eye of the camera P (3 x 4) that images the points at their pixels, P (p, 1) ~ (u, v, 1): the direct linear transformation
// [Hartley and Zisserman 2004, sec. 7.1]. Noise moves points along their lines of sight, so it does not move the eye. pixels: (u,
// v, 1), scaled to -1 to 1. None if several cameras fit.
std::optional<Vec3> findEye(const Points& points, const Points& pixels) {
  using Mat12 = Eigen::Matrix<double, 12, 12>;
  Vec3 center = Vec3::Zero();
  for (const Vec3& p : points) center += p / static_cast<double>(points.size());
  double radius = 0.0;
  for (const Vec3& p : points) radius += (p - center).squaredNorm() / static_cast<double>(points.size());
  radius = std::sqrt(radius);
  if (!(radius > 0.0)) return std::nullopt;

  Mat12 normal = Mat12::Zero();
  for (std::size_t s = 0; s < points.size(); ++s) {
    Eigen::Vector4d point;
    point << (points[s] - center) / radius, 1.0;
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Matrix<double, 12, 1> row = Eigen::Matrix<double, 12, 1>::Zero();
      row.segment<4>(4 * axis) = point;
      row.tail<4>() = -pixels[s][axis] * point;
      normal += row * row.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Mat12> solver(normal);
  const auto& values = solver.eigenvalues();
  if (!(values[1] > kUnique * std::max(std::abs(values[0]), kRounding * values[11]))) return std::nullopt;
  const Eigen::Matrix<double, 12, 1> least = solver.eigenvectors().col(0);
  const Eigen::Matrix<double, 3, 4> camera = Eigen::Map<const Eigen::Matrix<double, 4, 3>>(least.data()).transpose();
  const Eigen::FullPivLU<Mat3> turn(camera.leftCols<3>());
  const Vec3 eye = -turn.solve(camera.col(3));  // the camera sees it nowhere: P (eye, 1) = 0
  if (!(turn.isInvertible() && eye.norm() < kFarthest)) return std::nullopt;
  return center + radius * eye;
}

// (u, v, 1), scaled to -1 to 1 for numerical conditioning.
Mat3 scalePixels(Index width, Index height) {
  Mat3 scale;
  scale << 2.0 / width, 0.0, -1.0, 0.0, 2.0 / height, -1.0, 0.0, 0.0, 1.0;
  return scale;
}

// None if too many points are off the rays of their pixels. seen: pixels with a point other than the eye.
std::optional<DepthImage> fitImage(const PointCloud& input, const PixelGrid& grid, const std::vector<Index>& seen,
                                   const Vec3& eye) {
  const Index width = grid.width, height = grid.height;
  const Mat3 scale = scalePixels(width, height);
  const std::size_t stride = std::max<std::size_t>(1, seen.size() / kSampled);
  const auto pointAt = [&](Index pixel) -> const Vec3& { return input.positions[grid.input[pixel]]; };
  std::vector<Sighting> sightings;
  for (std::size_t s = 0; s < seen.size(); s += stride)
    sightings.push_back({scale * Vec3(seen[s] % width, seen[s] / width, 1.0), (pointAt(seen[s]) - eye).normalized()});
  DepthImage image;
  image.width = width;
  image.height = height;
  image.eye = eye;
  image.view = fitView(sightings) * scale;

  // Depths are measured along the axis; all rays view (u, v, 1) have the same product with it.
  if (!(std::abs(image.view.determinant()) > 0.0)) return std::nullopt;
  image.view *= Vec3(image.view.transpose().inverse() * Vec3::UnitZ()).norm();
  const Index middle = seen[seen.size() / 2];
  if (image.ray(middle % width, middle / width).dot(pointAt(middle) - image.eye) < 0.0) image.view = -image.view;

  std::size_t straying = 0;
  image.inverse_depth.assign(grid.input.size(), 0.0);
  for (const Index i : seen) {
    const Vec3 ray = image.ray(i % width, i / width), to_point = pointAt(i) - image.eye;
    const double depth = to_point.dot(ray) / ray.squaredNorm();
    const double pixel = std::min(image.view.col(0).norm(), image.view.col(1).norm());
    straying += !(depth > 0.0 && (to_point - depth * ray).norm() <= kOffRay * pixel * depth);
    if (depth > 0.0) image.inverse_depth[i] = 1.0 / depth;
  }
  if (!(static_cast<double>(straying) <= kStraying * static_cast<double>(seen.size()))) return std::nullopt;
  return image;
}

std::optional<PixelGrid> takeRows(const PointCloud& input) {
  const Index width = static_cast<Index>(input.width), height = static_cast<Index>(input.height);
  if (width < 3 || height < 3 || std::int64_t{width} * height != input.size()) return std::nullopt;
  PixelGrid grid{width, height, std::vector<Index>(input.size())};
  std::iota(grid.input.begin(), grid.input.end(), 0);
  return grid;
}

}  // namespace

std::optional<DepthImage> findDepthImage(const PointCloud& input, const CleanCloud& cloud) {
  std::optional<PixelGrid> grid = input.height > 1 ? takeRows(input) : findPixelGrid(input, cloud);
  if (!grid) return std::nullopt;
  std::vector<Index> seen;
  for (Index p = 0; p < static_cast<Index>(grid->input.size()); ++p) {
    const Index i = grid->input[p];
    if (i >= 0 && cloud.point_of_input[i] >= 0 && input.positions[i] != input.eye()) seen.push_back(p);
  }
  if (static_cast<Index>(seen.size()) < kFewestPixels) return std::nullopt;
  std::optional<DepthImage> image = fitImage(input, *grid, seen, input.eye());
  if (!image && input.height > 1) {
    // A cloud that was turned into another frame has lost its eye.
    const Mat3 scale = scalePixels(grid->width, grid->height);
    const std::size_t stride = std::max<std::size_t>(1, seen.size() / kSampled);
    Points points, pixels;
    for (std::size_t s = 0; s < seen.size(); s += stride) {
      points.push_back(input.positions[grid->input[seen[s]]]);
      pixels.push_back(scale * Vec3(seen[s] % grid->width, seen[s] / grid->width, 1.0));
    }
    const std::optional<Vec3> eye = findEye(points, pixels);
    if (eye) image = fitImage(input, *grid, seen, *eye);
    if (image) image->is_eye_found = true;
  }
  if (!image) return std::nullopt;
  image->is_grid_found = input.height <= 1;
  image->input = std::move(grid->input);
  return image;
}

}  // namespace deformable_surface::cloud
