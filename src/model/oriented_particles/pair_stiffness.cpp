// Bounds of the stiffness of pairs, for stable steps. Unlike forces they are neither vectorised nor needed in every pass.
#include "deformable_surface/model/oriented_particles/pair_forces.h"

#include "raise_two.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr double kSwitchBend = 60.0 / (6.0 * 1.7320508);  // the largest second derivative of the switch, times its width squared

// A bound of the largest eigenvalue of a symmetric matrix: the root of the sum of squares.
double findLargest(const double* k) {
  return std::sqrt(k[0] * k[0] + k[1] * k[1] + k[2] * k[2] + 2.0 * (k[3] * k[3] + k[4] * k[4] + k[5] * k[5]));
}

}  // namespace

// For E = psi B with B a sum of squares: psi times the squares of the gradients of B's roots and, where the surface is bent, the
// other terms of the product rule. Norms of vectors stand for all their components.
PairStiffness boundStiffness(const PairPotentials& p, const PackedParticles& particles, Index i, Index j) {
  const Eigen::Map<const Vec4> place_i(particles.place(i)), place_j(particles.place(j));
  const Eigen::Map<const Vec4> normal_i(particles.normal(i)), normal_j(particles.normal(j));
  const Vec3 r = place_j.head<3>() - place_i.head<3>();
  const double squared = r.squaredNorm(), d = std::sqrt(squared);
  PairStiffness k;
  if (!(d < p.cutoff)) return k;
  const double strength = std::min(place_i[3], place_j[3]);
  double on, on_slope, phi, slope;
  switchOff(p, d, on, on_slope);
  evaluateLennardJones(p, d, 1.0 / d, on, on_slope, phi, slope);
  k.x = 2.0 * (d > p.distance ? strength : 1.0) * std::max({0.0, findLennardJonesCurvature(p, d), slope / std::max(d, p.core)});
  const double smooth = strength * normal_i[3] * normal_j[3];
  if (!p.bends() || !(smooth > 0.0)) return k;

  // The largest effect of rest curvatures: on u, on n_i - n_j, and, as a factor, on their derivatives.
  double bent = 0.0;
  if (!particles.curvatures.empty()) bent = std::max(findLargest(particles.curvature(i)), findLargest(particles.curvature(j)));
  const double height = 0.5 * bent * squared, steeper = 1.0 + bent * d;
  const double ui = std::abs(normal_i.head<3>().dot(r)) + height, uj = std::abs(normal_j.head<3>().dot(r)) + height, s = ui + uj;
  const double normals = (normal_i - normal_j).head<3>().norm() + bent * d;
  // psi, the sizes of its slope and of its second derivatives by position, and of those by turning the normal.
  double psi, psi_slope, psi_bend, turned = 0.0, turned_twice = 0.0, turned_moved = 0.0;
  if (p.is_anisotropic) {
    const double lower = std::min(ui, uj), steep = d * p.inverse_height, width = p.cutoff - p.switch_begin;
    psi = -kHalfLog2E * (squared * p.inverse_width + (p.inverse_height - p.inverse_width) * lower * lower);
    double same = psi;
    raiseTwo(psi, same);
    psi *= on;
    psi_slope = psi * steep + std::abs(on_slope);
    psi_bend = psi * (steep * steep + p.inverse_height) + 2.0 * std::abs(on_slope) * steep;
    if (on < 1.0) psi_bend += kSwitchBend / (width * width);
    turned = psi * steep * std::max(ui, uj);
    turned_moved = psi * steep + turned * p.inverse_height * std::max(ui, uj);
    turned_twice = turned_moved * d;
  } else {
    const double inverse = 1.0 / (p.cutoff * p.cutoff), q = 1.0 - inverse * squared;
    weighByDistance(p, squared, psi, psi_slope);
    psi_slope *= -d;
    psi_bend = 6.0 * inverse * q * std::max(q, 4.0 * inverse * squared);
  }
  const double planarity = p.co_planarity * steeper * steeper, normality = p.co_normality * steeper * steeper;
  const double circularity = p.co_circularity;
  const double stored = planarity * (ui * ui + uj * uj) + 2.0 * (normality * normals * normals + circularity * s * s);
  // |dB/dr| and |dB/dn|.
  const double by_place = (2.0 * planarity + 8.0 * circularity) * s;
  const double by_normal = 2.0 * planarity * std::max(ui, uj) * d + 4.0 * normality * normals + 4.0 * circularity * s * d;
  k.x += smooth * (psi * (4.0 * planarity + 16.0 * circularity) + 2.0 * psi_slope * by_place + psi_bend * stored);
  k.y = smooth * (psi * (2.0 * planarity * (d + s) + circularity * (8.0 * d + 4.0 * s)) + psi_slope * by_normal +
                  turned * by_place + turned_moved * stored);
  if (bent > 0.0) {
    // n_i - n_j now changes with places, and u with their squares.
    const double by_both = 4.0 * normality * bent, moved = by_both * normals;
    k.x += smooth * (psi * (by_both * bent + 2.0 * planarity * s * bent) + 2.0 * psi_slope * moved);
    k.y += smooth * (psi * (by_both + moved + 2.0 * planarity * s * bent * d) + psi_slope * moved * d);
  }
  k.z = smooth * (psi * (2.0 * planarity * squared + 8.0 * normality + 8.0 * circularity * squared + by_normal) +
                  2.0 * turned * by_normal + turned_twice * stored);
  return k;
}

double boundContactStiffness(const PairPotentials& p, double distance) {
  if (!(distance < p.distance)) return 0.0;
  double on, on_slope, phi, slope;
  switchOff(p, distance, on, on_slope);
  evaluateLennardJones(p, distance, 1.0 / distance, on, on_slope, phi, slope);
  return 2.0 * std::max({0.0, findLennardJonesCurvature(p, distance), slope / std::max(distance, p.core)});
}

}  // namespace deformable_surface::model
