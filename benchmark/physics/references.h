// The exact answers that need more than a formula: the elastica under its weight and an end force, Hencky's membrane, the hanging
// elastic cable, a beam that is let go, the clamped plate.
#pragma once

#include "deformable_surface/base/types.h"

#include <Eigen/Core>

#include <limits>

namespace deformable_surface::physics {

/// An inextensible strip of length 1 and rigidity 1, clamped horizontally at one end:
///   theta'' + (gamma (1 - s) + force) cos(theta) = 0,  theta(0) = 0, theta'(1) = 0,  theta below the horizontal.
/// gamma = weight per length * L^3 / D, force = downward force at the end * L^2 / D.
struct ElasticaTip {
  double droop = 0.0, reach = 0.0;  // of the free end, over the length
};
ElasticaTip solveElastica(double gamma, double force);

/// w0 / (a q^(1/3)) of a clamped circular membrane under the pressure p, q = p a / (E h), for q -> 0 [hencky1915, corrected].
/// With B(x) = sum b_n x^n:  sum n (n + 1) b_n x^n = -2 x / B(x)^2,  sum (2 n + 1 - nu) b_n = 0,  w0 = a q^(1/3) int_0^1 dx /
/// B(x).
double solveHencky(double poisson_ratio);

/// An elastic cable between two supports of equal height [irvine1981]: position at the unstretched arc length s.
struct ElasticCable {
  double stiffness, weight, length;  // E A (N), total weight (N), unstretched length (m)

  double x(double s, double tension) const;
  double z(double s, double tension) const;  // below the supports
  /// The horizontal tension for the span between the supports.
  double solveTension(double span) const;
};

constexpr double kAtRest = std::numeric_limits<double>::infinity();

/// The deflection of a cantilever of length, rigidity and mass per length 1 under the load 1 that acts from time zero on; s: from
/// the clamp. w = s^2 (6 - 4 s + s^2) / 24 - sum a_n phi_n(s) cos(b_n^2 time), with the modes phi_n of Euler and Bernoulli. At
/// kAtRest the first part alone.
double sagCantilever(double s, double time);

/// The deflection of the clamped square plate of side, rigidity and load 1, by Ritz's method with polynomials: least
/// 1/2 int (w_xx + w_yy)^2 - int w.
class ClampedPlate {
 public:
  ClampedPlate();
  double operator()(double x, double y) const;  // from a corner; 0 outside

 private:
  Eigen::MatrixXd amplitudes_;
};

}  // namespace deformable_surface::physics
