// The neo-Hookean law of one point (StressLaw::kNeoHookean), where four points side by side do not pay. s is the factor of cof F
// in its stress.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::model::neo_hookean {

/// Of J: below it the logarithm goes on as the parabola that touches it there, so that there are forces in every state.
constexpr double kCrushed = 0.1;

/// psi, J/m^3.
double findDensity(double mu, double lambda, const Mat3& F);
/// P, Pa.
Mat3 findStress(double mu, double lambda, const Mat3& F);
/// The part of psi that depends on J = 1 + growth alone, J/m^3.
double findPressed(double mu, double lambda, double growth);
/// s, Pa, and its derivative by J.
struct Factor {
  double value, slope;
};
Factor findFactor(double mu, double lambda, double J);
/// s, or one of the same sign and nearer to zero, and a slope of at least zero, with which no motion of the point loses energy.
Factor limitFactor(double mu, const Mat3& F, Factor s);
/// A bound of the stiffness at F over that at rest.
double boundStiffening(double mu, double lambda, const Mat3& F);

}  // namespace deformable_surface::model::neo_hookean
