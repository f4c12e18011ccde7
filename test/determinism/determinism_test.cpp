// The same input gives the same bits: in two runs, with any number of threads, and after a reset.
#include "../simulation/clouds.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

// More than one block of every parallel loop over simulation points and over dense points.
constexpr Index kManyPoints = 2500;
constexpr Index kSide = 70;  // of the sheet, in points
// More than one block of the loops over links, triangles and curvatures, for steps that factorise a matrix.
constexpr Index kFewPoints = 800;

struct Result {
  std::uint64_t hash = 0;
  std::vector<std::uint64_t> bits;  // of positions, displacements and normals
  Index num_inserted = 0;

  bool operator==(const Result& other) const { return hash == other.hash && bits == other.bits; }
};

Result resultOf(Simulation& s) {
  Result result;
  result.hash = s.stateHash();
  const auto note = [&](double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    result.bits.push_back(bits);
  };
  const simulation::Surface& surface = s.surface(true);
  for (std::size_t i = 0; i < surface.positions.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      note(surface.positions[i][c]);
      note(surface.normals[i][c]);
    }
  for (float d : surface.displacement) note(d);
  result.num_inserted = static_cast<Index>(surface.positions.size()) - surface.num_input;
  return result;
}

struct Case {
  const char* name;
  std::function<SceneParams()> params;
  bool sphere;
  std::function<void(Simulation&)> act;
};

SceneParams sheet(solve::IntegratorType type, Index points = kManyPoints) {
  SceneParams p = hangingSheet();
  p.integrator.type = type;
  p.material.spring_damping = 1e-4;
  p.simplification.target_points = points;
  return p;
}

SceneParams loadedSheet(solve::IntegratorType type, Index points = kManyPoints) {
  SceneParams p = sheet(type, points);
  p.pressure = 0.1;
  p.viscous_drag = 0.1;
  return p;
}

// The weight acts along the sheet. An equilibrium far from rest takes many iterations.
SceneParams staticSheet() {
  SceneParams p = sheet(solve::IntegratorType::kStatic, kFewPoints);
  p.gravity = Vec3(0.1, 0.0, 0.0);
  return p;
}

SceneParams stretchedSheet() {
  SceneParams p = sheet(solve::IntegratorType::kVerlet);
  p.gravity = Vec3(500.0, 0.0, 0.0);
  p.output.resample = true;
  return p;
}

SceneParams keptVolume() {
  SceneParams p = sheet(solve::IntegratorType::kVerlet);
  p.pins.clear();
  p.mass_spring.volume_stiffness = 1e4;
  return p;
}

// Triangles and curvature alone: no springs.
SceneParams undampedSheet() {
  SceneParams p = sheet(solve::IntegratorType::kVerlet);
  p.material.spring_damping = 0.0;
  return p;
}

// As in scenes/published.yaml.
SceneParams published() {
  SceneParams p = sheet(solve::IntegratorType::kExplicitEuler);
  p.material.spring_damping = 1e-3;
  p.mass_spring.membrane = model::Membrane::kSprings;
  p.mass_spring.bending = model::Bending::kSprings;
  p.mass_spring.stiffness = model::Stiffness::kUniform;
  p.mass_spring.spring_constant = 10.0;
  p.mass_spring.damping = model::Damping::kRelativeVelocity;
  p.integrator.time_step = 1e-4;
  p.transfer.weighting = transfer::Weighting::kGaussian;
  p.transfer.normals = transfer::NormalMethod::kCovariance;
  return p;
}

void pinAndUnpin(Simulation& s) {
  geometry::Region corner;
  corner.min = Vec3(0.8, 0.2, -1.0);
  corner.max = Vec3(1.1, 1.0, 1.0);
  run(s, 1);
  EXPECT_GT(s.pin(corner), 0);
  run(s, 2);
  EXPECT_GT(s.unpin(corner), 0);
  run(s, 1);
}

std::function<void(Simulation&)> steps(int number) {
  return [number](Simulation& s) { run(s, number); };
}

const Case kCases[] = {
    {"Verlet", [] { return loadedSheet(solve::IntegratorType::kVerlet); }, false, steps(4)},
    {"WithoutSpringDamping", undampedSheet, false, steps(4)},
    {"Implicit", [] { return loadedSheet(solve::IntegratorType::kImplicit, kFewPoints); }, false, steps(1)},
    {"Static", staticSheet, false, steps(1)},
    {"Resampling", stretchedSheet, false, steps(8)},
    {"PinsThatComeAndGo", [] { return sheet(solve::IntegratorType::kVerlet); }, false, pinAndUnpin},
    {"KeptVolume", keptVolume, true, steps(3)},
    {"Published", published, false, steps(20)},
};

class Determinism : public testing::TestWithParam<Case> {
 protected:
  ~Determinism() override { setNumThreads(0); }

  Result simulate(int threads) {
    const Case& c = GetParam();
    setNumThreads(threads);
    Simulation s(c.params(), c.sphere ? asCloud(makeSphere(kSide * kSide, 0.5).points) : sheetCloud(kSide));
    EXPECT_EQ(s.state().size(), s.params().simplification.target_points);
    c.act(s);
    return resultOf(s);
  }
};

TEST_P(Determinism, RunsAreBitIdenticalForOneTwoAndThreeThreads) {
  const Result one = simulate(1);
  EXPECT_TRUE(one == simulate(1)) << "a second time";
  EXPECT_TRUE(one == simulate(2)) << "two threads";
  EXPECT_TRUE(one == simulate(3)) << "three threads";
  if (GetParam().params().output.resample) {
    EXPECT_GT(one.num_inserted, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(, Determinism, testing::ValuesIn(kCases), [](const auto& info) { return std::string(info.param.name); });

TEST(DeterminismThroughAReset, ARunAfterAResetIsBitIdenticalToTheFirst) {
  SceneParams p = stretchedSheet();
  p.simplification.target_points = 300;
  Simulation s(p, sheetCloud(30));
  const std::uint64_t at_rest = s.stateHash();
  pinAndUnpin(s);
  const Result first = resultOf(s);
  EXPECT_NE(first.hash, at_rest);
  s.reset();
  EXPECT_EQ(s.stateHash(), at_rest);
  pinAndUnpin(s);
  EXPECT_TRUE(resultOf(s) == first);
}

}  // namespace
}  // namespace deformable_surface::test
