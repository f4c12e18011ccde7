#include "deformable_surface/model/oriented_particles/lattice.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/model/oriented_particles/tear_strain.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr double kCoreShare = 0.5;  // of the spacing: far nearer than any sound state brings two particles
constexpr double kDensest = 0.3;    // of r0: a lattice that is denser has more neighbours than lists hold

// Sum of term(distance) over all lattice points but the origin within the cutoff, in the order of the rows.
template <class Term>
double sumOverLattice(bool is_row, double spacing, double cutoff, const Term& term) {
  const int most = static_cast<int>(std::ceil(1.2 * cutoff / spacing)) + 1;  // rows are sqrt(3) / 2 apart
  double sum = 0.0;
  for (int i = -most; i <= most; ++i)
    for (int j = is_row ? 0 : -most; j <= (is_row ? 0 : most); ++j) {
      const double d = spacing * std::sqrt(static_cast<double>(i * i + i * j + j * j));
      if (d > 0.0 && d < cutoff) sum += term(d);
    }
  return sum;
}

void evaluate(const PairPotentials& pair, double d, double& value, double& slope) {
  double on, on_slope;
  switchOff(pair, d, on, on_slope);
  evaluateLennardJones(pair, d, 1.0 / d, on, on_slope, value, slope);
}

// Half the derivative of the energy per particle by the logarithm of the spacing.
double findTension(const PairPotentials& pair, bool is_row, double spacing) {
  return sumOverLattice(is_row, spacing, pair.cutoff, [&](double d) {
    double value, slope;
    evaluate(pair, d, value, slope);
    return d * slope;
  });
}

