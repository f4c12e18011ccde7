// Oriented particles over time, and in states of all kinds.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/solve/integrator.h"
#include "deformable_surface/solve/time_march.h"
#include "particle_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace deformable_surface::test {
namespace {

using solve::IntegratorParams;
using solve::IntegratorType;

struct World {
  explicit World(OrientedParticles& model, double damping = 0.0)
      : held(model.masses().size(), 0), system(model, loads, held, damping) {}
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held;
  solve::System system;
};

void relax(OrientedParticles& model, State& state) {
  IntegratorParams params;
  params.tolerance = 1e-9;
  World world(model);
  const auto fire = solve::makeIntegrator(IntegratorType::kStatic, params, true);
  const solve::SolveReport report = fire->advance(world.system, 0.0, 1.0, model.findStableStep(state), state);
  EXPECT_TRUE(report.converged) << report.residual;
}

TEST(OrientedParticlesStates, APatchThatWasSqueezedAndShakenFindsItsSpacing) {
  State s = hexagonalPatch(6, 7, 0.97 * kSpacing);
  OrientedParticles particles = makeModel(s.size(), {});
  s.positions = perturb(s.positions, 0.03 * kSpacing);
  relax(particles, s);
  // All first neighbours alone: nothing pulls an edge together.
  EXPECT_LT(particles.maxStretch(s), 1e-6);
  particles.refreshDisplay(s);
  EXPECT_EQ(particles.stretchLinks().size(), 6 * 6 + 5 * 13);
}

TEST(OrientedParticlesStates, WithoutDampingEnergyStaysAndMomentaAreKept) {
  State s = hexagonalPatch(4, 4);
  OrientedParticles particles = makeModel(s.size(), allTerms());
  const double at_rest = particles.elasticEnergy(s), most = 0.02 / particles.findStableStep(s);
  std::mt19937 generator(5);
  for (Index i = 0; i < s.size(); i += 2) {
    const Vec3 speed = most * kSpacing * randomVector(generator);
    s.velocities[i] = speed;
    s.velocities[i + 1] = -speed;  // so that the patch stays near the origin, the reference of angular momentum
    s.spins[i] = most * randomVector(generator);
  }
  World world(particles);
  const auto energyOf = [&] { return particles.elasticEnergy(s) + world.system.kineticEnergy(s); };
  const auto momenta = [&](Vec3& linear, Vec3& angular) {
    linear.setZero();
    angular.setZero();
    for (Index i = 0; i < s.size(); ++i) {
      const Vec3 momentum = particles.masses()[i] * s.velocities[i];
      linear += momentum;
      angular += s.positions[i].cross(momentum) + particles.inertias()[i] * s.spins[i];
    }
  };
  Vec3 linear, angular;
  momenta(linear, angular);
  const double step = 0.5 * particles.findStableStep(s), first = energyOf(), excess = first - at_rest;
  const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {}, true);
  double lowest = first, highest = first;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(verlet->advance(world.system, 0.0, 100.0 * 0.5 * step, step, s).finite);
    const double now = energyOf();
    lowest = std::min(lowest, now);
    highest = std::max(highest, now);
  }
  // The error of the second-order method stays that of the first oscillations. It is bounded, whatever their number.
  EXPECT_LT(highest - lowest, 0.01 * excess);
  EXPECT_LT(largest(s.positions), 10.0 * kSpacing);  // it held together
  Vec3 linear_after, angular_after;
  momenta(linear_after, angular_after);
  // Rounding of a hundred thousand sub-steps.
  const double size = particles.masses()[0] * most * kSpacing;
  EXPECT_LT((linear_after - linear).norm(), 1e-11 * size);
  EXPECT_LT((angular_after - angular).norm(), 1e-11 * size * kSpacing);
}

/// Two particles that are kept apart, `line` from each other.
State makePair(const Vec3& line) {
  State s = emptyState(2);
  s.positions[1] = line;
  for (Index i = 0; i < 2; ++i) s.traits[i].ancestor = i;
  return s;
}
OrientedParticles makePairModel() {
  Lists apart;
  apart.items = {1, 0};
  apart.offsets = {0, 1, 2};
  return OrientedParticles(Points(2, Vec3::Zero()), Points(2, Vec3::UnitZ()), kSpacing, thickSheet(), allTerms(), apart);
}

