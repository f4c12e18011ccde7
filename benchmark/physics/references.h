// The exact answers that need more than a formula: the elastica under its weight and an end force, Hencky's membrane, the hanging
// elastic cable, a beam that is let go, the clamped plate, the ring that is pressed flat.
#pragma once

#include "deformable_surface/base/types.h"

#include <Eigen/Core>

#include <limits>
#include <vector>

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

/// An inextensible ring of radius 1 and rigidity 1 under the external pressure P, buckled into two lobes whose halves may not
/// come nearer than the gap; P from 3 to that of contact along a line [flaherty1972]. Along the arc, from the widest point on:
///   kappa'' = c kappa - kappa^3 / 2 + P,  kappa' = 0 at both ends of a quarter, or half of the contact force at the second.
struct FlatRing {
  double half_height = 0.0, half_width = 0.0, force = 0.0;  // force: of the contact
  double flattest = 0.0;                                    // curvature where the halves meet, negative: hollow
  std::vector<Vec2> quarter;  // from the widest point to the middle of a half, evenly over the arc; about the centre
};
FlatRing solveRing(double pressure, double gap);
/// The pressure at which the free ring has that half height, above 0 and below 1.
double findRingPressure(double half_height);

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
