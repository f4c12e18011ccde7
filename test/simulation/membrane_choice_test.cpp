// An accuracy target also chooses the membrane stiffness. The effect is part of the estimate, is below the target, and ends where
// it is not known any more.
#include "../../src/simulation/dynamics.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kTarget = 0.02;  // m

// Hangs from one edge. It is so stiff in its plane that its steps follow waves that nobody sees.
SceneParams stiffSheet() {
  SceneParams p = hangingSheet();
  p.material.young_modulus = 1e8;
  p.material.bending_rigidity = 1e-3;
  p.simplification = cloud::SimplificationParams();
  p.accuracy.position_error = kTarget;
  p.accuracy.remember = false;
  p.duration = 0.2;
  return p;
}

cloud::PointCloud sheet() { return sheetCloud(14); }

int countSteps(const SceneParams& p) { return static_cast<int>(std::lround(p.duration / p.integrator.time_step)); }

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

TEST(MembraneChoice, TakesASofterMembraneWhoseErrorStaysBelowTheTarget) {
  SceneParams p = stiffSheet();
  Simulation s(p, sheet());
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  ASSERT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_LT(choice.membrane_share, 1.0);
  EXPECT_EQ(s.membraneShare(), choice.membrane_share);
  EXPECT_NE(choice.sentence.find("of the stated membrane stiffness"), std::string::npos) << choice.sentence;
  run(s, countSteps(p));
  const simulation::Statistics now = s.statistics();

  p.accuracy = simulation::AccuracyParams();
  p.simplification.target_points = choice.points;
  Simulation stated(p, sheet());
  run(stated, countSteps(p));
  p.simplification.method = cloud::SimplificationMethod::kNone;
  Simulation truth(p, sheet());
  run(truth, countSteps(p));
  EXPECT_GT(now.error_stiffness, 0.0);
  EXPECT_LE(findLargestDistance(s.state().positions, stated.state().positions), now.error_stiffness);
  EXPECT_LE(findLargestDistance(s.surface(false).positions, truth.surface(false).positions), now.error_estimate);
  EXPECT_LE(now.error_estimate, kTarget);
  EXPECT_NEAR(now.error_estimate, now.error_space + now.error_transfer + now.error_time + now.error_stiffness, 1e-12);
  // The number of sub-steps grows with the root of the membrane stiffness, where that decides; rounding up adds one each.
  EXPECT_LE(s.dynamics().lastSubsteps(), std::sqrt(choice.membrane_share) * stated.dynamics().lastSubsteps() + 2.0);
}

TEST(MembraneChoice, LeavesTheMembraneAsItIsWhereTheTargetIsTooSmallForMore) {
  SceneParams p = stiffSheet();
  p.accuracy.position_error = 1e-6;
  Simulation s(p, sheet());
  EXPECT_EQ(s.accuracyChoice().membrane_share, 1.0);
  EXPECT_EQ(s.membraneShare(), 1.0);
}

TEST(MembraneChoice, IsNotMadeForWhatTearsOrMeetsATool) {
  SceneParams tearing = stiffSheet();
  tearing.mass_spring.tear_strain = 0.5;
  EXPECT_EQ(Simulation(tearing, sheet()).membraneShare(), 1.0);
  SceneParams touched = stiffSheet();
  touched.tools.emplace_back();
  touched.tools[0].id = "ball";
  touched.tools[0].shape.radius = 0.1;
  touched.tools[0].path = {{0.0, Vec3(0.0, 0.0, -3.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  EXPECT_EQ(Simulation(touched, sheet()).membraneShare(), 1.0);
}

TEST(MembraneChoice, EndsWithASentenceWhenAToolComesUntilTheNextReset) {
  Simulation s(stiffSheet(), sheet());
  const double chosen = s.membraneShare();
  ASSERT_LT(chosen, 1.0);
  run(s, 3);
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.1;
  ball.path = {{0.0, Vec3(0.0, 0.0, -3.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  s.setTool(ball);
  EXPECT_EQ(s.membraneShare(), 1.0);
  const std::string notice = s.step().notice;
  EXPECT_NE(notice.find("a tool came"), std::string::npos) << notice;
  EXPECT_EQ(s.step().notice, "");
  s.reset();
  EXPECT_EQ(s.membraneShare(), chosen);
}

TEST(MembraneChoice, EndsWithWhatWasNotTried) {
  const Simulation made(stiffSheet(), sheet());
  ASSERT_LT(made.membraneShare(), 1.0);
  simulation::MaterialChangeParams denser;
  denser.density = 500.0;
  simulation::SceneParams stiffer = stiffSheet();
  stiffer.material.young_modulus *= 2.0;
  const std::function<void(Simulation&)> commands[] = {
      [](Simulation& s) {
        s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, -3.0), 0.3, 0.0, 1e300});
      },
      [](Simulation& s) { s.setGravity(Vec3(0.0, 0.0, -5.0)); },
      [&](Simulation& s) { s.setMaterial(nullptr, denser); },
      [&](Simulation& s) { s.setParams(stiffer); },
      [](Simulation& s) { s.setState(model::State(s.state())); },
  };
  for (const auto& command : commands) {
    Simulation s = made.fork();
    run(s, 3);
    command(s);
    EXPECT_EQ(s.membraneShare(), 1.0);
    const std::string notice = s.step().notice;
    EXPECT_NE(notice.find("do not cover what follows"), std::string::npos) << notice;
  }
}

TEST(MembraneChoice, EndsWithTheDurationThatWasTried) {
  for (const bool estimate : {true, false}) {
    SceneParams p = stiffSheet();
    p.accuracy.estimate = estimate;
    Simulation s(p, sheet());
    run(s, countSteps(p));
    EXPECT_LT(s.membraneShare(), 1.0);
    const std::string notice = s.step().notice;
    EXPECT_EQ(s.membraneShare(), 1.0);
    EXPECT_NE(notice.find("the duration of the scene is over"), std::string::npos) << notice;
  }
}

TEST(MembraneChoice, GoesOnBitForBitFromASnapshotOfEither) {
  Simulation s(stiffSheet(), sheet());
  run(s, 5);
  const simulation::Snapshot soft = s.snapshot();
  Simulation fork = s.fork();
  simulation::MaterialChangeParams change;
  change.density = 500.0;
  s.setMaterial(nullptr, change);
  run(s, 2);
  const simulation::Snapshot stated = s.snapshot();
  run(s, 3);
  const std::uint64_t hash = s.stateHash();
  const double error = s.statistics().error_estimate;
  s.restore(soft);
  EXPECT_LT(s.membraneShare(), 1.0);
  run(s, 5);
  run(fork, 5);
  EXPECT_EQ(s.stateHash(), fork.stateHash());
  EXPECT_EQ(s.statistics().error_estimate, fork.statistics().error_estimate);
  s.restore(stated);
  EXPECT_EQ(s.membraneShare(), 1.0);
  run(s, 3);
  EXPECT_EQ(s.stateHash(), hash);
  EXPECT_EQ(s.statistics().error_estimate, error);
}

}  // namespace
}  // namespace deformable_surface::test
