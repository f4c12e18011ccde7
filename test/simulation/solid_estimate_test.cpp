// The error estimate of elastic solids, against theory and against many more points, and that it changes no result.
#include "support/figures.h"

#include "deformable_surface/base/parallel.h"

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kLength = 0.5, kSide = 0.1, kYoung = 1e6, kPoisson = 0.3, kDensity = 1000.0;

// A bar of rubber, clamped at one end, with about this number of points, all simulated.
SceneParams makeBar(Index points, const std::string& more) {
  SceneParams scene = parseScene(R"(
model: elastic_solid
cloud: {shape: bar, size: [0.5, 0.1], height: 0.1, jitter: 0.2}
material: {young_modulus: 1.0e6, poisson_ratio: 0.3, density: 1000.0}
pins: [{box: {min: [-1, -1, -1], max: [1.0e-6, 1, 1]}}]
)" + more);
  scene.cloud.points = points;
  return scene;
}

// Of the free end.
Vec3 findMeanMotion(Simulation& s) {
  Vec3 sum = Vec3::Zero();
  double count = 0.0;
  const Points& now = s.surface(false).positions;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (s.input().positions[i].x() < kLength - 1e-9) continue;
    sum += now[i] - s.input().positions[i];
    count += 1.0;
  }
  return sum / count;
}

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// So little gravity that theory for small deflections holds: along the bar rho g L^2 / 2 E; across it Timoshenko's beam,
// rho g L^4 / (8 E I / A) + rho g L^2 / (2 kappa G) with kappa = 5/6 [timoshenko1951].
TEST(SolidEstimate, CoversTheErrorAgainstTheoryWhereEveryPointIsSimulated) {
  constexpr double kGravity = 0.1, kWeight = kDensity * kGravity, kShear = kYoung / (2.0 * (1.0 + kPoisson));
  const double stretched = kWeight * kLength * kLength / (2.0 * kYoung);
  const double bent = kWeight * std::pow(kLength, 4) * 12.0 / (8.0 * kYoung * kSide * kSide) +
                      kWeight * kLength * kLength / (2.0 * 5.0 / 6.0 * kShear);
  for (const Index points : {500, 1000, 2000}) {
    SceneParams scene = makeBar(points, "integrator: {type: static}");
    scene.gravity = Vec3(kGravity, 0.0, 0.0);
    Simulation pulled = makeSimulation(scene);
    scene.gravity = Vec3(0.0, 0.0, -kGravity);
    Simulation hanging = makeSimulation(scene);
    ASSERT_TRUE(pulled.step().ok && hanging.step().ok);
    const double estimates[2] = {pulled.statistics().error_estimate, hanging.statistics().error_estimate};
    EXPECT_LE(std::abs(findMeanMotion(pulled).x() - stretched), estimates[0]) << points;
    EXPECT_LE(std::abs(-findMeanMotion(hanging).z() - bent), estimates[1]) << points;
    // The estimate is also useful: for a bent bar a few points thick it is below a good part of the motion. For a bar that is
    // pulled it is larger than its motion, because the copy of fewer points is lopsided and bends.
    EXPECT_LT(estimates[1], 0.6 * bent) << points;
  }
}

TEST(SolidEstimate, CoversTheErrorAgainstTheFullCloudAtRestAndInMotion) {
  for (const bool is_static : {true, false}) {
    SceneParams scene = makeBar(4000, is_static ? "integrator: {type: static}" : "");
    scene.accuracy.estimate = false;
    Simulation full = makeSimulation(scene);
    scene.accuracy.estimate = true;
    scene.simplification.target_points = 600;
    Simulation s = makeSimulation(scene);
    for (int k = 0; k < (is_static ? 1 : 20); ++k) {
      ASSERT_TRUE(full.step().ok && s.step().ok);
      const simulation::Statistics now = s.statistics();
      EXPECT_LE(findLargestDistance(s.surface(false).positions, full.surface(false).positions), now.error_estimate) << k;
      EXPECT_DOUBLE_EQ(now.error_estimate, now.error_space + now.error_transfer + now.error_time);
      EXPECT_GT(now.error_transfer, 0.0);
    }
    EXPECT_LT(s.statistics().error_estimate, 0.06);  // the end sinks by a tenth of a metre
  }
}

// Upright, and several times too soft to stand. The direction of its fall is arbitrary.
TEST(SolidEstimate, IsNoBoundWhereAColumnBuckles) {
  SceneParams scene = makeBar(800, "");
  scene.material.young_modulus = 1e4;
  scene.gravity = Vec3(-9.81, 0.0, 0.0);
  Simulation s = makeSimulation(scene);
  bool was_unbounded = false;
  std::string notice;
  for (int k = 0; k < 200 && !was_unbounded; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    was_unbounded = !s.statistics().error_bounded;
    notice = outcome.notice;
  }
  EXPECT_TRUE(was_unbounded);
  EXPECT_NE(notice.find("error_estimate is no bound"), std::string::npos) << notice;
}