TEST(OrientedParticlesStates, PairsThatAreKeptApartRepelBelowHalfASpacing) {
  std::mt19937 generator(12);
  OrientedParticles particles = makePairModel();
  for (const double share : {0.02, 0.2, 0.4, 0.499, 0.501, 0.9}) {
    const State s = makePair(share * kSpacing * randomVector(generator).normalized());
    Points forces, torques;
    evaluate(particles, s, forces, torques);
    EXPECT_EQ(forces[0], -forces[1]);
    EXPECT_EQ(torques[0], Vec3::Zero());
    EXPECT_LT(forces[1].cross(s.positions[1]).norm(), 1e-15 * kSpacing * std::max(1.0, forces[1].norm()));
    EXPECT_EQ(forces[1].dot(s.positions[1]) > 0.0, share < 0.5) << share;
    const double h = 1e-6 * kSpacing;
    for (int a = 0; a < 3; ++a) {
      State more = s, less = s;
      more.positions[1][a] += h;
      less.positions[1][a] -= h;
      const double slope = (particles.elasticEnergy(more) - particles.elasticEnergy(less)) / (2.0 * h);
      const double largest_force = 10.0 * particles.energyScale() / kSpacing;
      EXPECT_NEAR(forces[1][a], -slope, 1e-7 * largest_force) << share;
    }
  }
  // In one place they part along the surface.
  Points forces, torques;
  evaluate(particles, makePair(Vec3::Zero()), forces, torques);
  EXPECT_GT(forces[0].norm(), 0.0);
  EXPECT_EQ(forces[0], -forces[1]);
  EXPECT_EQ(forces[0].z(), 0.0);
}

TEST(OrientedParticlesStates, LayersOfAThinBodyRepelOnlyBelowTheirDistanceAtRest) {
  Points forces, torques;
  const auto pushAt = [&](const OrientedParticles& particles, const Vec3& line) {
    evaluate(particles, makePair(line), forces, torques);
    return forces[1].norm();
  };
  const Vec3 above(0.0, 0.0, 0.2 * kSpacing), beside(0.2 * kSpacing, 0.0, 0.0);
  OrientedParticles layers = makePairModel();
  EXPECT_GT(pushAt(layers, above), 0.0);
  layers.keepLayers(makePair(above));
  EXPECT_EQ(pushAt(layers, above), 0.0);
  EXPECT_EQ(pushAt(layers, 1.01 * above), 0.0);
  EXPECT_GT(pushAt(layers, 0.99 * above), 0.0);
  // The stable step and parts of the surface know it, too.
  EXPECT_TRUE(std::isinf(layers.findStableStep(makePair(above))));
  EXPECT_TRUE(std::isfinite(layers.findStableStep(makePair(0.99 * above))));
  const auto arePartners = [](OrientedParticles& particles, const Vec3& line) {
    std::vector<char> marked(2, 0);
    particles.followPartners(makePair(line));
    particles.markPartners({0}, marked);
    return marked[1] != 0;
  };
  OrientedParticles unknown = makePairModel();
  EXPECT_TRUE(arePartners(layers, 2.0 * above));
  EXPECT_FALSE(arePartners(layers, 5.0 * above)) << "they cannot touch before the lists are made again";
  EXPECT_TRUE(arePartners(unknown, 5.0 * above));
  OrientedParticles row = makePairModel();
  row.keepLayers(makePair(beside));
  EXPECT_GT(pushAt(row, 2.0 * beside), 0.0);
}

