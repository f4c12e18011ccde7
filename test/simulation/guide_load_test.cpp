// The load of an iso-surface: its law, its side, its bound, and surfaces that grow onto spheres, ellipsoids and a torus.
#include "deformable_surface/simulation/guide_load.h"
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/simulation/expectations.h"
#include "deformable_surface/simulation/simulation.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

namespace deformable_surface::test {
namespace {

using model::GuideParams;
using model::State;
using Field = std::function<double(const Vec3&)>;

std::shared_ptr<const geometry::Volume> makeGrid(Index samples, double half, const Vec3& center, const Field& field) {
  const double step = 2.0 * half / (samples - 1);
  const Vec3 origin = center - Vec3::Constant(half);
  std::vector<float> values;
  for (Index k = 0; k < samples; ++k)
    for (Index j = 0; j < samples; ++j)
      for (Index i = 0; i < samples; ++i) values.push_back(static_cast<float>(field(origin + step * Vec3(i, j, k))));
  return std::make_shared<const geometry::Volume>(std::array<Index, 3>{samples, samples, samples}, origin,
                                                  Mat3(step * Mat3::Identity()), values);
}

GuideParams makeGuide(std::shared_ptr<const geometry::Volume> grid, double iso_value, model::GuideInside inside) {
  GuideParams guide;
  guide.volume = "given";
  guide.grid = std::move(grid);
  guide.iso_value = iso_value;
  guide.inside = inside;
  guide.pressure = 50.0;
  return guide;
}

TEST(GuideLoad, IsAPressureThatFallsToZeroOnTheIsoSurface) {
  const Surface s = makeSheet(9, 8, 1.0, 0.8);
  const model::MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), model::MaterialParams(),
                            model::MassSpringParams());
  // The inside is below z = 0.3; the sheet faces up.
  const GuideParams guide =
      makeGuide(makeGrid(21, 2.0, Vec3::Zero(), [](const Vec3& p) { return 7.0 * p.z(); }), 2.1, model::GuideInside::kBelow);
  const simulation::GuideLoad load(m, guide);
  Points area;
  const auto forceAt = [&](double height, std::size_t i) {
    State state{s.points, Points(s.points.size(), Vec3::Zero())};
    for (Vec3& p : state.positions) p.z() += height;
    computeAreaVectors(m, state, area);
    Points forces(state.positions.size(), Vec3::Zero());
    load.addForces(0.0, state, forces);
    EXPECT_NEAR(forces[i].head<2>().norm(), 0.0, 1e-9);
    return forces[i].z() / area[i].z();
  };
  for (std::size_t i = 0; i < s.points.size(); i += 11) {
    EXPECT_NEAR(forceAt(0.3, i), 0.0, 1e-4);
    EXPECT_NEAR(forceAt(-1.0, i), 50.0, 1e-9);
    EXPECT_NEAR(forceAt(1.0, i), -50.0, 1e-9);
    const double reach = guide.reach * std::sqrt(2.0 / std::sqrt(3.0) * area[i].norm());
    EXPECT_NEAR(forceAt(0.3 - 0.5 * reach, i), 25.0, 1e-3);
    EXPECT_NEAR(forceAt(0.3 + 0.5 * reach, i), -25.0, 1e-3);
    std::vector<double> stiffness(s.points.size(), 0.0), damping = stiffness;
    load.addRowBounds(0.0, {s.points, Points(s.points.size(), Vec3::Zero())}, stiffness, damping);
    EXPECT_GE(stiffness[i], 50.0 * area[i].norm() / reach);
    EXPECT_EQ(damping[i], 0.0);
  }
  EXPECT_TRUE(simulation::GuideLoad(m, GuideParams()).isEmpty());
}

