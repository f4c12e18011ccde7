// A trial of a scene is the later run: the same estimate, bit for bit, with few and with all points.
#include "../../src/simulation/accuracy_probe.h"

#include "../../src/simulation/error_estimator.h"
#include "../support/random_scene.h"
#include "sagging_strip.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::RestSurface;
using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

// The largest error expected by a trial with so many points.
double tryOut(const SceneParams& scene, const cloud::PointCloud& cloud, Index points) {
  simulation::AccuracyChoice::Candidate tried;
  tried.points = points;
  tried.integrator = scene.integrator.type;
  double error = 0.0;
  simulation::buildRestSurface(scene, cloud, simulation::kCoarsestPoints, [&](const RestSurface& full) {
    error = simulation::probeError(scene, full, tried, std::numeric_limits<double>::max()).candidate.error;
    return points;
  });
  return error;
}

// The same for a run.
double runWith(SceneParams scene, const cloud::PointCloud& cloud, Index points) {
  scene.simplification = cloud::SimplificationParams();
  if (points < cloud.size()) {
    scene.simplification.target_points = points;
  } else {
    scene.simplification.method = cloud::SimplificationMethod::kNone;
  }
  Simulation s(scene, cloud);
  double estimate = 0.0;
  const int steps = static_cast<int>(std::lround(scene.duration / scene.integrator.time_step));
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(s.step().ok);
    estimate = std::max(estimate, s.statistics().error_estimate);
  }
  return estimate;
}

void expectTheSame(const SceneParams& scene, const cloud::PointCloud& cloud, const std::string& name) {
  for (const Index points : {Index{300}, cloud.size()})
    EXPECT_EQ(tryOut(scene, cloud, points), runWith(scene, cloud, points))
        << name << ", " << points << " of " << cloud.size() << " points";
}

TEST(AccuracyProbe, IsTheRunOfASheetThatSwingsDownToItsEquilibrium) {
  for (const double young_modulus : {1e6, 1e8}) {
    SceneParams p = hangingSheet();
    p.material.young_modulus = young_modulus;
    p.integrator.type = IntegratorType::kStatic;
    p.duration = p.integrator.time_step;
    expectTheSame(p, sheetCloud(22), std::to_string(young_modulus));
  }
}

TEST(AccuracyProbe, IsTheRunOfWhatMoves) {
  for (const IntegratorType type : {IntegratorType::kVerlet, IntegratorType::kImplicit}) {
    SceneParams p = saggingStrip(type);
    p.duration = 2.0 * p.integrator.time_step;
    expectTheSame(p, strip(), std::to_string(static_cast<int>(type)));
  }
}

TEST(AccuracyProbe, IsTheRunOfScenesDrawnAtRandom) {
  for (std::uint32_t seed = 200; seed < 206; ++seed) {
    RandomScene scene = makeRandomScene(seed);
    scene.params.simplification = cloud::SimplificationParams();
    scene.params.duration = std::min(scene.params.duration, 2.0 * scene.params.integrator.time_step);
    expectTheSame(scene.params, scene.cloud, std::to_string(seed) + " " + scene.name);
  }
}

TEST(AccuracyProbe, EndsWhenItsWorkIsSpentWithoutKnowingItsError) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  simulation::AccuracyChoice::Candidate tried;
  tried.points = 128;
  tried.integrator = p.integrator.type;
  simulation::Probe whole, cut;
  simulation::buildRestSurface(p, strip(), simulation::kCoarsestPoints, [&](const RestSurface& full) {
    whole = simulation::probeError(p, full, tried, 1.0);
    cut = simulation::probeError(p, full, tried, 1.0, nullptr, {0.25 * whole.spent});
    return Index{128};
  });
  EXPECT_TRUE(whole.is_whole);
  EXPECT_FALSE(whole.failed || whole.is_cut);
  EXPECT_TRUE(cut.failed);
  EXPECT_TRUE(cut.is_cut);
  EXPECT_FALSE(cut.is_whole);
  EXPECT_LT(cut.until, 0.5 * p.duration);
  EXPECT_GT(cut.spent, 0.25 * whole.spent);
  EXPECT_LT(cut.spent, 0.5 * whole.spent);
  EXPECT_GT(cut.candidate.work, 2.0 * cut.spent);  // of the whole duration
  EXPECT_LE(cut.candidate.error, whole.candidate.error);
}

}  // namespace
}  // namespace deformable_surface::test