TEST(OrientedParticlesStates, PairsThatAreKeptApartKeepEnergyAndMomentaWhenTheyMeet) {
  for (const double off : {0.0, 0.01, 0.1, 0.3}) {
    SCOPED_TRACE(off);
    OrientedParticles particles = makePairModel();
    State s = makePair(Vec3(0.6 * kSpacing, off * kSpacing, 0.0));
    // Slow enough to turn back, and fast enough to pass.
    for (const double speed : {0.02, 0.5}) {
      State run = s;
      const double most = speed * kSpacing / particles.findStableStep(makePair(0.1 * kSpacing * Vec3::UnitX()));
      run.velocities = {Vec3(most, 0.0, 0.0), Vec3(-most, 0.0, 0.0)};
      World world(particles);
      const double step = 0.02 * particles.findStableStep(makePair(0.1 * kSpacing * Vec3::UnitX()));
      const auto energyOf = [&] { return particles.elasticEnergy(run) + world.system.kineticEnergy(run); };
      const auto turning = [&] {
        return Vec3(run.positions[0].cross(run.velocities[0]) + run.positions[1].cross(run.velocities[1]));
      };
      const double kinetic = world.system.kineticEnergy(run), before = energyOf();
      const Vec3 angular = turning();
      const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {}, true);
      double least = 1.0;
      for (int k = 0; k < 10000 && least > 0.0; ++k) {
        ASSERT_TRUE(verlet->advance(world.system, 0.0, step, step, run).finite);
        const double d = (run.positions[1] - run.positions[0]).norm() / kSpacing;
        least = std::min(least, d);
        if (d > 0.7) break;
      }
      EXPECT_LT(least, 0.5);
      EXPECT_NEAR(energyOf(), before, 0.02 * kinetic);
      EXPECT_LT((run.velocities[0] + run.velocities[1]).norm(), 1e-12 * most);
      EXPECT_LT((turning() - angular).norm(), 1e-11 * most * kSpacing);
    }
  }
}

TEST(OrientedParticlesStates, RotationIsDampedOnItsOwnOrAsMotionIs) {
  for (const double rotational : {-1.0, 0.0, 7.0}) {  // below zero: auto
    OrientedParticlesParams params = allTerms();
    if (!(rotational < 0.0)) params.rotational_damping = rotational;
    OrientedParticles particles = makeModel(1, params);
    State s = emptyState(1);
    const Vec3 speed(0.1, -0.2, 0.3), spin(0.3, 0.5, -0.2);
    s.velocities[0] = speed;
    s.spins[0] = spin;
    World world(particles, 2.0);
    solve::makeIntegrator(IntegratorType::kVerlet, {}, true)->advance(world.system, 0.0, 0.5, 0.01, s);
    EXPECT_LT((s.velocities[0] - std::exp(-1.0) * speed).norm(), 1e-14);
    EXPECT_LT((s.spins[0] - std::exp(-0.5 * (rotational < 0.0 ? 2.0 : rotational)) * spin).norm(), 1e-14);
    World free(particles);
    EXPECT_EQ(free.system.dissipates(), rotational > 0.0);
  }
}

TEST(OrientedParticlesStates, TimeRunsBackwardsAsWell) {
  State s = hexagonalPatch(4, 5);
  s.positions = perturb(s.positions, 0.02 * kSpacing);
  std::mt19937 generator(8);
  for (Quaternion& q : s.orientations) q = turnBy(0.1 * randomVector(generator), q);
  OrientedParticles particles = makeModel(s.size(), allTerms());
  World world(particles);
  const State start = s;
  const double step = 0.5 * particles.findStableStep(s);
  const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {}, true);
  for (int way = 0; way < 2; ++way) {
    verlet->advance(world.system, 0.0, 100.0 * 0.5 * step, step, s);
    if (way == 0) {
      EXPECT_GT((s.positions[0] - start.positions[0]).norm(), 1e-3 * kSpacing);
    }
    for (Index i = 0; i < s.size(); ++i) {
      s.velocities[i] = -s.velocities[i];
      s.spins[i] = -s.spins[i];
    }
  }
  // Rounding of two hundred sub-steps, which the many modes of vibration multiply.
  for (Index i = 0; i < s.size(); ++i) {
    EXPECT_LT((s.positions[i] - start.positions[i]).norm(), 1e-11 * kSpacing);
    EXPECT_LT(s.orientations[i].angularDistance(start.orientations[i]), 1e-7);  // an arc cosine's rounding
    EXPECT_LT((s.orientations[i].coeffs() - start.orientations[i].coeffs()).norm(), 1e-11);
  }
}

