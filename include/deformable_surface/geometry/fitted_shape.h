// Fits a sphere or a round torus to points: measures how far a surface is from such a shape when its place and size are
// unknown.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::geometry {

/// The shape with the least sum of squared distances of the points from it, m.
struct FittedShape {
  double radius = 0.0;       // of the sphere, or of the circle in the middle of the torus's tube
  double tube_radius = 0.0;  // of a sphere 0
  double root_mean_square = 0.0;
  double largest = 0.0;
};

/// Gauss-Newton's method for the centre and the radius. It starts from the sphere that minimises squared differences of squared
/// distances. Refuses fewer than four points and points that are not finite.
FittedShape fitSphere(const Points& points);

/// The same for the centre, the axis and both radii. The first axis is the direction in which the points vary least, as for the
/// points of a torus. Refuses fewer than seven points and points that are not finite.
FittedShape fitTorus(const Points& points);

}  // namespace deformable_surface::geometry
