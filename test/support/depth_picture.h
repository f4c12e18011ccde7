// Images of a depth camera at the origin that looks along z, from a function for the depth. camera_frames.h renders surfaces
// instead.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace deformable_surface::test {

struct Camera {
  int width = 160, height = 120;
  double focal = 575.0;     // pixels
  double baseline = 0.075;  // m
  double step = 0.125;      // pixels of disparity; 0 = none
  double noise = 0.0;       // standard deviation, pixels of disparity
  unsigned seed = 1;

  /// Of the ray through a pixel, at z = 1.
  Vec3 direction(int row, int column) const { return {(column - 0.5 * width) / focal, (row - 0.5 * height) / focal, 1.0}; }
};

/// depth(row, column): m along z, NaN where nothing is seen.
template <class Depth>
cloud::PointCloud takeFrame(const Camera& camera, const Depth& depth) {
  cloud::PointCloud cloud;
  cloud.width = static_cast<std::uint32_t>(camera.width);
  cloud.height = static_cast<std::uint32_t>(camera.height);
  std::mt19937 random(camera.seed);
  std::normal_distribution<double> normal;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      double disparity = camera.focal * camera.baseline / depth(row, column) + camera.noise * normal(random);
      if (camera.step > 0.0) disparity = camera.step * std::round(disparity / camera.step);
      cloud.positions.push_back(camera.focal * camera.baseline / disparity * camera.direction(row, column));
    }
  }
  return cloud;
}

/// Depth at which the ray of a pixel meets the plane normal . p = offset.
inline double meetPlane(const Vec3& ray, const Vec3& normal, double offset) { return offset / normal.dot(ray); }

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

}  // namespace deformable_surface::test
