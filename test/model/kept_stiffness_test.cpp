// The bound of the stiffness of kept bonds: below the exact stable step on drawn states, and no energy made with it.
#include "deformable_surface/solve/integrator.h"
#include "kept_patches.h"
#include "particle_stiffness.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

struct Drawn {
  OrientedParticles model;
  State state;
  bool is_gentle;  // neither crumpled nor far from its rest shape
};

/// Thickness, Poisson's ratio, bend, then one to three of: stretched by up to 1.5 along one or both axes, jittered, crumpled,
/// torn, heated, with particles pressed onto others.
Drawn draw(unsigned seed) {
  std::mt19937 generator(seed);
  const auto from = [&](double low, double high) { return low + (high - low) * 0.5 * (1.0 + uniform(generator)); };
  MaterialParams m;
  m.thickness = kSpacing * std::exp(from(std::log(0.005), std::log(2.0)));
  m.young_modulus = std::exp(from(std::log(1e3), std::log(1e8)));
  m.poisson_ratio = from(0.0, 0.49);
  const State rest = unevenPatch(seed % 3 == 0 ? from(0.0, 4.0) : 0.0);
  Drawn drawn{makeKept(rest, m), rest, true};
  State& s = drawn.state;
  if (seed % 2 == 0) {
    const double along = from(1.0, 1.5), across = seed % 4 == 0 ? along : 1.0;
    for (Vec3& x : s.positions) x = Vec3(along * x.x(), across * x.y(), x.z());
  }
  if (seed % 5 == 1) s = shaken(s, 0.1, seed);
  if (seed % 5 == 2) {
    s = shaken(s, from(0.3, 0.8), seed);
    drawn.is_gentle = false;
  }
  if (seed % 7 == 3) {
    for (Index i = 0; i < s.size(); ++i) s.traits[i].temperature = from(0.0, 1.2) * drawn.model.params().melting;
    drawn.is_gentle = false;
  }
  if (seed % 7 == 4) {
    for (Index k = 0; k < 4; ++k) s.positions[k] = s.positions[40 - k] + 0.3 * kSpacing * randomVector(generator);
    drawn.is_gentle = false;
  }
  if (seed % 4 == 1) {
    model::ParticleCuts::Pairs severed;
    for (const auto& [i, j] : {std::pair(16, 17), std::pair(9, 17), std::pair(17, 24), std::pair(2, 9)})
      severed.emplace_back(i, j);
    drawn.model.setCuts(drawn.model.cuts().sever(severed));
  }
  return drawn;
}

TEST(KeptStiffness, TheStableStepIsBelowTheExactOneOfDrawnStatesAndNotFarBelow) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Drawn drawn = draw(seed);
    const double bound = drawn.model.findStableStep(drawn.state), exact = measureStableStep(drawn.model, drawn.state);
    EXPECT_LT(bound, exact) << seed;
    EXPECT_GT(bound, (drawn.is_gentle ? 0.6 : 0.3) * exact) << seed;
  }
}

// The right half of the patch, cut off, lies on the left one: strangers push in all directions, on particles of unequal masses.
Drawn drawFolded(unsigned seed) {
  std::mt19937 generator(seed);
  const auto from = [&](double low, double high) { return low + (high - low) * 0.5 * (1.0 + uniform(generator)); };
  MaterialParams m;
  m.thickness = kSpacing * std::exp(from(std::log(0.005), std::log(2.0)));
  m.poisson_ratio = from(0.0, 0.49);
  const State rest = unevenPatch();
  OrientedParticlesParams p;
  p.bonds = model::ParticleBonds::kKept;
  std::vector<double> areas(rest.positions.size());
  for (double& area : areas) area = from(0.15, 1.0) * kSpacing * kSpacing;
  Drawn drawn{makeModel(rest.size(), p, m), rest, false};
  drawn.model.keepBonds(rest, trianglesOfPatch(), areas);
  const auto isRight = [](Index i) { return i % 7 >= 4; };
  model::ParticleCuts::Pairs severed;
  for (const WeightedTriangle& t : trianglesOfPatch())
    for (int a = 0; a < 3; ++a) {
      const Index i = t.corner[a], j = t.corner[(a + 1) % 3];
      if (isRight(i) != isRight(j)) severed.emplace_back(std::min(i, j), std::max(i, j));
    }
  std::sort(severed.begin(), severed.end());
  severed.erase(std::unique(severed.begin(), severed.end()), severed.end());
  drawn.model.setCuts(drawn.model.cuts().sever(severed));
  const Vec3 shift = kSpacing * Vec3(from(-5.0, -3.0), from(-1.0, 1.0), from(0.2, 0.9));
  for (Index i = 0; i < rest.size(); ++i)
    if (isRight(i)) drawn.state.positions[i] += shift;
  return drawn;
}

TEST(KeptStiffness, TheStableStepOfASheetThatLiesOnItselfIsBelowTheExactOneAndNotFarBelow) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Drawn drawn = drawFolded(seed);
    const double bound = drawn.model.findStableStep(drawn.state), exact = measureStableStep(drawn.model, drawn.state);
    EXPECT_LT(bound, exact) << seed;
    EXPECT_GT(bound, 0.5 * exact) << seed;
  }
}

// For an oscillator of frequency w the scheme keeps v^2 + (1 - (w dt / 2)^2) (w x)^2. With 0.9 of the stable step its energy
// stays below 1 / (1 - 0.81) times that at first, here for as long as many periods of the fastest. Beyond the stable step it
// would grow without bounds.
TEST(KeptStiffness, NoEnergyIsMadeWithNineTenthsOfIt) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    Drawn drawn = draw(seed);
    State& s = drawn.state;
    const std::vector<const solve::ExternalLoad*> no_loads;
    const std::vector<char> held(s.positions.size(), 0);
    const solve::System system(drawn.model, no_loads, held, 0.0);
    const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, {}, true);
    const auto energyOf = [&] { return drawn.model.elasticEnergy(s) + system.kineticEnergy(s); };
    std::mt19937 generator(seed);
    const double shake = 0.01 * kSpacing / drawn.model.findStableStep(s);
    for (Vec3& v : s.velocities) v = shake * randomVector(generator);
    const double first = energyOf();
    double highest = 0.0;
    for (int k = 0; k < 100; ++k) {
      const double step = 0.9 * drawn.model.findStableStep(s);
      ASSERT_TRUE(verlet->advance(system, 0.0, 4.0 * step, 1.0001 * step, s).finite) << seed;
      highest = std::max(highest, energyOf());
    }
    EXPECT_LT(highest, first / 0.19) << seed;
  }
}

}  // namespace
}  // namespace deformable_surface::test
