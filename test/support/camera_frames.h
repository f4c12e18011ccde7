// Frames of a depth camera with the truth: what each pixel sees, and which pixels are neighbours on the surface. The camera
// projects a pattern and triangulates. Its noise is in the disparity, so it grows with the square of the depth. Surfaces that the
// projector does not reach are missing.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

#include <functional>
#include <vector>

namespace deformable_surface::test {

/// A pinhole camera that looks along +z, with x to the right and y down; the projector is the baseline to the right of it.
struct DepthCamera {
  Index width = 640, height = 480;
  double focal_length = 575.0;  // px
  double baseline = 0.075;      // m
  double noise = 0.0;           // px of disparity, standard deviation
  double quantum = 0.0;         // px of disparity; 0 = not quantised. Sensors that match speckles have 1/8
  /// px: noise is the mean of as many pixels on both sides, twice, as where patterns are matched in windows; its deviation stays.
  Index smoothing = 0;
  double missing = 0.05;  // share of the pixels
  bool has_shadows = true;
  double flying = 0.0;  // share of the pixels at gaps whose disparity lies somewhere between those of the two sides
  unsigned seed = 1;

  Vec2 center() const { return 0.5 * Vec2(width - 1, height - 1); }  // px
  double disparity(double depth) const { return focal_length * baseline / depth; }
  /// m, standard deviation of the depth from the noise and the quantum.
  double depthNoise(double depth) const;
};

/// A piece of surface, unfolded: `place` maps its plane (m) to the camera's frame, without stretch except for gentle waves.
struct Sheet {
  std::vector<Vec2> outline;  // a simple polygon on the plane, m
  std::function<Vec3(const Vec2&)> place;
  double cell = 0.0;  // m: between two points of the plane that are so near the sheet is straight; 0 = everywhere
};

/// The output of a camera, and the truth. Arrays are by pixel, row by row.
struct CameraFrame {
  cloud::PointCloud cloud;   // organised; NaN where nothing is seen
  cloud::PointCloud clean;   // the same pixels where they truly are
  std::vector<Index> sheet;  // that the pixel's ray meets first, whether it is seen or not; -1: none
  Points positions;          // m, where it meets it; NaN where none
  Points normals;            // unit, there
  std::vector<Vec2> places;  // m, there, on the unfolded sheet
  std::vector<char> flies;   // the disparity is one of neither side
  std::vector<char> in_shadow;
  std::vector<Sheet> sheets;
  DepthCamera camera;

  Index size() const { return static_cast<Index>(sheet.size()); }
  bool isSeen(Index pixel) const { return cloud.positions[pixel].allFinite(); }
};

/// Deterministic: the same draws for every noise, quantum and share.
CameraFrame takeFrame(const DepthCamera& camera, const std::vector<Sheet>& sheets);

/// m, the length of the path along the sheet between the places that two pixels see: the straight line on the unfolded sheet.
/// Where that leaves the outline, the path by one of its corners. Infinite between sheets, and where a path has several corners.
double findTrueDistance(const CameraFrame& frame, Index pixel, Index other);

/// Whether that length is less than twice the straight distance and two pixels. Otherwise a gap of the true surface lies between
/// them.
bool areTrueNeighbors(const CameraFrame& frame, Index pixel, Index other);

/// The pieces of the true surface that the visible pixels show: what true neighbours at most two pixels apart connect. Number of
/// pixels of each piece that has at least min_size, largest first.
std::vector<Index> findTruePieces(const CameraFrame& frame, Index min_size);

}  // namespace deformable_surface::test