// The spacing without tension for r0 = 1: the nearest below r0, where no pair repels yet.
double findRestSpacing(const PairPotentials& unit, bool is_row) {
  constexpr double kStep = 0.995;
  double high = 1.0, low = 1.0;
  while (findTension(unit, is_row, low) >= 0.0) {
    if (low < kDensest)
      throw InputError("oriented_particles.cutoff: found " + formatReal(unit.cutoff) +
                       ", with which these exponents let the surface collapse; accepted: a smaller one, or larger exponents");
    high = low;
    low *= kStep;
  }
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (findTension(unit, is_row, middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// The stretch, d / r0 - 1, at which a bond of these potentials (r0 = 1) carries most.
double findStrongestStretch(const PairPotentials& unit) {
  constexpr int kSteps = 20000;
  double largest = 0.0, strongest = 1.0;
  for (int k = 0; k < kSteps; ++k) {
    const double d = 1.0 + (unit.cutoff - 1.0) * k / kSteps;
    double value, slope;
    evaluate(unit, d, value, slope);
    if (!(slope > largest)) continue;
    largest = slope;
    strongest = d;
  }
  return strongest - 1.0;
}

void setCutoff(double cutoff, PairPotentials& unit) {
  unit.cutoff = cutoff;
  unit.switch_begin = 0.5 * (1.0 + cutoff);
}

// The potentials for r0 = 1.
PairPotentials makeUnit(const OrientedParticlesParams& params) {
  PairPotentials unit;
  unit.repulsion = static_cast<int>(params.exponents[0]);
  unit.attraction = static_cast<int>(params.exponents[1]);
  unit.depth = unit.distance = 1.0;
  setCutoff(params.cutoff, unit);
  return unit;
}

// Shortens the cutoff until bonds carry most at this stretch, unless they already do at a smaller one.
void shortenTo(double tear_strain, PairPotentials& unit) {
  if (!(tear_strain < findStrongestStretch(unit))) return;
  double low = 1.0 + tear_strain, high = unit.cutoff;
  for (int k = 0; k < 30; ++k) {
    setCutoff(0.5 * (low + high), unit);
    (findStrongestStretch(unit) < tear_strain ? low : high) = unit.cutoff;
  }
}

}  // namespace

double findMostTearStrain(const OrientedParticlesParams& params) {
  constexpr double kDigits = 1e4, kRounding = 1e-6;  // the number in a message is accepted itself, and 1.6 - 1 is 0.6
  const double most = params.bonds == ParticleBonds::kKept ? params.cutoff - 1.0 : findStrongestStretch(makeUnit(params));
  return std::floor(kDigits * most + kRounding) / kDigits;
}

std::string findTearStrainProblem(const OrientedParticlesParams& params) {
  if (params.tear_strain == 0.0) return "";
  const double most = findMostTearStrain(params);
  if (params.tear_strain <= most) return "";
  const std::string reason = params.bonds == ParticleBonds::kKept ? ", the strain at the cutoff, beyond which no bond holds"
                                                                  : ", where bonds of these exponents and this cutoff carry most";
  return "found " + formatReal(params.tear_strain) + "; accepted: up to " + formatReal(most) + reason;
}

Lattice calibrateLattice(double spacing, const MaterialParams& material, const OrientedParticlesParams& params) {
  if (!(spacing > 0.0 && spacing <= kMaxLength))
    throw InputError("oriented_particles.spacing: found " + formatReal(spacing) + " m; accepted: above 0, to " +
                     formatReal(kMaxLength) + " m");
  const bool is_row = params.mode == ParticleMode::kPlane;
  const std::string problem = findTearStrainProblem(params);
  if (!problem.empty()) throw InputError("oriented_particles.tear_strain: " + problem);
  PairPotentials unit = makeUnit(params);
  if (params.tear_strain > 0.0) shortenTo(params.tear_strain, unit);

  Lattice lattice;
  lattice.spacing = spacing;
  lattice.area_per_particle = (is_row ? 1.0 : 0.5 * std::sqrt(3.0)) * spacing * spacing;
  PairPotentials& pair = lattice.pair;
  pair = unit;
  pair.distance = spacing / findRestSpacing(unit, is_row);
  pair.core = kCoreShare * spacing;
  pair.switch_begin *= pair.distance;
  pair.cutoff *= pair.distance;
  pair.is_anisotropic = params.weighting == ParticleWeighting::kAnisotropic;
  const double width = params.weighting_width * spacing, height = params.weighting_height * spacing;
  pair.inverse_width = 1.0 / (width * width);
  pair.inverse_height = 1.0 / (height * height);

  const auto sum = [&](const auto& term) { return sumOverLattice(is_row, spacing, pair.cutoff, term); };
  // psi in the lattice's plane.
  const auto weigh = [&](double d) {
    double psi, slope;
    if (pair.is_anisotropic) {
      switchOff(pair, d, psi, slope);
      return psi * std::exp(-0.5 * d * d * pair.inverse_width);
    }
    weighByDistance(pair, d * d, psi, slope);
    return psi;
  };
  // The moduli per e0, alpha_N and alpha_P: second differences of the energy per area of the strained and the bent lattice. With
  // curvatures k1, k2 a neighbour at R has |n_i - n_j|^2 = |k R|^2 and n.r = R k R / 2; a hexagonal lattice is isotropic in both.
  const double area = lattice.area_per_particle;
  const double by_depth =
      (is_row ? 1.0 : 1.0 / 3.0) / area * sum([&](double d) { return d * d * findLennardJonesCurvature(pair, d); });
  const double by_normals = (is_row ? 2.0 : 1.0) / area * sum([&](double d) { return d * d * weigh(d); });
  const double by_planes = (is_row ? 0.5 : 3.0 / 16.0) / area * sum([&](double d) { return d * d * d * d * weigh(d); });
  const double depth = material.young_modulus * material.thickness / by_depth;
  // Beyond first neighbours the outer bonds pull and the inner ones push. In a bent lattice chords are shorter than arcs, which
  // releases energy. The other potentials compensate for it.
  const double given_back = (is_row ? 1.0 / 12.0 : 1.0 / 32.0) / area * sum([&](double d) {
                              double value, slope;
                              evaluate(pair, d, value, slope);
                              return d * d * d * slope;
                            });
  const double half_rigidity = 0.5 * (material.bendingRigidity() + params.lennard_jones * depth * given_back);
  const double planarity = half_rigidity / by_planes;
  pair.co_planarity = params.co_planarity * planarity;
  pair.co_normality = params.co_normality * half_rigidity / by_normals;
  pair.co_circularity = params.co_circularity * planarity;

  // Stiffness against moving and turning a single particle; about an axis in the plane, half the squared distances count.
  const double moving = depth * sum([&](double d) { return std::max(0.0, 2.0 * findLennardJonesCurvature(pair, d)); });
  const double lever = is_row ? 2.0 : 1.0;
  const double turning = sum([&](double d) {
    return weigh(d) * (4.0 * pair.co_normality + lever * d * d * (pair.co_planarity + 2.0 * pair.co_circularity));
  });
  lattice.inertia_by_mass = std::max(turning / moving, material.thickness * material.thickness / 12.0);

  pair.depth = params.lennard_jones * depth;
  lattice.energy_per_particle = sum([&](double d) {
    double value, slope;
    evaluate(pair, d, value, slope);
    return value;
  });
  return lattice;
}

}  // namespace deformable_surface::model
