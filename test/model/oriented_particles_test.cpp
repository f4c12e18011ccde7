#include "particle_stiffness.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

/// The energy as in the paper: a double sum over ordered pairs of equations 5 to 8, with nothing shared between terms.
double sumOfPublishedEnergies(const OrientedParticles& model, const State& s) {
  const PairPotentials& p = model.lattice().pair;
  double sum = 0.0;
  for (Index i = 0; i < s.size(); ++i)
    for (Index j = 0; j < s.size(); ++j) {
      const Vec3 r = s.positions[j] - s.positions[i];
      const double d = r.norm();
      if (i == j || d >= p.cutoff) continue;
      const Vec3 ni = s.orientations[i] * Vec3::UnitZ(), nj = s.orientations[j] * Vec3::UnitZ();
      const double t = std::max(0.0, (d - p.switch_begin) / (p.cutoff - p.switch_begin));
      const double on = 1.0 - 10.0 * std::pow(t, 3) + 15.0 * std::pow(t, 4) - 6.0 * std::pow(t, 5);
      const Vec3 local = s.orientations[i].conjugate() * r;
      const double psi = p.is_anisotropic
                             ? on * std::exp(-0.5 * p.inverse_width * (local.x() * local.x() + local.y() * local.y()) -
                                             0.5 * p.inverse_height * local.z() * local.z())
                             : std::pow(1.0 - d * d / (p.cutoff * p.cutoff), 3);
      const double n = p.repulsion, m = p.attraction;
      const double phi = p.depth / (n - m) * (m * std::pow(p.distance / d, n) - n * std::pow(p.distance / d, m));
      const double hotter = std::max({0.0, s.traits[i].temperature, s.traits[j].temperature});
      const double strength = std::max(0.0, 1.0 - hotter / model.params().melting);
      const double smooth = s.traits[i].is_smooth && s.traits[j].is_smooth ? 1.0 : 0.0;
      // Heat weakens the binding terms, not the repulsion.
      const double binding = d > p.distance ? phi * on : -p.depth;
      sum += phi * on - (1.0 - strength) * binding;
      sum += strength * smooth * psi *
             (p.co_planarity * std::pow(ni.dot(r), 2) + p.co_normality * (ni - nj).squaredNorm() +
              p.co_circularity * std::pow((ni + nj).dot(r), 2));
    }
  return sum;
}

/// Central differences of fourth order of the energy as the model sums it, along every coordinate.
void checkForcesAndTorques(const OrientedParticles& model, const State& state, bool in_plane = false) {
  Points forces, torques;
  evaluate(model, state, forces, torques);
  const double lattice = state.size() * model.lattice().energy_per_particle;
  const double published = sumOfPublishedEnergies(model, state);
  EXPECT_NEAR(model.elasticEnergy(state) + lattice, published, 1e-12 * (std::abs(published) + std::abs(lattice)));
  const double force_scale = largest(forces), torque_scale = std::max(largest(torques), 1e-300);
  const double h = 1e-3;
  for (Index i = 0; i < state.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const auto slope = [&](const auto& move) {
        const auto energyAt = [&](double amount) {
          State moved = state;
          move(moved, amount);
          return model.elasticEnergy(moved);
        };
        return (8.0 * (energyAt(h) - energyAt(-h)) - (energyAt(2 * h) - energyAt(-2 * h))) / (12.0 * h);
      };
      const Vec3 unit = Vec3::Unit(axis);
      if (!in_plane || axis != 1) {
        const double scale = 0.1 * kSpacing;
        const double change = slope([&](State& s, double amount) { s.positions[i] += scale * amount * unit; }) / scale;
        EXPECT_NEAR(forces[i][axis], -change, 1e-7 * force_scale) << "force " << i << " " << axis;
      } else {
        EXPECT_EQ(forces[i].y(), 0.0);
      }
      if (!in_plane || axis == 1) {
        const double change =
            slope([&](State& s, double amount) { s.orientations[i] = turnBy(amount * unit, s.orientations[i]); });
        EXPECT_NEAR(torques[i][axis], -change, 1e-7 * torque_scale) << "torque " << i << " " << axis;
      } else {
        EXPECT_EQ(torques[i][axis], 0.0);
      }
    }
}

class OrientedParticlesWeightings : public testing::TestWithParam<ParticleWeighting> {};

TEST_P(OrientedParticlesWeightings, ForcesAndTorquesAreMinusTheGradientOfThePublishedEnergies) {
  for (unsigned seed = 1; seed <= 4; ++seed) checkForcesAndTorques(makeModel(12, allTerms(GetParam())), randomState(12, seed));
}

TEST_P(OrientedParticlesWeightings, EachTermAloneIsMinusAGradient) {
  for (int terms = 0; terms < 8; ++terms) {
    OrientedParticlesParams p = allTerms(GetParam());
    p.co_planarity = terms & 1 ? 1.0 : 0.0;
    p.co_normality = terms & 2 ? 1.0 : 0.0;
    p.co_circularity = terms & 4 ? 1.0 : 0.0;
    checkForcesAndTorques(makeModel(10, p), randomState(10, 20 + terms));
  }
}

TEST_P(OrientedParticlesWeightings, HeatWeakensBondsAndUnorientedParticlesOnlyAttractAndRepel) {
  State s = randomState(12, 5);
  std::mt19937 generator(9);
  for (Index i = 0; i < s.size(); ++i) {
    s.traits[i].temperature = 600.0 * (1.0 + uniform(generator)) - 100.0;  // some below ambient, some beyond melting
    s.traits[i].is_smooth = i % 4 != 0;
  }
  const OrientedParticles particles = makeModel(12, allTerms(GetParam()));
  checkForcesAndTorques(particles, s);
  Points forces, torques;
  evaluate(particles, s, forces, torques);
  for (Index i = 0; i < s.size(); i += 4) EXPECT_EQ(torques[i].norm(), 0.0);
}