/// A wavy sheet, for the tests of changes that must not affect the bits.
State wavyPatch() {
  State s = hexagonalPatch(40, 40);
  std::mt19937 generator(6);
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] += 0.1 * kSpacing * randomVector(generator);
    s.positions[i].z() += 0.5 * kSpacing * std::sin(2.0 * s.positions[i].x() / kSpacing);
    s.orientations[i] = turnBy(0.3 * randomVector(generator), s.orientations[i]);
    s.traits[i].temperature = 100.0 * (i % 5);
    s.traits[i].is_smooth = i % 7 != 0;
  }
  return s;
}

bool areSame(const Points& a, const Points& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const Vec3& x, const Vec3& y) { return x == y; });
}

TEST(OrientedParticlesStates, TheBitsDoNotDependOnThreadsNorOnWhenListsWereMade) {
  for (ParticleWeighting weighting : {ParticleWeighting::kIsotropic, ParticleWeighting::kAnisotropic}) {
    const State s = wavyPatch();
    Points forces, torques, first_forces, first_torques;
    double energy = 0.0, step = 0.0;
    evaluate(makeModel(s.size(), allTerms(weighting)), s, first_forces, first_torques);
    for (int threads : {1, 2, 3}) {
      setNumThreads(threads);
      const OrientedParticles particles = makeModel(s.size(), allTerms(weighting));
      // Lists made at another state. The points have moved by less than half a skin since.
      State before = s;
      before.positions = perturb(s.positions, 0.05 * kSpacing, threads);
      evaluate(particles, before, forces, torques);
      EXPECT_FALSE(areSame(forces, first_forces));
      evaluate(particles, s, forces, torques);
      EXPECT_TRUE(areSame(forces, first_forces)) << threads;
      EXPECT_TRUE(areSame(torques, first_torques)) << threads;
      if (energy == 0.0) {
        energy = particles.elasticEnergy(s);
        step = particles.findStableStep(s);
      }
      EXPECT_EQ(particles.elasticEnergy(s), energy) << threads;
      EXPECT_EQ(particles.findStableStep(s), step) << threads;
    }
  }
  setNumThreads(0);
}

TEST(OrientedParticlesStates, NoStateGivesForcesThatAreNotFinite) {
  const double far = 1e12;
  for (ParticleWeighting weighting : {ParticleWeighting::kIsotropic, ParticleWeighting::kAnisotropic}) {
    for (int kind = 0; kind < 4; ++kind) {
      State s = randomState(20, 1);
      std::mt19937 generator(kind);
      for (Index i = 0; i < s.size(); ++i) {
        if (kind == 0) s.positions[i].setConstant(0.3);                             // all in one place
        if (kind == 1) s.positions[i] = s.positions[i / 2];                         // each twice
        if (kind == 2) s.positions[i] = 1e-9 * kSpacing * randomVector(generator);  // next to one place
        if (kind == 3) s.positions[i] = (i % 3 ? 1.0 : far) * randomVector(generator);
      }
      const OrientedParticles particles = makeModel(20, allTerms(weighting));
      Points forces, torques;
      evaluate(particles, s, forces, torques);
      EXPECT_TRUE(std::isfinite(largest(forces)) && std::isfinite(largest(torques))) << kind;
      EXPECT_TRUE(std::isfinite(particles.elasticEnergy(s))) << kind;
      EXPECT_GT(particles.findStableStep(s), 0.0) << kind;
    }
  }
}