TEST(SolidEstimate, ThereIsNoneOfAHandfulOfPoints) {
  SceneParams scene = makeBar(600, "");
  scene.simplification.target_points = 50;
  Simulation s = makeSimulation(scene);
  bool is_said = false;
  for (const std::string& note : s.buildNotes()) is_said = is_said || note.find("no error estimate") != std::string::npos;
  EXPECT_TRUE(is_said);
  EXPECT_TRUE(std::isnan(s.statistics().error_estimate));
}

TEST(SolidEstimate, ChangesNoBitOfTheResultAndIsTheSameForEveryNumberOfThreadsAndFromASnapshot) {
  SceneParams scene = makeBar(1000, "simplification: {target_points: 700}");
  std::uint64_t hash = 0;
  double estimate = 0.0;
  for (const Index threads : {1, 2}) {
    setNumThreads(threads);
    Simulation s = makeSimulation(scene);
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(s.step().ok);
    const simulation::Snapshot snapshot = s.snapshot();
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(s.step().ok);
    if (threads == 1) {
      hash = s.stateHash();
      estimate = s.statistics().error_estimate;
    }
    EXPECT_EQ(s.stateHash(), hash);
    EXPECT_EQ(s.statistics().error_estimate, estimate);
    s.restore(snapshot);
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(s.step().ok);
    EXPECT_EQ(s.statistics().error_estimate, estimate);
  }
  setNumThreads(0);
  scene.accuracy.estimate = false;
  Simulation bare = makeSimulation(scene);
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(bare.step().ok);
  EXPECT_EQ(bare.stateHash(), hash);
}

// With these points the copies happen to be stiffer: they need eight times as many sub-steps as the simulation.
SceneParams makeTwoBars(const std::string& more) {
  return parseScene(R"(
model: elastic_solid
cloud: {shape: two_bars, points: 1500, size: [1.0, 0.1], gap: 0.02, jitter: 0.1}
material: {young_modulus: 3.0e6, poisson_ratio: 0.3, thickness: 0.01, density: 1000.0, damping: 10.0}
pins: [{box: {min: [-1.0, -1.0, 0.005], max: [2.0, 1.0, 1.0]}}]
)" + more);
}

TEST(CostOfEstimate, IsToldOnceWhereTheCopiesTakeMoreWorkThanTheSimulation) {
  Simulation s = makeSimulation(makeTwoBars(""));
  Index told = 0;
  for (int k = 0; k < 12; ++k) told += s.step().notice.find("the error estimate takes 6.") != std::string::npos;
  EXPECT_EQ(told, 1);
  EXPECT_TRUE(std::isfinite(s.statistics().error_estimate));
}

// The copies need implicit steps, where the simulation takes nine sub-steps.
TEST(CostOfEstimate, EndsAnEstimateThatTakesManyTimesTheWorkOfTheSimulation) {
  SceneParams scene = makeTwoBars("integrator: {time_step: 0.002, max_substeps: 20}");
  Simulation s = makeSimulation(scene);
  const auto findEnd = [](Simulation& run) {
    Index ends = 0;
    for (Index k = 1; k <= 30; ++k) {
      const simulation::StepOutcome outcome = run.step();
      EXPECT_TRUE(outcome.ok) << outcome.problem;
      const bool has_ended = outcome.notice.find("its coarser copies are far stiffer than the simulation") != std::string::npos;
      EXPECT_TRUE(!has_ended || ends == 0) << outcome.notice;
      if (has_ended) ends = k;
    }
    return ends;
  };
  s.step();
  EXPECT_TRUE(std::isfinite(s.statistics().error_estimate));
  const simulation::Snapshot snapshot = s.snapshot();
  const Index ends = findEnd(s);
  EXPECT_GT(ends, 1);
  EXPECT_TRUE(std::isinf(s.statistics().error_estimate));
  EXPECT_FALSE(s.statistics().error_bounded);
  const std::uint64_t hash = s.stateHash();
  s.restore(snapshot);
  EXPECT_TRUE(std::isfinite(s.statistics().error_estimate));
  Simulation fork = s.fork();
  EXPECT_EQ(findEnd(fork), ends);
  s.reset();
  EXPECT_EQ(findEnd(s), ends + 1);
  scene.accuracy.estimate = false;
  Simulation bare = makeSimulation(scene);
  for (int k = 0; k < 31; ++k) bare.step();
  EXPECT_EQ(bare.stateHash(), hash);
}

}  // namespace
}  // namespace deformable_surface::test