TEST_P(OrientedParticlesWeightings, InThePlaneParticlesStayInThePlane) {
  OrientedParticlesParams p = allTerms(GetParam());
  p.mode = ParticleMode::kPlane;
  for (unsigned seed = 1; seed <= 3; ++seed) checkForcesAndTorques(makeModel(9, p), randomState(9, seed, true), true);
}

TEST_P(OrientedParticlesWeightings, MomentumIsKept) {
  const State s = randomState(14, 3);
  Points forces, torques;
  evaluate(makeModel(14, allTerms(GetParam())), s, forces, torques);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  double sizes = 0.0, moments = 0.0;
  for (Index i = 0; i < s.size(); ++i) {
    sum += forces[i];
    moment += torques[i] + s.positions[i].cross(forces[i]);
    sizes += forces[i].norm();
    moments += torques[i].norm() + s.positions[i].norm() * forces[i].norm();
  }
  ASSERT_GT(sizes, 0.0);
  EXPECT_LT(sum.norm(), 1e-15 * 14 * sizes);
  EXPECT_LT(moment.norm(), 1e-15 * 14 * moments);
}

TEST_P(OrientedParticlesWeightings, TheStableStepIsBelowThatOfTheLargestFrequencyAndNotFarBelow) {
  for (double thickness : {0.001, 0.04}) {
    MaterialParams material;
    material.thickness = thickness;
    OrientedParticlesParams p = allTerms(GetParam());
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const State s = randomState(12, seed);
      const OrientedParticles particles = makeModel(12, p, material);
      EXPECT_LT(particles.findStableStep(s), measureStableStep(particles, s)) << seed << " " << thickness;
    }
    p.co_circularity = 0.0;
    const State flat = hexagonalPatch(5, 6);
    const OrientedParticles particles = makeModel(flat.size(), p, material);
    const double bound = particles.findStableStep(flat), measured = measureStableStep(particles, flat);
    EXPECT_LT(bound, measured);
    // The largest frequency of a lattice is 1 / sqrt(2) of Gershgorin's bound. Particles at an edge have fewer neighbours.
    EXPECT_GT(bound, 0.6 * measured) << thickness;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, OrientedParticlesWeightings,
                         testing::Values(ParticleWeighting::kIsotropic, ParticleWeighting::kAnisotropic), [](const auto& info) {
                           return info.param == ParticleWeighting::kIsotropic ? "Isotropic" : "Anisotropic";
                         });

// Severed pairs push and do not pull: forces and energy belong together, and the stable step knows them.
TEST(OrientedParticles, EdgesOfACutRepelOnly) {
  State state = hexagonalPatch(8, 8, 0.9 * kSpacing);
  OrientedParticles whole = makeModel(state.size(), allTerms()), cut = whole;
  std::vector<Index> all;
  for (Index i = 0; i < state.size(); ++i) all.push_back(i);
  const double middle = state.positions[state.size() / 2 + 4].x() + 0.3 * kSpacing;
  const auto isLeft = [&](Index i) { return state.positions[i].x() < middle; };
  cut.setCuts(model::ParticleCuts().cut(state.positions, state.traits, all, cut.cutLengths(),
                                        [&](Index i, Index j) { return isLeft(i) != isLeft(j); }));
  ASSERT_FALSE(cut.cuts().isEmpty());
  const auto pushOf = [&](const OrientedParticles& model, const State& s) {
    Points forces(s.positions.size(), Vec3::Zero());
    model.addForces(s, forces);
    Vec3 sum = Vec3::Zero();
    for (Index i = 0; i < s.size(); ++i)
      if (isLeft(i)) sum += forces[i];
    return sum;
  };
  EXPECT_LT(pushOf(cut, state).x(), 0.0);
  const double step = 1e-6 * kSpacing;
  Points forces(state.positions.size(), Vec3::Zero());
  cut.addForces(state, forces);
  for (Index i = 0; i < state.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      State there = state, here = state;
      there.positions[i][a] += step;
      here.positions[i][a] -= step;
      const double slope = (cut.elasticEnergy(there) - cut.elasticEnergy(here)) / (2.0 * step);
      EXPECT_NEAR(forces[i][a], -slope, 1e-5 * std::abs(pushOf(cut, state).x()));
    }
  EXPECT_GE(cut.findStableStep(state), whole.findStableStep(state));
  // Stretched, a whole sheet pulls together, and the halves of a cut one do not know of each other.
  state = hexagonalPatch(8, 8, 1.1 * kSpacing);
  const double apart = state.positions[state.size() / 2 + 4].x() + 0.3 * kSpacing;
  Vec3 across_whole = Vec3::Zero(), across_cut = Vec3::Zero();
  Points in_whole(state.positions.size(), Vec3::Zero()), in_cut = in_whole;
  whole.addForces(state, in_whole);
  cut.addForces(state, in_cut);
  for (Index i = 0; i < state.size(); ++i) {
    if (!(state.positions[i].x() < apart)) continue;
    across_whole += in_whole[i];
    across_cut += in_cut[i];
  }
  EXPECT_GT(across_whole.x(), 0.0);
  EXPECT_LT(across_cut.norm(), 1e-12 * across_whole.norm());
}

}  // namespace
}  // namespace deformable_surface::test
