// The same as depth_windows.h of points without rows and columns: windows are nearest neighbours, as the eye sees them or, where
// no eye is known, in space. Private.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

struct ScatteredNoise {
  double deviation = 0.0;  // m, across the surface: median over the points. 0: what is off the surface is its shape
  double spacing = 0.0;    // m, of points on the surface: median
  bool is_thick = false;   // points fill their neighbourhoods as those of a ball do: they show no surface
};
/// From what the best quadratics over windows of a sample of the points leave: of noise as much in windows of twice the points,
/// of shape more; of layers in two groups. O(n log n).
ScatteredNoise measureNoise(const Points& positions);

struct FittedPoints {
  Points positions;       // (n) on the surface; of a point without explained windows what it was
  Index unexplained = 0;  // points that fit no window
  bool is_seen = false;   // points were moved along their lines of sight from the eye, else along normals
};
/// Windows of count points each. deviation: m, across the surface; measured: what was measured of it. eye: from where the points
/// may have been seen; whether they were, their directions tell, which are as far from each other as pixels then.
/// O(n (log n + count)).
FittedPoints fitWindows(const Points& positions, const Vec3& eye, double deviation, double measured, Index count);

}  // namespace deformable_surface::cloud
