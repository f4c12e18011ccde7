#include "depth_image.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace deformable_surface::cloud {
namespace {

constexpr Index kFewestPixels = 100;
constexpr Index kSampled = 2000;    // pixels used to fit the camera
constexpr double kOffRay = 0.1;     // fraction of a pixel: tolerance of a point's distance from its ray
constexpr double kStraying = 0.02;  // fraction of the pixels that may lie farther off: some drivers move single points

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

}  // namespace

std::optional<DepthImage> findDepthImage(const PointCloud& input, const CleanCloud& cloud) {
  const Index width = static_cast<Index>(input.width), height = static_cast<Index>(input.height);
  if (width < 3 || height < 3 || std::int64_t{width} * height != input.size()) return std::nullopt;
  std::vector<Index> seen;
  for (Index i = 0; i < input.size(); ++i)
    if (cloud.point_of_input[i] >= 0 && input.positions[i] != input.eye()) seen.push_back(i);
  if (static_cast<Index>(seen.size()) < kFewestPixels) return std::nullopt;

  // Pixels are scaled to -1 to 1 for numerical conditioning.
  Mat3 scale;
  scale << 2.0 / width, 0.0, -1.0, 0.0, 2.0 / height, -1.0, 0.0, 0.0, 1.0;
  const std::size_t stride = std::max<std::size_t>(1, seen.size() / kSampled);
  std::vector<Sighting> sightings;
  for (std::size_t s = 0; s < seen.size(); s += stride)
    sightings.push_back(
        {scale * Vec3(seen[s] % width, seen[s] / width, 1.0), (input.positions[seen[s]] - input.eye()).normalized()});
  DepthImage image{width, height, input.eye(), fitView(sightings) * scale, {}};

  // Depths are measured along the axis; all rays view (u, v, 1) have the same product with it.
  if (!(std::abs(image.view.determinant()) > 0.0)) return std::nullopt;
  image.view *= Vec3(image.view.transpose().inverse() * Vec3::UnitZ()).norm();
  const Index middle = seen[seen.size() / 2];
  if (image.ray(middle % width, middle / width).dot(input.positions[middle] - image.eye) < 0.0) image.view = -image.view;

  std::size_t straying = 0;
  image.inverse_depth.assign(input.size(), 0.0);
  for (const Index i : seen) {
    const Vec3 ray = image.ray(i % width, i / width), to_point = input.positions[i] - image.eye;
    const double depth = to_point.dot(ray) / ray.squaredNorm();
    const double pixel = std::min(image.view.col(0).norm(), image.view.col(1).norm());
    straying += !(depth > 0.0 && (to_point - depth * ray).norm() <= kOffRay * pixel * depth);
    if (depth > 0.0) image.inverse_depth[i] = 1.0 / depth;
  }
  if (!(static_cast<double>(straying) <= kStraying * static_cast<double>(seen.size()))) return std::nullopt;
  return image;
}

}  // namespace deformable_surface::cloud
