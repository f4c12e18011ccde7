// The sphere and the round torus that are nearest to points: how far a surface is from a shape that nobody told it of. Apart from
// the solids, whose place and size are given.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::geometry {

/// Of least squares of the points' distances from it, m.
struct FittedShape {
  double radius = 0.0;       // of the sphere, or of the circle in the middle of the torus's tube
  double tube_radius = 0.0;  // of a sphere 0
  double root_mean_square = 0.0;
  double largest = 0.0;
};

/// Gauss-Newton's method for the centre and the radius, from the sphere of least squares of squared distances on. Refuses fewer
/// than four points and such as are not finite.
FittedShape fitSphere(const Points& points);

/// The same for the centre, the axis and both radii. The axis is at first the direction in which the points vary least, as those
/// of a torus do along its own. Refuses fewer than seven points and such as are not finite.
FittedShape fitTorus(const Points& points);

}  // namespace deformable_surface::geometry
