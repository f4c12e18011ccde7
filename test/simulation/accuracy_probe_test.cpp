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

// The largest estimate of a trial with so many points.
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

// The same for a run, up to the first estimate that is no bound, where a trial ends.
double runWith(SceneParams scene, const cloud::PointCloud& cloud, Index points) {
  scene.simplification = cloud::SimplificationParams();
  if (points < cloud.size()) {
    scene.simplification.target_points = points;
  } else {
    scene.simplification.method = cloud::SimplificationMethod::kNone;
  }
  Simulation s(scene, cloud);
  double error = 0.0;
  const int steps = static_cast<int>(std::lround(scene.duration / scene.integrator.time_step));
  for (int k = 0; k < steps && std::isfinite(error); ++k)
    error = std::max(error, s.step().ok && s.statistics().error_bounded ? s.statistics().error_estimate
                                                                        : std::numeric_limits<double>::infinity());
  return error;
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

}  // namespace
}  // namespace deformable_surface::test
