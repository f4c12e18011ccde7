// The potentials between two oriented particles as functions of their distance. They are templates: forces are computed
// for four neighbours at once, energies for one.
#pragma once

#include "deformable_surface/base/simd.h"

#include <cmath>

namespace deformable_surface::model {

/// Constants of all pairs. The energy is summed over ordered pairs [Szeliski 1991, eq. 11].
struct PairPotentials {
  double depth = 0.0;                  // J, e0 of the Lennard-Jones potential
  double distance = 0.0;               // m, r0: where that potential is least
  double core = 0.0;                   // m: nearer than this its force stays constant, so that no state has infinite forces
  double switch_begin = 0.0;           // m: from here to the cutoff it is switched off
  double cutoff = 0.0;                 // m
  int repulsion = 12, attraction = 6;  // exponents
  double co_planarity = 0.0, co_circularity = 0.0;  // J/m^2
  double co_normality = 0.0;                        // J
  bool is_anisotropic = false;
  double inverse_width = 0.0, inverse_height = 0.0;  // 1/m^2: 1 / a^2 and 1 / b^2 of [eq. 10]

  bool bends() const { return co_planarity > 0.0 || co_normality > 0.0 || co_circularity > 0.0; }
};

/// m: nearer, the repulsion of a pair holds more energy than a bond, phi > 0. r0 (m / n)^(1 / (n - m)), with the letters of the
/// potential.
inline double findLeastDistance(const PairPotentials& p) {
  return p.distance * std::pow(static_cast<double>(p.attraction) / p.repulsion, 1.0 / (p.repulsion - p.attraction));
}

/// x^exponent.
template <class T>
DEFORMABLE_SURFACE_INLINE void raise(const T& x, int exponent, T& power) {
  T square = x;
  power = x - x + 1.0;
  for (; exponent > 0; exponent >>= 1) {
    if (exponent & 1) power *= square;
    square *= square;
  }
}

/// 1 before switch_begin, 0 beyond the cutoff, twice continuously differentiable; slope, 1/m.
template <class T>
DEFORMABLE_SURFACE_INLINE void switchOff(const PairPotentials& p, const T& d, T& value, T& slope) {
  const double inverse = 1.0 / (p.cutoff - p.switch_begin);
  const T zero = d - d, one = zero + 1.0;
  T t = (d - p.switch_begin) * inverse;
  t = t > zero ? t : zero;
  t = t < one ? t : one;
  const T rest = 1.0 - t;
  value = 1.0 - t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
  slope = -30.0 * inverse * t * t * rest * rest;
}

/// phi = e0 (m / (n - m) (r0 / d)^n - n / (n - m) (r0 / d)^m), J, and its slope, N: with the switch's value and slope at d (m)
/// and, nearer than the core, continued as a straight line. inverse: 1 / d, not read nearer than the core.
template <class T>
DEFORMABLE_SURFACE_INLINE void evaluateLennardJones(const PairPotentials& p, const T& d, const T& inverse, const T& on,
                                                    const T& on_slope, T& value, T& slope) {
  const double share = p.depth / (p.repulsion - p.attraction);
  const T core = d - d + p.core, core_inverse = d - d + 1.0 / p.core;
  const T outside = d > core ? d : core, outside_inverse = d > core ? inverse : core_inverse;
  const T ratio = p.distance * outside_inverse;
  T repulsion, attraction;
  raise(ratio, p.repulsion, repulsion);
  raise(ratio, p.attraction, attraction);
  const T line = (share * p.repulsion * p.attraction) * (attraction - repulsion) * outside_inverse;
  const T level = share * (p.attraction * repulsion - p.repulsion * attraction) + line * (d - outside);
  value = level * on;
  slope = line * on + level * on_slope;
}

/// The isotropic weighting psi = (1 - d^2 / cutoff^2)^3 within the cutoff, and psi' / d, 1/m^2. squared: d^2, m^2.
template <class T>
DEFORMABLE_SURFACE_INLINE void weighByDistance(const PairPotentials& p, const T& squared, T& psi, T& slope_by_distance) {
  const double inverse = 1.0 / (p.cutoff * p.cutoff);
  const T zero = squared - squared;
  T q = 1.0 - inverse * squared;
  q = q > zero ? q : zero;
  psi = q * q * q;
  slope_by_distance = -6.0 * inverse * q * q;
}

/// The second derivative of the Lennard-Jones potential, N/m. Nearer than the core its value there, so that a bound of the
/// stiffness holds when the pair separates again.
inline double findLennardJonesCurvature(const PairPotentials& p, double d) {
  if (!(d < p.cutoff)) return 0.0;
  const double at = d > p.core ? d : p.core, n = p.repulsion, m = p.attraction, share = p.depth / (n - m);
  double repulsion, attraction;
  raise(p.distance / at, p.repulsion, repulsion);
  raise(p.distance / at, p.attraction, attraction);
  const double value = share * (m * repulsion - n * attraction), slope = share * n * m * (attraction - repulsion) / at;
  const double curvature = share * n * m * ((n + 1.0) * repulsion - (m + 1.0) * attraction) / (at * at);
  double on, on_slope;
  switchOff(p, at, on, on_slope);
  const double width = p.cutoff - p.switch_begin, t = (at - p.switch_begin) / width;
  const double on_curvature = t > 0.0 ? -60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / (width * width) : 0.0;
  return curvature * on + 2.0 * slope * on_slope + value * on_curvature;
}

}  // namespace deformable_surface::model
