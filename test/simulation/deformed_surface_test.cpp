// The full surface of a state: one row for each input point in the order of the input, computed once per state.
#include "../../src/simulation/deformed_surface.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace deformable_surface::test {
namespace {

using simulation::DeformedSurface;

// A sheet with a hole in its list and a point that occurs twice.
struct Sheet {
  Sheet() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    input.positions[7] = Vec3::Constant(nan);
    input.positions[8] = input.positions[9];
    params.pins.clear();
    rest = simulation::buildRestSurface(params, input);
    surface = std::make_unique<DeformedSurface>(rest, input, params, nullptr);
    surface->reset();
  }
  model::State at(const Mat3& turn, const Vec3& shift) const {
    model::State state{rest.points, Points(rest.points.size(), Vec3::Zero())};
    for (Vec3& p : state.positions) p = turn * p + shift;
    return state;
  }

  cloud::PointCloud input = sheetCloud();
  simulation::SceneParams params = hangingSheet();
  simulation::RestSurface rest;
  std::unique_ptr<DeformedSurface> surface;
};

TEST(DeformedSurface, HasTheInputsRowsAndReproducesARigidMotion) {
  Sheet s;
  const Mat3 turn = someRotation();
  const Vec3 shift(0.4, -0.1, 2.0);
  const simulation::Surface& made = s.surface->make(s.at(turn, shift), true);
  ASSERT_EQ(made.num_input, s.input.size());
  ASSERT_EQ(made.positions.size(), s.input.positions.size());
  EXPECT_TRUE(made.source.empty());
  for (std::size_t i = 0; i < made.positions.size(); ++i) {
    if (i == 7) {
      EXPECT_TRUE(made.positions[i].array().isNaN().all());
      EXPECT_TRUE(std::isnan(made.displacement[i]));
      continue;
    }
    const Vec3 expected = turn * s.input.positions[i] + shift;
    EXPECT_LT((made.positions[i] - expected).norm(), 1e-5) << i;
    EXPECT_NEAR(made.displacement[i], (expected - s.input.positions[i]).norm(), 1e-5) << i;
    EXPECT_NEAR(std::abs(made.normals[i].cast<double>().dot(turn.col(2))), 1.0, 1e-5) << i;
  }
  EXPECT_EQ(made.positions[8], made.positions[9]) << "points that coincide move together";
}

TEST(DeformedSurface, IsMadeOnceAStateAndAgainAfterItWasInvalidated) {
  Sheet s;
  const std::uint64_t before = s.surface->revision();
  EXPECT_FALSE(s.surface->isMade());
  s.surface->make(s.at(Mat3::Identity(), Vec3::Zero()), false);
  EXPECT_TRUE(s.surface->isMade());
  EXPECT_FALSE(s.surface->hasNormals());
  // A state that changed without notice is not evaluated.
  EXPECT_LT(s.surface->make(s.at(Mat3::Identity(), Vec3::UnitX()), false).displacement[0], 1e-6);
  s.surface->invalidate();
  EXPECT_NE(s.surface->revision(), before);
  EXPECT_NEAR(s.surface->make(s.at(Mat3::Identity(), Vec3::UnitX()), false).displacement[0], 1.0, 1e-5);
}

TEST(DeformedSurface, KeepsWhatNothingMovedAndWhatTheSceneDoesNotWant) {
  Sheet s;
  const model::State still = s.at(Mat3::Identity(), Vec3::UnitX());
  s.surface->make(still, true);
  s.surface->invalidate();
  s.surface->make(still, true);
  EXPECT_TRUE(s.surface->hasRested());
  s.params.output.normals = false;
  s.surface->invalidate();
  s.surface->make(still, true);
  EXPECT_FALSE(s.surface->hasNormals());
}

}  // namespace
}  // namespace deformable_surface::test