TEST(OrientedParticlesStates, StepsFromBrokenStatesEndFiniteOrAreRefusedWithTheStateAsItWas) {
  IntegratorParams params;
  params.type = IntegratorType::kVerlet;
  params.time_step = 1e-3;
  for (int kind = 0; kind < 4; ++kind) {
    State s = randomState(20, 1);
    for (Index i = 0; i < s.size(); ++i) {
      if (kind == 0) s.positions[i].setConstant(0.3);
      if (kind == 1) s.positions[i] = s.positions[i / 2] + 1e-3 * kSpacing * Vec3(i % 2, 0.0, 0.0);
      if (kind == 2) s.velocities[i] = 1e6 * Vec3(i % 3 - 1.0, i % 5 - 2.0, 0.0);
      if (kind == 3 && i == 4) s.positions[i].x() = std::numeric_limits<double>::quiet_NaN();
    }
    OrientedParticles particles = makeModel(20, allTerms());
    World world(particles, 1.0);
    solve::TimeMarch march(world.system, particles, params);
    for (int k = 0; k < 5; ++k) {
      const Points before = s.positions;
      const solve::TimeMarch::Outcome outcome = march.step(k * params.time_step, s);
      if (kind == 3) {
        EXPECT_FALSE(outcome.ok);
      }
      for (Index i = 0; i < s.size(); ++i) {
        if (outcome.ok) {
          EXPECT_TRUE(s.positions[i].allFinite() && s.orientations[i].coeffs().allFinite()) << kind;
        } else if (kind != 3) {
          EXPECT_EQ(s.positions[i], before[i]) << kind;
        }
      }
    }
  }
}

TEST(OrientedParticlesStates, WhatIsNotANumberIsNotTakenForOne) {
  for (int kind = 0; kind < 3; ++kind) {
    State s = hexagonalPatch(4, 4);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (kind == 0) s.traits[5].temperature = nan;
    if (kind == 1) s.orientations[5].x() = nan;
    if (kind == 2) s.positions[5].z() = nan;
    const OrientedParticles particles = makeModel(16, {});
    Points forces, torques;
    evaluate(particles, s, forces, torques);
    EXPECT_FALSE(forces[5].allFinite()) << kind;
    EXPECT_FALSE(std::isfinite(particles.elasticEnergy(s))) << kind;
  }
}

TEST(OrientedParticlesStates, AHeapThatListsCannotHoldIsRefused) {
  const Index n = model::NeighborList::kMostNeighbors + 2;
  const OrientedParticles particles = makeModel(n, {});
  const State s = emptyState(n);
  Points forces, torques;
  evaluate(particles, s, forces, torques);
  EXPECT_TRUE(std::isnan(forces[0].x()));
  EXPECT_TRUE(std::isnan(particles.elasticEnergy(s)));
}

TEST(OrientedParticlesStates, ParticlesMayComeAndGo) {
  OrientedParticles particles = makeModel(30, {});
  Points forces, torques;
  for (Index rows : {5, 7, 3}) {
    const State s = hexagonalPatch(rows, 6);
    particles.adopt(s);
    EXPECT_EQ(static_cast<Index>(particles.masses().size()), s.size());
    EXPECT_EQ(static_cast<Index>(particles.inertias().size()), s.size());
    evaluate(particles, s, forces, torques);
    EXPECT_LT(largest(forces), 1e-9);
    Points fresh, fresh_torques;
    State moved = s;
    moved.positions = perturb(s.positions, 0.1 * kSpacing);
    evaluate(particles, moved, forces, torques);
    evaluate(makeModel(s.size(), {}), moved, fresh, fresh_torques);
    EXPECT_TRUE(areSame(forces, fresh));
  }
}

TEST(OrientedParticlesStates, ItBeginsWithFramesWhoseZAxesAreTheNormals) {
  std::mt19937 generator(3);
  Points normals{Vec3::UnitZ(), -Vec3::UnitZ(), Vec3(1e-9, 0.0, -1.0).normalized()};
  while (normals.size() < 60) normals.push_back(randomVector(generator).normalized());
  OrientedParticles particles(Points(60, Vec3::Zero()), normals, kSpacing, thickSheet(), {});
  State s{Points(60, Vec3::Zero()), Points(60, Vec3::Zero())};
  particles.beginAtRest(s);
  for (Index i = 0; i < 60; ++i) {
    EXPECT_LT((s.orientations[i] * Vec3::UnitZ() - normals[i]).norm(), 1e-8) << i;
    EXPECT_NEAR(s.orientations[i].norm(), 1.0, 1e-15);
    EXPECT_EQ(s.traits[i].id, i);
    EXPECT_EQ(s.spins[i], Vec3::Zero());
  }
  EXPECT_EQ(s.orientations[1] * Vec3::UnitX(), Vec3::UnitX());
}

