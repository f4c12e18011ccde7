// A surface that passes through itself is pushed apart on demand, without momentum, and by the same bits each time.
#include "../../src/simulation/self_contact_load.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <numeric>

#include "../support/crossings.h"

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using Type = solve::IntegratorType;

constexpr Index kAcross = 12;
constexpr double kSide = 0.2, kSpacing = kSide / (kAcross - 1);

SceneParams makeScene(Type type) {
  SceneParams scene;
  scene.contact.self = scene.contact.untangle = true;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.material.young_modulus = 3e5;
  scene.material.damping = 1.0;
  scene.accuracy.estimate = false;
  scene.integrator.type = type;
  scene.integrator.time_step = 0.01;
  scene.gravity.setZero();
  return scene;
}

// Two sheets; the second is turned and moved.
Points makeSheets(const Mat3& turn, const Vec3& to) {
  Points points;
  for (int sheet = 0; sheet < 2; ++sheet)
    for (Index i = 0; i < kAcross; ++i)
      for (Index j = 0; j < kAcross; ++j) {
        const Vec3 p(kSpacing * i - 0.5 * kSide, kSpacing * j - 0.5 * kSide, 0.0);
        points.push_back(sheet == 0 ? p : Vec3(turn * p + to));
      }
  return points;
}
Mat3 turnBy(double angle) { return Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix(); }

struct Tangle {
  Simulation simulation;
  std::vector<contact::Triangle> triangles;

  std::size_t count() const { return findCrossings(simulation.state().positions, triangles).size(); }
};
// Far apart at rest; the state has them cross at an angle.
Tangle makeTangle(const SceneParams& scene, double angle, const Vec3& to) {
  cloud::PointCloud cloud;
  cloud.positions = makeSheets(turnBy(angle), to + Vec3(0.0, 0.0, 1.0));
  Simulation s(scene, cloud);
  model::State state = s.state();
  state.positions = makeSheets(turnBy(angle), to);
  s.setState(state);
  std::vector<contact::Triangle> triangles = simulation::ContactSkin(cloud.positions, trianglesOf(s.model())).triangles;
  return {std::move(s), std::move(triangles)};
}

bool hasWord(const std::string& notice, const std::string& word) { return notice.find(word) != std::string::npos; }

TEST(UntangledSurfaces, CrossedSheetsArePushedApartAndStaySo) {
  for (const Type type : {Type::kVerlet, Type::kImplicit})
    for (const auto& [angle, aside] : {std::make_pair(0.3, 0.0), {1.2, 0.0}, {1.0, 0.1}}) {
      Tangle tangle = makeTangle(makeScene(type), angle, Vec3(0.003, 0.004 + aside, 0.02));
      Simulation& s = tangle.simulation;
      ASSERT_GT(tangle.count(), 15u);
      std::size_t begun = 0, ended = 0;
      int steps_apart = 0;
      double fastest = 0.0;
      for (int k = 0; k < 150 && steps_apart < 20; ++k) {
        const simulation::StepOutcome outcome = s.step();
        ASSERT_TRUE(outcome.ok) << outcome.problem;
        begun += hasWord(outcome.notice, "they are pushed apart");
        ended += hasWord(outcome.notice, "no triangle that has contact is crossed any longer");
        for (const Vec3& v : s.state().velocities) fastest = std::max(fastest, v.norm());
        const bool is_apart = tangle.count() == 0;
        EXPECT_EQ(is_apart, ended == 1) << k;
        EXPECT_TRUE(is_apart || steps_apart == 0) << k;
        steps_apart += is_apart;
      }
      EXPECT_EQ(steps_apart, 20) << angle << ' ' << tangle.count();
      EXPECT_EQ(begun, 1u);
      EXPECT_EQ(ended, 1u);
      // Half a dozen edges within the time in which undisturbed parts pass one.
      EXPECT_LT(fastest, 6.0 * kSpacing / 0.05);
    }
}

TEST(UntangledSurfaces, WithoutItCrossedSheetsStayCrossed) {
  SceneParams scene = makeScene(Type::kVerlet);
  scene.contact.untangle = false;
  Tangle tangle = makeTangle(scene, 1.2, Vec3(0.003, 0.004, 0.02));
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(tangle.simulation.step().ok);
  EXPECT_GT(tangle.count(), 10u);
}

TEST(UntangledSurfaces, MakesNoMomentum) {
  Tangle tangle = makeTangle(makeScene(Type::kVerlet), 1.2, Vec3(0.003, 0.004, 0.02));
  Simulation& s = tangle.simulation;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(s.step().ok);
  const std::vector<double>& masses = s.model().masses();
  Vec3 momentum = Vec3::Zero(), spin = Vec3::Zero();
  double moved = 0.0, spun = 0.0;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const Vec3 p = masses[i] * s.state().velocities[i], l = s.state().positions[i].cross(p);
    momentum += p;
    spin += l;
    moved += p.norm();
    spun += l.norm();
  }
  EXPECT_GT(moved, 1e-5);
  EXPECT_LT(momentum.norm(), 1e-12 * moved);
  EXPECT_LT(spin.norm(), 0.01 * spun);  // directions stay for a step
}

TEST(UntangledSurfaces, ARunFromASnapshotAForkAndAnyNumberOfThreadsGiveTheSameBits) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    SceneParams scene = makeScene(type);
    std::uint64_t hash = 0;
    for (const Index threads : {1, 2}) {
      scene.threads = threads;
      Tangle tangle = makeTangle(scene, 1.2, Vec3(0.003, 0.004, 0.02));
      Simulation& s = tangle.simulation;
      run(s, 10);
      ASSERT_GT(tangle.count(), 5u);
      const simulation::Snapshot snapshot = s.snapshot();
      Simulation fork = s.fork();
      run(s, 15);
      run(fork, 15);
      if (threads == 1) hash = s.stateHash();
      EXPECT_EQ(s.stateHash(), hash);
      EXPECT_EQ(fork.stateHash(), hash);
      s.restore(snapshot);
      EXPECT_GT(tangle.count(), 5u);
      run(s, 15);
      EXPECT_EQ(s.stateHash(), hash);
    }
  }
}

// Pins hold all points.
TEST(UntangledSurfaces, WhatStaysCrossedIsTold) {
  SceneParams scene = makeScene(Type::kVerlet);
  scene.pins.emplace_back();
  scene.pins[0].region.min = Vec3::Constant(-2.0);
  scene.pins[0].region.max = Vec3::Constant(2.0);
  Tangle tangle = makeTangle(scene, 1.2, Vec3(0.003, 0.004, 0.02));
  const std::size_t crossed = tangle.count();
  ASSERT_GT(crossed, 10u);
  std::vector<int> told;
  for (int k = 0; k < 100; ++k) {
    const simulation::StepOutcome outcome = tangle.simulation.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    if (hasWord(outcome.notice, "are still crossed by others")) told.push_back(k);
  }
  EXPECT_EQ(told.size(), 1u);
  EXPECT_EQ(tangle.count(), crossed);
}

}  // namespace
}  // namespace deformable_surface::test
