// The neo-Hookean law of one point (StressLaw::kNeoHookean), where four points side by side do not pay. s is the factor of cof F
// in its stress.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::model::neo_hookean {

/// Of J: below it psi is no difference of large numbers.
constexpr double kFarFromRest = 0.25;

/// psi, J/m^3.
double findDensity(double mu, double lambda, const Mat3& F);
/// P, Pa.
Mat3 findStress(double mu, double lambda, const Mat3& F);
/// s, Pa.
double findFactor(double mu, double lambda, double determinant);
/// s, or one of the same sign and nearer to zero with which no motion of the point loses energy.
double limitFactor(double mu, double lambda, const Mat3& F, double s);
/// A bound of the stiffness at F over that at rest.
double boundStiffening(double mu, double lambda, const Mat3& F);

}  // namespace deformable_surface::model::neo_hookean