// A seed of 80 particles on a sphere of 0.12 m about the origin, which is blown up.
simulation::SceneParams makeScene(const GuideParams& guide) {
  simulation::SceneParams p;
  p.model = "oriented_particles";
  p.cloud.shape = simulation::CloudParams::Shape::kSphere;
  p.cloud.points = 80;
  p.cloud.radius = 0.12;
  p.material.thickness = 0.001;
  p.material.damping = 2000.0;
  p.material.bending_rigidity = 0.1;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.oriented_particles.rest_shape = model::RestShape::kFlat;
  p.oriented_particles.exponents = {4.0, 2.0};
  p.oriented_particles.stretching = true;
  p.oriented_particles.growing = model::Growing::kGaps;
  p.oriented_particles.growth_interval = 0.01;
  p.oriented_particles.growth.min_gap = 1.3;
  p.oriented_particles.growth.clearance = 0.65;
  p.oriented_particles.guide = guide;
  p.oriented_particles.guide.pressure = 1000.0;
  p.gravity.setZero();
  return p;
}

struct Grown {
  double rms, largest;  // spacings, from the true surface
  double components, boundary_loops, euler_characteristic, isolated, added;
  std::string notices;
  std::uint64_t hash;
};

// distance: from the true surface, m.
Grown grow(const simulation::SceneParams& params, double duration, const Field& distance) {
  simulation::Simulation simulation(params, io::makeShape(params.cloud));
  Grown grown;
  for (long left = std::lround(duration / params.integrator.time_step); left > 0; --left) {
    const simulation::StepOutcome outcome = simulation.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    grown.notices += outcome.notice;
  }
  const auto measure = [&](const char* name) { return simulation::computeQuantity(name, simulation); };
  const double spacing = measure("spacing_mean");
  double squares = 0.0;
  grown.largest = 0.0;
  for (const Vec3& p : simulation.state().positions) {
    squares += distance(p) * distance(p) / (spacing * spacing);
    grown.largest = std::max(grown.largest, std::abs(distance(p)) / spacing);
  }
  grown.rms = std::sqrt(squares / simulation.state().size());
  grown.components = measure("components");
  grown.boundary_loops = measure("boundary_loops");
  grown.euler_characteristic = measure("euler_characteristic");
  grown.isolated = measure("isolated");
  grown.added = measure("added");
  grown.hash = simulation.statistics().state_hash;
  return grown;
}

double sphere(const Vec3& p) { return p.norm() - 0.3; }

// With its tube about the seed.
double torus(const Vec3& p) { return std::hypot(std::hypot(p.x() + 0.33, p.y()) - 0.33, p.z()) - 0.17; }

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(GuidedGrowth, ASeedBecomesASphereAnEllipsoidAndABrightOne) {
  const auto ellipsoid = [](const Vec3& p) {  // to the first order
    const Vec3 q = p.cwiseQuotient(Vec3(0.36, 0.27, 0.2)), slope = q.cwiseQuotient(Vec3(0.36, 0.27, 0.2));
    return slope.norm() > 0.0 ? q.norm() * (q.norm() - 1.0) / slope.norm() : -0.2;
  };
  const auto bright = [](const Vec3& p) { return std::clamp(std::round(128.0 - 1500.0 * sphere(p)), 0.0, 255.0); };
  const auto check = [](const GuideParams& guide, const Field& distance) {
    const Grown grown = grow(makeScene(guide), 2.5, distance);
    EXPECT_EQ(grown.components, 1.0);
    EXPECT_EQ(grown.boundary_loops, 0.0);
    EXPECT_EQ(grown.euler_characteristic, 2.0);
    EXPECT_EQ(grown.isolated, 0.0);
    EXPECT_GT(grown.added, 150.0);
    EXPECT_LT(grown.rms, 0.15);
    EXPECT_LT(grown.largest, 0.5);
    EXPECT_TRUE(contains(grown.notices, "Euler characteristic 2")) << grown.notices;
  };
  check(makeGuide(makeGrid(32, 0.45, Vec3::Zero(), sphere), 0.0, model::GuideInside::kBelow), sphere);
  check(makeGuide(makeGrid(32, 0.45, Vec3::Zero(), ellipsoid), 0.0, model::GuideInside::kBelow), ellipsoid);
  check(makeGuide(makeGrid(32, 0.45, Vec3::Zero(), bright), 128.0, model::GuideInside::kAbove), sphere);
}

