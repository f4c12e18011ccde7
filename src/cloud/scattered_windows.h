// The counterpart of depth_windows.h for points without rows and columns. Windows are nearest neighbours as seen from the eye or,
// if no eye is known, in space. Private.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"

namespace deformable_surface::cloud {

struct ScatteredNoise {
  double deviation = 0.0;  // m, across the surface: median over the points. 0: the offsets from the surface are its shape
  double spacing = 0.0;    // m, of points on the surface: median
  bool is_thick = false;   // points fill their neighbourhoods as in a ball: they show no surface
};
/// From the residuals of the best quadratics over windows of a sample of the points. Noise leaves the same variance in windows of
/// twice the points; shape leaves more; layers leave two groups. tree: holds the positions. O(n log n).
ScatteredNoise measureNoise(const Points& positions, const KdTree& tree);

struct FittedPoints {
  Points positions;       // (n) on the surface; unchanged for points without explained windows
  Index unexplained = 0;  // points that fit no window
  bool is_seen = false;   // points were moved along their lines of sight from the eye, else along normals
};
/// Windows of count points each. deviation: m, across the surface; measured: its measured value. eye: the possible viewpoint.
/// Points seen from there have directions that are spaced as regularly as pixels. O(n (log n + count)).
FittedPoints fitWindows(const Points& positions, const Vec3& eye, double deviation, double measured, Index count);

}  // namespace deformable_surface::cloud
