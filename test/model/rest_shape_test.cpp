// Rest curvatures of oriented particles: their values, the forces that preserve them, and their flow.
#include "deformable_surface/model/oriented_particles/rest_shape.h"

#include "deformable_surface/base/parallel.h"
#include "particle_states.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

OrientedParticlesParams plastic(double yield) {
  OrientedParticlesParams p = allTerms();
  p.yield_curvature = yield;
  return p;
}

// A patch rolled up to a cylinder about y, with a curvature in radians per spacing.
State rolledPatch(double turn_per_spacing) {
  State s = hexagonalPatch(9, 9);
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] -= Vec3(4.25, 4.0 * 0.5 * std::sqrt(3.0), 0.0) * kSpacing;
    rollUp(turn_per_spacing / kSpacing, 0.0, s.positions[i], s.orientations[i]);
  }
  return s;
}
constexpr Index kMiddle = 4 * 9 + 4;

TEST(RestShape, CurvaturesTurnToTheWorldAndBack) {
  std::mt19937 generator(4);
  for (int k = 0; k < 20; ++k) {
    const Quaternion q = randomTurn(generator);
    const Vec3 curvature = randomVector(generator);
    const Mat3 world = model::turnCurvatureToWorld(q, curvature);
    EXPECT_LT((world * (q * Vec3::UnitZ())).norm(), 1e-15);
    EXPECT_LT((model::turnCurvatureToFrame(q, world) - curvature).norm(), 1e-14);
    const model::PrincipalCurvatures k12 = model::findPrincipalCurvatures(curvature);
    const Vec3 along = q * Vec3(std::cos(k12.angle), std::sin(k12.angle), 0.0);
    EXPECT_LT((world * along - k12.larger * along).norm(), 1e-14);
    EXPECT_NEAR(k12.larger + k12.smaller, curvature[0] + curvature[1], 1e-14);
  }
}

TEST(RestShape, TheFitIsExactOnSpheresAndCylindersAndKnowsWhenItCannotTell) {
  std::mt19937 generator(5);
  const double radius = 0.3;
  for (const bool is_sphere : {true, false}) {
    const auto place = [&](double a, double b) {
      if (is_sphere) return Vec3(Vec3(std::sin(a), std::sin(b), std::cos(a)).normalized() * radius);
      return Vec3(radius * std::sin(a), b, radius * std::cos(a));
    };
    const auto normalAt = [&](const Vec3& p) { return is_sphere ? Vec3(p / radius) : Vec3(Vec3(p.x(), 0.0, p.z()) / radius); };
    const Vec3 p = place(0.0, 0.0);
    model::CurvatureFit fit(Quaternion::Identity()), line(Quaternion::Identity());
    for (int k = 0; k < 6; ++k) {
      const Vec3 other = place(0.4 * uniform(generator), 0.2 * uniform(generator));
      fit.add(1.0 + k, other - p, normalAt(other) - normalAt(p));
      const Vec3 next = place(0.1 * (k + 1), 0.0);
      line.add(1.0, next - p, normalAt(next) - normalAt(p));
    }
    const Vec3 expected = is_sphere ? Vec3(1.0 / radius, 1.0 / radius, 0.0) : Vec3(1.0 / radius, 0.0, 0.0);
    ASSERT_TRUE(fit.solve().has_value());
    EXPECT_LT((*fit.solve() - expected).norm(), 1e-12 / radius);
    EXPECT_FALSE(line.solve().has_value());
  }
}