// Whether their rims join to a whole torus depends on numbers (docs/oriented_particles.md).
TEST(GuidedGrowth, FrontsThatMeetInATorusGo) {
  const Vec3 center(-0.33, 0.0, 0.0);
  const simulation::SceneParams params = makeScene(makeGuide(makeGrid(40, 0.6, center, torus), 0.0, model::GuideInside::kBelow));
  simulation::Simulation simulation(params, io::makeShape(params.cloud));
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(simulation.step().ok);
  EXPECT_GT(simulation::computeQuantity("removed", simulation), 20.0);
  const model::State& state = simulation.state();
  for (Index i = 0; i < state.size(); ++i)
    for (Index j = 0; j < i; ++j) {
      const Vec3 line = state.positions[j] - state.positions[i];
      const Vec3 n = state.orientations[i] * Vec3::UnitZ(), m = state.orientations[j] * Vec3::UnitZ();
      const bool are_near = line.norm() < latticeOf(simulation).spacing && n.dot(line) > 0.8 * line.norm();
      if (!(are_near && n.dot(m) < -0.6)) continue;
      EXPECT_GT(torus(state.positions[i] + 0.5 * line), -0.02) << i << " faces " << j;
    }
}

TEST(GuidedGrowth, BitsDoNotDependOnThreads) {
  simulation::SceneParams one = makeScene(makeGuide(makeGrid(32, 0.45, Vec3::Zero(), sphere), 0.0, model::GuideInside::kBelow));
  one.threads = 1;
  simulation::SceneParams three = one;
  three.threads = 3;
  EXPECT_EQ(grow(one, 0.3, sphere).hash, grow(three, 0.3, sphere).hash);
}

// Where the inside reaches the border of the grid, the border closes it.
TEST(GuidedGrowth, TheBorderOfTheVolumeClosesTheSurface) {
  const GuideParams guide = makeGuide(makeGrid(24, 0.25, Vec3::Zero(), sphere), 0.0, model::GuideInside::kBelow);
  const auto closed = [](const Vec3& p) { return std::max(sphere(p), p.cwiseAbs().maxCoeff() - 0.25); };
  const simulation::SceneParams params = makeScene(guide);
  const Grown grown = grow(params, 2.0, closed);
  EXPECT_EQ(grown.euler_characteristic, 2.0);
  EXPECT_LT(grown.largest, 0.7);
  const simulation::Simulation begun(params, io::makeShape(params.cloud));
  std::string notes;
  for (const std::string& note : begun.buildNotes()) notes += note;
  EXPECT_TRUE(contains(notes, "border of its volume")) << notes;
}

TEST(GuidedGrowth, ANoticeTellsThatSurfaceTensionHoldsIt) {
  simulation::SceneParams params =
      makeScene(makeGuide(makeGrid(32, 0.45, Vec3::Zero(), sphere), 0.0, model::GuideInside::kBelow));
  params.oriented_particles.guide.pressure = 30.0;
  const Grown grown = grow(params, 2.0, sphere);
  EXPECT_TRUE(contains(grown.notices, "hardly moves")) << grown.notices;
  EXPECT_GT(grown.largest, 1.0);
}

TEST(GuidedGrowth, RefusesASeedOutsideAndAVolumeThatHasNotBeenRead) {
  const auto problemOf = [](const GuideParams& guide) -> std::string {
    const simulation::SceneParams params = makeScene(guide);
    try {
      simulation::Simulation(params, io::makeShape(params.cloud));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  GuideParams guide = makeGuide(makeGrid(24, 0.45, Vec3::Zero(), sphere), 0.0, model::GuideInside::kBelow);
  EXPECT_EQ(problemOf(guide), "accepted");
  guide.inside = model::GuideInside::kAbove;
  EXPECT_TRUE(contains(problemOf(guide), "found 0 of 80 particles inside")) << problemOf(guide);
  guide.grid.reset();
  EXPECT_TRUE(contains(problemOf(guide), "not been read")) << problemOf(guide);
}

}  // namespace
}  // namespace deformable_surface::test