// A patch of a cylinder about y with normals outwards, whose x axes point in all directions. The smallest signed curvature is
// across the cylinder's axis, the smallest absolute one along it.
State cylinderWithAxes(const OrientedParticlesParams& params) {
  State s = hexagonalPatch(9, 9);
  const OrientedParticles particles = makeModel(s.size(), params);
  State begin = s;
  OrientedParticles(particles).beginAtRest(begin);
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] -= Vec3(4.25, 4.0 * 0.5 * std::sqrt(3.0), 0.0) * kSpacing;
    rollUp(0.2 / kSpacing, 0.0, s.positions[i], s.orientations[i]);
    s.traits[i].turn = begin.traits[i].turn;
  }
  return s;
}

TEST(OrientedParticlesStates, XAxesSettleAlongOrAcrossTheAxisOfACylinderAndNothingElseMoves) {
  for (model::PrincipalDirection principal : {model::PrincipalDirection::kSigned, model::PrincipalDirection::kAbsolute}) {
    OrientedParticlesParams p;
    p.axis_alignment_rate = 1.0;
    p.principal = principal;
    const State begin = cylinderWithAxes(p);
    const OrientedParticles particles = makeModel(begin.size(), p);
    State s = begin;
    Points forces, torques, forces_before, torques_before;
    evaluate(particles, begin, forces_before, torques_before);
    particles.turnAxes(1e5, s);
    evaluate(particles, s, forces, torques);
    EXPECT_TRUE(areSame(forces, forces_before) && areSame(torques, torques_before));
    EXPECT_TRUE(areSame(s.positions, begin.positions));
    double spread = 0.0;
    for (Index i = 0; i < s.size(); ++i) {
      EXPECT_EQ(s.orientations[i].coeffs(), begin.orientations[i].coeffs());
      spread = std::max(spread, std::abs((begin.frame(i) * Vec3::UnitX()).y()) * std::abs((begin.frame(i) * Vec3::UnitX()).x()));
    }
    EXPECT_GT(spread, 0.4);  // some began askew
    for (Index row = 1; row < 8; ++row)
      for (Index column = 1; column < 8; ++column) {
        const double along = std::abs((s.frame(9 * row + column) * Vec3::UnitX()).y());
        // Exactly there by symmetry, up to rounding. Its root counts where it is an arc cosine.
        EXPECT_NEAR(along, principal == model::PrincipalDirection::kAbsolute ? 1.0 : 0.0, 1e-9) << row << " " << column;
      }
  }
}

TEST(OrientedParticlesStates, XAxesTurnAsFarInOneStepAsInMany) {
  OrientedParticlesParams p;
  p.axis_alignment_rate = 60.0;
  State once = cylinderWithAxes(p);
  const State begin = once;
  const OrientedParticles particles = makeModel(once.size(), p);
  State often = once;
  particles.turnAxes(0.1, once);
  for (int k = 0; k < 50; ++k) particles.turnAxes(0.002, often);
  double most = 0.0;
  for (Index i = 0; i < once.size(); ++i) {
    EXPECT_NEAR(std::remainder(once.traits[i].turn - often.traits[i].turn, 2.0 * M_PI), 0.0, 1e-12) << i;
    most = std::max(most, std::abs(std::remainder(once.traits[i].turn - begin.traits[i].turn, 2.0 * M_PI)));
  }
  EXPECT_GT(most, 0.1);  // on their way
  EXPECT_LT(most, 1.5);
}

TEST(OrientedParticlesStates, ARunWithSpinHasTheBitsOfOneWithout) {
  OrientedParticlesParams p;
  p.axis_alignment_rate = 5.0;
  const OrientedParticles with = makeModel(40, p), without = makeModel(40, {});
  State s = randomState(12, 2);
  Points forces, torques, forces_without, torques_without;
  evaluate(with, s, forces, torques);
  evaluate(without, s, forces_without, torques_without);
  EXPECT_TRUE(areSame(forces, forces_without) && areSame(torques, torques_without));
  EXPECT_EQ(with.findStableStep(s), without.findStableStep(s));
}

}  // namespace
}  // namespace deformable_surface::test
