// The comparison of [Su 2007, Fig. 1]: a wavy sheet under a load on its middle crest deforms as it should when its simulation
// points are spread uniformly, and wrongly when they crowd where the curvature is and leave the flanks bare.
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr double kLength = 1.0, kWidth = 0.16, kAmplitude = 0.05, kWavelength = 1.0 / 3.0;
constexpr Index kKept = 200;

SceneParams makeScene() {
  SceneParams params;
  params.cloud.shape = CloudParams::Shape::kSine;
  params.cloud.points = 1600;
  params.cloud.size = Vec2(kLength, kWidth);
  params.cloud.amplitude = kAmplitude;
  params.cloud.wavelength = kWavelength;
  params.material.young_modulus = 1e6;
  params.material.thickness = 0.01;
  params.material.bending_poisson_ratio = 0.0;  // the bending across the strip, which is seven points wide, is not compared
  params.gravity.setZero();
  params.integrator.type = solve::IntegratorType::kStatic;
  for (const double end : {-0.5, 0.5}) {
    PinParams pin;
    pin.region.kind = geometry::Region::Kind::kBox;
    pin.region.min = Vec3(end * kLength - 1e-3, -kWidth, -1.0);
    pin.region.max = Vec3(end * kLength + 1e-3, kWidth, 1.0);
    params.pins.push_back(pin);
  }
  ForceParams load;
  load.id = "load";
  load.point = Vec3(0.0, 0.0, kAmplitude);
  load.force = Vec3(0.0, 0.0, -0.01);
  load.radius = 0.6 * kWidth;
  params.forces.push_back(load);
  return params;
}

/// How far the middle of the crest sinks. is_whole: all rows are connected. Rows that are far apart form parts of their own,
/// which a notice reports.
double measureSinking(const SceneParams& params, const cloud::PointCloud& cloud, bool is_whole) {
  Simulation simulation(params, cloud);
  const StepOutcome outcome = simulation.step();
  EXPECT_TRUE(outcome.ok) << outcome.problem;
  EXPECT_EQ(outcome.notice.empty(), is_whole) << outcome.notice;
  const Points& now = simulation.surface(false).positions;
  Index crest = 0;
  for (Index i = 0; i < cloud.size(); ++i)
    if ((cloud.positions[i] - params.forces[0].point).squaredNorm() <
        (cloud.positions[crest] - params.forces[0].point).squaredNorm())
      crest = i;
  return cloud.positions[crest].z() - now[crest].z();
}

/// Rows across the wave, dense where it is curved, about as many points as the uniform simplification keeps.
cloud::PointCloud makeAdaptiveCloud() {
  const Index across = 7;
  const Index rows = kKept / across;
  const double k = 2.0 * M_PI / kWavelength;
  // Eleven times as many rows on the crests as on the flanks.
  const auto density = [&](double x) { return 0.1 + std::pow(std::cos(k * x), 2); };
  // The place of each row by the integral of the density.
  constexpr int kFine = 100000;
  std::vector<double> sum{0.0};
  for (int i = 0; i < kFine; ++i) sum.push_back(sum.back() + density(kLength * ((i + 0.5) / kFine - 0.5)));
  cloud::PointCloud cloud;
  for (Index r = 0; r < rows; ++r) {
    const double wanted = sum.back() * r / (rows - 1);
    const double x =
        kLength * (static_cast<double>(std::lower_bound(sum.begin(), sum.end(), wanted) - sum.begin()) / kFine - 0.5);
    for (Index c = 0; c < across; ++c)
      cloud.positions.emplace_back(x, kWidth * (static_cast<double>(c) / (across - 1) - 0.5), kAmplitude * std::cos(k * x));
  }
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

TEST(SineSheet, UniformSimplificationDeformsLikeTheFullSheetAndAnAdaptiveOneDoesNot) {
  SceneParams params = makeScene();
  const cloud::PointCloud cloud = io::makeShape(params.cloud);
  params.simplification.method = cloud::SimplificationMethod::kNone;
  const double full = measureSinking(params, cloud, true);
  const double adaptive = measureSinking(params, makeAdaptiveCloud(), false);
  params.simplification.method = cloud::SimplificationMethod::kDelaunay;
  params.simplification.target_points = kKept;
  const double uniform = measureSinking(params, cloud, true);

  // An eighth of the points have two and a half times the spacing, hence six or seven times the second-order error. That error is
  // 1.6 % for the full sheet: with four times its points it sinks 1.2 % more.
  EXPECT_NEAR(uniform / full, 1.0, 0.09);
  // Sparse flanks neither bend nor resist as they should: this is another sheet, not a loss of accuracy.
  EXPECT_GT(std::abs(adaptive / full - 1.0), 0.3);
}

}  // namespace
}  // namespace deformable_surface::simulation