TEST(RestShape, WhatIsBentBeyondTheYieldKeepsWhatIsBeyond) {
  EXPECT_EQ(model::flowToYield(Vec3(0.5, 0.0, 0.0), Vec3(1.4, 0.3, 0.0), 1.0), Vec3(0.5, 0.0, 0.0));
  EXPECT_LT((model::flowToYield(Vec3::Zero(), Vec3(3.0, 0.0, 0.0), 1.0) - Vec3(2.0, 0.0, 0.0)).norm(), 1e-15);
  // Also backwards, and in directions that are no axes: then by the larger principal curvature.
  EXPECT_LT((model::flowToYield(Vec3(2.0, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0), 1.0) - Vec3(0.0, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((model::flowToYield(Vec3::Zero(), Vec3(0.0, 0.0, 4.0), 1.0) - Vec3(0.0, 0.0, 3.0)).norm(), 1e-15);
}

TEST(RestShape, ForcesAndTorquesAreMinusTheGradientOfTheEnergyWithRestCurvatures) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    State s = randomState(10, seed);
    std::mt19937 generator(seed);
    for (auto& traits : s.traits) traits.rest_curvature = 0.5 / kSpacing * randomVector(generator);
    s.traits[3].is_smooth = false;
    s.traits[5].temperature = 400.0;
    const OrientedParticles particles = makeModel(s.size(), plastic(1.0));
    Points forces, torques;
    evaluate(particles, s, forces, torques);
    const double h = 1e-3, move = 0.1 * kSpacing;
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (Index i = 0; i < s.size(); ++i) {
      sum += forces[i];
      moment += torques[i] + s.positions[i].cross(forces[i]);
      for (int axis = 0; axis < 3; ++axis) {
        const auto energyAt = [&](double amount, bool turns) {
          State moved = s;
          if (turns) {
            moved.orientations[i] = turnBy(amount * Vec3::Unit(axis), s.orientations[i]);
          } else {
            moved.positions[i] += move * amount * Vec3::Unit(axis);
          }
          return particles.elasticEnergy(moved);
        };
        const auto slope = [&](bool turns) {
          const double near = energyAt(h, turns) - energyAt(-h, turns), far = energyAt(2 * h, turns) - energyAt(-2 * h, turns);
          return (8.0 * near - far) / (12.0 * h);
        };
        // As without rest curvatures: the remaining error is that of differences of fourth order.
        EXPECT_NEAR(forces[i][axis], -slope(false) / move, 1e-7 * largest(forces)) << i << " " << axis;
        EXPECT_NEAR(torques[i][axis], -slope(true), 1e-7 * largest(torques)) << i << " " << axis;
      }
    }
    EXPECT_LT(sum.norm(), 1e-14 * s.size() * largest(forces));
    EXPECT_LT(moment.norm(), 1e-14 * s.size() * (largest(torques) + 2.0 * kSpacing * largest(forces)));
  }
}

TEST(RestShape, WithoutRestCurvatureItIsTheFlatModel) {
  const State s = randomState(12, 7);
  Points forces, torques, flat_forces, flat_torques;
  evaluate(makeModel(s.size(), plastic(1.0)), s, forces, torques);
  evaluate(makeModel(s.size(), plastic(0.0)), s, flat_forces, flat_torques);
  for (Index i = 0; i < s.size(); ++i) {
    EXPECT_LT((forces[i] - flat_forces[i]).norm(), 1e-14 * largest(forces));
    EXPECT_LT((torques[i] - flat_torques[i]).norm(), 1e-14 * largest(torques));
  }
  EXPECT_NEAR(makeModel(s.size(), plastic(1.0)).elasticEnergy(s), makeModel(s.size(), plastic(0.0)).elasticEnergy(s), 1e-13);
}

TEST(RestShape, ACylinderIsAtRestWhereItsCurvatureIsTheRestCurvature) {
  const double turn = 0.2;  // rad from neighbour to neighbour
  State s = rolledPatch(turn);
  const OrientedParticles particles = makeModel(s.size(), plastic(1.0));
  const double bent = particles.elasticEnergy(s), edges = particles.elasticEnergy(hexagonalPatch(9, 9));
  for (auto& traits : s.traits) traits.rest_curvature = Vec3(turn / kSpacing, 0.0, 0.0);
  // The remaining force has the square of the angle as its factor, the energy its fourth power, apart from chords being shorter
  // than arcs.
  EXPECT_LT(particles.elasticEnergy(s) - edges, turn * turn * (bent - edges));
}

TEST(RestShape, FlowKeepsWhatIsBeyondTheYieldAndNothingBelow) {
  const double turn = 0.2, yield = 0.05 / kSpacing;
  State s = rolledPatch(turn);
  const OrientedParticles stiff = makeModel(s.size(), plastic(1.001 * turn / kSpacing));
  EXPECT_FALSE(stiff.flow(s));
  EXPECT_EQ(s.traits[kMiddle].rest_curvature, Vec3(Vec3::Zero()));
  const OrientedParticles soft = makeModel(s.size(), plastic(yield));
  EXPECT_TRUE(soft.flow(s));
  for (const auto& traits : s.traits)
    EXPECT_LT((traits.rest_curvature - Vec3(turn / kSpacing - yield, 0.0, 0.0)).norm(), 1e-10 / kSpacing);
  // A quarter of the curvature remains, and a sixteenth of the energy, apart from terms with the square of the angle.
  const double edges = soft.elasticEnergy(hexagonalPatch(9, 9)), bent = stiff.elasticEnergy(rolledPatch(turn)) - edges;
  EXPECT_LT(soft.elasticEnergy(s) - edges, (1.0 / 16.0 + turn * turn) * bent);
  const OrientedParticles off = makeModel(s.size(), plastic(0.0));
  EXPECT_FALSE(off.flow(s));
}

TEST(RestShape, FlowTurnsAndForcesHaveTheSameBitsForAnyNumberOfThreads) {
  OrientedParticlesParams p = plastic(1.0);
  p.axis_alignment_rate = 100.0;
  State start = hexagonalPatch(30, 30);  // several blocks
  std::mt19937 generator(2);
  for (Index i = 0; i < start.size(); ++i) {
    rollUp(1.0, 0.4, start.positions[i], start.orientations[i]);
    start.orientations[i] = turnBy(0.2 * randomVector(generator), start.orientations[i]);
  }
  std::vector<State> states;
  std::vector<Points> forces(3), torques(3);
  for (int threads = 1; threads <= 3; ++threads) {
    setNumThreads(threads);
    const OrientedParticles particles = makeModel(start.size(), p);
    states.push_back(start);
    EXPECT_TRUE(particles.flow(states.back()));
    particles.turnAxes(0.01, states.back());
    evaluate(particles, states.back(), forces[threads - 1], torques[threads - 1]);
  }
  setNumThreads(0);
  for (int k = 1; k < 3; ++k) {
    EXPECT_TRUE(forces[k] == forces[0] && torques[k] == torques[0]);
    for (Index i = 0; i < start.size(); ++i) {
      EXPECT_EQ(states[k].traits[i].rest_curvature, states[0].traits[i].rest_curvature);
      EXPECT_EQ(states[k].traits[i].turn, states[0].traits[i].turn);
    }
  }
}

}  // namespace
}  // namespace deformable_surface::test
