// A pinhole model of an organised cloud: a depth for every pixel. Private: see sensor_noise.h.
#pragma once

#include "deformable_surface/cloud/clean.h"

#include <optional>

namespace deformable_surface::cloud {

struct DepthImage {
  Index width = 0, height = 0;
  Vec3 eye = Vec3::Zero();            // m
  bool is_eye_found = false;          // in rows and columns: they do not fit a camera at input.eye()
  Mat3 view = Mat3::Identity();       // eye + depth view (u, v, 1) is the point of column u, row v; m
  std::vector<double> inverse_depth;  // (height x width) 1/m, along the optical axis; 0: a hole
  std::vector<Index> input;           // (height x width) point of the cloud at each pixel, -1: none
  bool is_grid_found = false;         // the cloud is a list of points, which lie on the rays of these pixels

  Vec3 ray(Index u, Index v) const { return view * Vec3(u, v, 1.0); }
  /// Distance of neighbouring pixels at depth 1, m.
  double pixel() const { return view.col(0).norm(); }
};

/// The depth image of a cloud whose rows and columns (of a list of points: those that findPixelGrid() finds) fit a pinhole
/// camera: at input.eye(), else where they show it to be. Noise along the lines of sight, of any size, makes that place unique;
/// points of one exact plane fit many. Else none. cloud: clean(input). O(n).
std::optional<DepthImage> findDepthImage(const PointCloud& input, const CleanCloud& cloud);

}  // namespace deformable_surface::cloud
