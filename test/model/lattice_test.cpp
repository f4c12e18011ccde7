// The lattice that particles settle into has the stated spacing, Young's modulus and area per particle.
#include "deformable_surface/model/oriented_particles/lattice.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

constexpr double kSpacing = 0.02;

model::MaterialParams sheet() {
  model::MaterialParams material;
  material.young_modulus = 2e5;
  material.thickness = 0.004;
  return material;
}

// The energy per particle, J, of a hexagonal lattice that is stretched evenly: each ordered pair once.
double energyAt(const model::PairPotentials& pair, double spacing) {
  double sum = 0.0;
  for (int i = -9; i <= 9; ++i)
    for (int j = -9; j <= 9; ++j) {
      const double d = spacing * std::sqrt(static_cast<double>(i * i + i * j + j * j));
      if (!(d > 0.0 && d < pair.cutoff)) continue;
      double on, on_slope, value, slope;
      model::switchOff(pair, d, on, on_slope);
      model::evaluateLennardJones(pair, d, 1.0 / d, on, on_slope, value, slope);
      sum += value;
    }
  return sum;
}

TEST(Lattice, HasNoTensionAtItsSpacingAndYoungsModulusAboutIt) {
  const model::Lattice lattice = model::calibrateLattice(kSpacing, sheet(), {});
  EXPECT_EQ(lattice.spacing, kSpacing);
  EXPECT_NEAR(lattice.area_per_particle, 0.5 * std::sqrt(3.0) * kSpacing * kSpacing, 1e-18);
  const double h = 1e-4, area = lattice.area_per_particle;
  const double wider = energyAt(lattice.pair, kSpacing * (1.0 + h)), at = energyAt(lattice.pair, kSpacing),
               narrower = energyAt(lattice.pair, kSpacing * (1.0 - h));
  EXPECT_NEAR(lattice.energy_per_particle, at, 1e-12 * std::abs(at));
  EXPECT_LT(at, 0.0);
  // Springs between points have Poisson's ratio 1/3: an even stretch e costs E h / (1 - 1/3) e^2 per area.
  const double stiffness = sheet().young_modulus * sheet().thickness;
  EXPECT_NEAR((wider - 2.0 * at + narrower) / (h * h * area), 3.0 * stiffness, 1e-3 * stiffness);
  EXPECT_NEAR((wider - narrower) / (2.0 * h * area), 0.0, 1e-4 * stiffness);
}

TEST(Lattice, IsARowForACurve) {
  model::OrientedParticlesParams params;
  params.mode = model::ParticleMode::kPlane;
  EXPECT_DOUBLE_EQ(model::calibrateLattice(kSpacing, sheet(), params).area_per_particle, kSpacing * kSpacing);
}

TEST(Lattice, WeakensByTheWeightOfItsTermAndBendsByTheRigidity) {
  model::OrientedParticlesParams params;
  const model::Lattice whole = model::calibrateLattice(kSpacing, sheet(), params);
  params.lennard_jones = 0.5;
  EXPECT_NEAR(model::calibrateLattice(kSpacing, sheet(), params).pair.depth, 0.5 * whole.pair.depth, 1e-12 * whole.pair.depth);
  model::MaterialParams stiff = sheet();
  stiff.bending_rigidity = 10.0 * sheet().bendingRigidity();
  EXPECT_GT(model::calibrateLattice(kSpacing, stiff, {}).pair.co_planarity, 5.0 * whole.pair.co_planarity);
}

TEST(Lattice, RefusesASurfaceThatWouldCollapseOrHasNoSpacing) {
  EXPECT_THROW(model::calibrateLattice(0.0, sheet(), {}), InputError);
  model::OrientedParticlesParams params;
  params.exponents = Vec2(2.0, 1.0);
  params.cutoff = 10.0;
  EXPECT_THROW(model::calibrateLattice(kSpacing, sheet(), params), InputError);
  params = {};
  params.tear_strain = 5.0;
  EXPECT_THROW(model::calibrateLattice(kSpacing, sheet(), params), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
