// States and loads far from any surface: a step of oriented particles ends with finite values, or is refused with the state
// unchanged.
#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

namespace deformable_surface::test {
namespace {

constexpr double kSpacing = 0.05;

simulation::SceneParams patchScene() {
  simulation::SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.oriented_particles.spacing = kSpacing;
  p.material.damping = 1.0;
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * kSpacing * kSpacing;
  return p;
}

cloud::PointCloud patch() {
  Points points;
  for (Index j = 0; j < 8; ++j)
    for (Index i = 0; i < 8; ++i) points.emplace_back(kSpacing * (i + 0.5 * (j % 2)), kSpacing * std::sqrt(0.75) * j, 0.0);
  return asCloud(points);
}

// Steps that were taken.
int runSoundly(simulation::Simulation& s, int steps) {
  int taken = 0;
  for (int k = 0; k < steps; ++k) {
    const std::uint64_t hash = s.stateHash();
    const simulation::StepOutcome outcome = s.step();
    taken += outcome.ok;
    EXPECT_EQ(outcome.problem.empty(), outcome.ok);
    if (!outcome.ok) {
      EXPECT_EQ(s.stateHash(), hash);
    }
    for (Index i = 0; i < s.state().size(); ++i) {
      EXPECT_TRUE(s.state().positions[i].allFinite() && s.state().velocities[i].allFinite()) << i;
      EXPECT_TRUE(s.state().orientations[i].coeffs().allFinite() && s.state().spins[i].allFinite()) << i;
    }
  }
  return taken;
}

int runFrom(const std::function<void(model::State&)>& change) {
  simulation::Simulation s(patchScene(), patch());
  model::State state = s.state();
  change(state);
  s.setState(state);
  return runSoundly(s, 10);
}

TEST(ParticleStability, CollapsedParticlesEndFiniteOrAreRefused) {
  for (const double size : {0.3, 1e-3, 1e-12, 0.0}) {
    const int taken = runFrom([&](model::State& state) {
      for (Vec3& p : state.positions) p *= size;
    });
    if (size > 0.1) EXPECT_EQ(taken, 10);
  }
}

TEST(ParticleStability, ShuffledParticlesEndFiniteOrAreRefused) {
  // Positions permuted among particles, which is the same surface. Then those of one coordinate only, which is none.
  const int same = runFrom([](model::State& state) {
    for (Index i = 0; i < state.size(); ++i) std::swap(state.positions[i], state.positions[(37 * i + 11) % state.size()]);
  });
  EXPECT_EQ(same, 10);
  runFrom([](model::State& state) {
    for (Index i = 0; i < state.size(); ++i) std::swap(state.positions[i].x(), state.positions[(37 * i + 11) % state.size()].x());
  });
  // Frames.
  const int turned = runFrom([](model::State& state) {
    std::mt19937 generator(3);
    for (Quaternion& q : state.orientations)
      q = Quaternion(uniform(generator), uniform(generator), uniform(generator), uniform(generator)).normalized();
  });
  EXPECT_EQ(turned, 10);
}

TEST(ParticleStability, DuplicatedParticlesEndFiniteOrAreRefused) {
  runFrom([](model::State& state) {
    for (Index i = 0; i < state.size(); ++i) state.positions[i] = state.positions[i / 2 * 2];
  });
  // A cloud whose points coincide but for rounding.
  cloud::PointCloud twice = patch();
  for (Vec3 p : patch().positions) twice.positions.push_back(p + Vec3(1e-12, 0.0, 0.0));
  twice.width = static_cast<std::uint32_t>(twice.positions.size());
  simulation::Simulation s(patchScene(), twice);
  runSoundly(s, 10);
}

TEST(ParticleStability, HugeForcesAndSpeedsEndFiniteOrAreRefused) {
  for (const double size : {1e3, 1e6, 1e12}) {
    simulation::SceneParams p = patchScene();
    p.forces.push_back({"blow", Vec3(0.2, 0.2, 0.0), Vec3(0.3 * size, 0.0, size), 0.06, 0.0, 1e300});
    simulation::Simulation s(p, patch());
    runSoundly(s, 10);
  }
  runFrom([](model::State& state) {
    for (Index i = 0; i < state.size(); ++i) state.velocities[i] = 1e5 * Vec3(i % 3 - 1.0, i % 5 - 2.0, i % 2);
  });
}

TEST(ParticleStability, ThoseThatLoseTheirNeighboursFallFreely) {
  simulation::SceneParams p = patchScene();
  p.material.damping = 0.0;
  simulation::Simulation s(p, patch());
  simulation::ParticleEdit edit;
  edit.action = simulation::ParticleAction::kDelete;
  edit.ids.resize(63);
  std::iota(edit.ids.begin(), edit.ids.end(), 0);
  s.editParticles(edit);
  const double height = s.state().positions[0].z();
  EXPECT_EQ(runSoundly(s, 20), 20);
  EXPECT_NEAR(s.state().positions[0].z() - height, -0.5 * 9.81 * s.time() * s.time(), 1e-9);
}

}  // namespace
}  // namespace deformable_surface::test
