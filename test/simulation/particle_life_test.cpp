// Changes of particles between steps: heat from knives.
#include "deformable_surface/simulation/simulation.h"

#include "cloud/test_surfaces.h"
#include "clouds.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/expectations.h"
#include "particles.h"
#include "support/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace deformable_surface::test {
namespace {

simulation::SceneParams particleSheet() {
  simulation::SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  return p;
}

TEST(ParticleLife, AKnifeHeatsWhatItTouchesToItsTemperatureOrNothing) {
  for (const double strength : {0.0, 700.0}) {
    simulation::SceneParams p = particleSheet();
    p.tools.resize(1);
    p.tools[0].id = "knife";
    p.tools[0].mode = tool::Mode::kCut;
    p.tools[0].strength = strength;
    p.tools[0].shape.radius = 0.2;
    p.tools[0].path.resize(1);
    p.tools[0].path[0].position = Vec3(0.5, 0.5, 0.0);
    simulation::Simulation s(p, sheetCloud(12));
    const Points before = s.state().positions;  // the sheet is square: they have settled
    run(s, 1);
    Index touched = 0;
    for (Index i = 0; i < s.state().size(); ++i) {
      const double far = (before[i] - p.tools[0].path[0].position).norm();
      const double reach = 0.2 + 0.5 * latticeOf(s).spacing;
      EXPECT_EQ(s.state().traits[i].temperature, far > reach ? 0.0 : strength) << far;
      touched += far <= reach;
    }
    EXPECT_GT(touched, 10);
    EXPECT_LT(touched, s.state().size());
  }
}

// Two samples in nearly one place would stay there: repulsion is constant near zero, and none at zero.
TEST(ParticleLife, AfterAFitNoTwoParticlesAreInOnePlace) {
  for (const bool lets_go : {true, false})
    for (const double apart : {0.02, 0.05, 0.1}) {  // spacings; nearer than about a hundredth they are one sample
      simulation::SceneParams p = particleSheet();
      p.pins.clear();
      p.simplification.method = cloud::SimplificationMethod::kNone;
      p.gravity.setZero();
      const double spacing = 0.1;
      p.oriented_particles.spacing = spacing;
      p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * spacing * spacing;
      p.oriented_particles.grow_surface = true;
      p.oriented_particles.growth.release_samples = lets_go;
      cloud::PointCloud cloud = sheetCloud(8);
      for (const Index i : {20, 33, 46}) cloud.positions.push_back(cloud.positions[i] + Vec3(0.6, 0.8, 0.0) * apart * spacing);
      cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
      simulation::Simulation s(p, cloud);
      double nearest = 1e300;
      for (Index i = 0; i < s.state().size(); ++i)
        for (Index j = 0; j < i; ++j) nearest = std::min(nearest, (s.state().positions[i] - s.state().positions[j]).norm());
      const auto& notes = s.buildNotes();
      const bool is_told = std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
        return note.find("3 pairs of held particles are nearer") != std::string::npos;
      });
      EXPECT_EQ(is_told, !lets_go) << apart;
      if (lets_go) {
        EXPECT_GE(nearest, 0.3 * latticeOf(s).spacing) << apart;
      }
      run(s, 5);
    }
}

// Particles grown through samples of a torus come to rest near it, and stay there. By all forces alone the stress of the uneven
// lattice raises bumps: the two surfaces are then 0.073 spacings from it (rms, mean of both), and 0.078 after the steps.
TEST(ParticleLife, GrownToriRestNearTheirSamples) {
  constexpr double kSpacing = 0.09, kNear = 0.045;  // m; spacings
  double at_start = 0.0, after_steps = 0.0;
  constexpr unsigned kSeeds = 6;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const cloud::TestSurface torus = cloud::makeTorus(36, 14, 0.15, seed);
    simulation::SceneParams p = particleSheet();
    p.material.bending_rigidity = p.material.young_modulus * p.material.thickness * kSpacing * kSpacing;
    p.oriented_particles.spacing = kSpacing;
    p.oriented_particles.grow_surface = true;
    p.oriented_particles.growth.min_gap = 1.6;
    p.oriented_particles.growth.max_gap = 4.0;
    p.oriented_particles.growth.clearance = 0.65;
    cloud::PointCloud cloud;
    cloud.positions = torus.positions;
    cloud.normals = torus.normals;
    cloud.width = static_cast<std::uint32_t>(torus.size());
    simulation::Simulation s(p, cloud);
    const auto findDistance = [&] {
      double squares = 0.0;
      for (const Vec3& x : s.state().positions) squares += std::pow(std::hypot(std::hypot(x.x(), x.y()) - 1.0, x.z()) - 0.4, 2);
      return std::sqrt(squares / s.state().size()) / kSpacing;
    };
    at_start += findDistance() / kSeeds;
    run(s, 20);
    after_steps += findDistance() / kSeeds;
  }
  EXPECT_LT(at_start, kNear);
  EXPECT_LT(after_steps, kNear);
}

TEST(ParticleLife, SamplesThatAreFartherApartThanTheWidestGapAreTold) {
  constexpr double kApart = 0.1;
  for (const double max_gap : {3.0, 6.0}) {  // spacings; the samples are 4 apart
    simulation::SceneParams p = particleSheet();
    p.oriented_particles.spacing = kApart / 4.0;
    p.oriented_particles.grow_surface = true;
    p.oriented_particles.growth.max_gap = max_gap;
    p.oriented_particles.growth.sample_gap = 2.0;
    const simulation::Simulation s(p, asCloud(makeSheet(4, 4, 3.0 * kApart, 3.0 * kApart, 0.0).points));
    const auto has = [](const std::vector<std::string>& lines, const char* words) {
      return std::any_of(lines.begin(), lines.end(),
                         [&](const std::string& line) { return line.find(words) != std::string::npos; });
    };
    const bool is_narrow = max_gap < 4.0;
    EXPECT_EQ(has(s.buildWarnings(), "16 of 16 samples are farther from all others than growth.max_gap, 3 spacings"), is_narrow);
    EXPECT_EQ(has(s.buildNotes(), "until all gaps that were left were wider than growth.max_gap"), is_narrow);
    EXPECT_EQ(has(s.buildNotes(), "until there was no more room"), !is_narrow);
  }
}

// 225 samples leave no room for more particles, which then lie too far apart.
TEST(ParticleLife, SamplesThatAGrownSurfaceLeavesAreAWarning) {
  for (const Index samples : {80, 225}) {
    simulation::SceneParams p = loadScene("particles_grow");
    p.cloud.points = samples;
    const simulation::Simulation s = makeSimulation(p);
    const auto& warnings = s.buildWarnings();
    EXPECT_EQ(std::any_of(warnings.begin(), warnings.end(),
                          [](const std::string& line) {
                            return line.find("the grown surface has left its samples") != std::string::npos;
                          }),
              samples == 225);
  }
}

// A warning tells that a grown surface will move by itself, as it does when samples were held in growth and are then let go.
TEST(ParticleLife, GrownSurfacesThatAreNotAtRestAreAWarning) {
  for (const bool lets_go : {true, false}) {
    simulation::SceneParams p = loadScene("particles_fit");
    p.oriented_particles.growth.release_samples = lets_go;
    simulation::Simulation s = makeSimulation(p);
    const auto& warnings = s.buildWarnings();
    const bool is_told = std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("they are not at rest") != std::string::npos;
    });
    EXPECT_EQ(is_told, !lets_go);
    double fastest = 0.0;  // m/s
    for (int step = 0; step < 20; ++step) {
      run(s, 1);
      fastest = std::max(fastest, simulation::computeQuantity("max_speed", s));
    }
    EXPECT_EQ(fastest > 0.1, !lets_go) << fastest;
  }
}

// Pins without `orientation` hold positions alone. Normals that are held while particles come to rest turn when they are let go:
// the fastest particle then has 0.25 m/s after the first step.
TEST(ParticleLife, GrownSurfacesThatArePinnedBeginAtRest) {
  simulation::SceneParams p = loadScene("particles_fit");
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1.0, 1.0, -0.4);
  p.pins = {pin};
  simulation::Simulation s = makeSimulation(p);
  ASSERT_GT(std::count(s.pinned().begin(), s.pinned().end(), 1), 3);
  run(s, 1);
  EXPECT_LT(simulation::computeQuantity("max_speed", s), 0.01);
}

// Samples are not yet the surface: their links and parts are not told.
TEST(ParticleLife, NotesOfAGrownSurfaceDoNotCountItsSamplesParts) {
  for (const bool is_held : {false, true}) {
    simulation::SceneParams p = particleSheet();
    p.pins.resize(is_held ? 1 : 0);
    if (is_held) {
      p.pins[0].region.min = Vec3(-0.001, -1.0, -1.0);
      p.pins[0].region.max = Vec3(0.001, 1.0, 1.0);
    }
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.gravity.setZero();
    p.oriented_particles.spacing = 0.05;
    p.oriented_particles.grow_surface = true;
    const simulation::Simulation s(p, sheetCloud(8));
    std::string all;
    for (const std::vector<std::string>& sentences : {s.buildNotes(), s.buildWarnings()})
      for (const std::string& sentence : sentences) all += sentence + "\n";
    EXPECT_NE(all.find("a surface is grown"), std::string::npos) << all;
    EXPECT_NE(all.find("64 points, 64 simulation points before the surface is grown, "), std::string::npos) << all;
    EXPECT_EQ(all.find(" parts of "), std::string::npos) << all;
    EXPECT_EQ(all.find("no pin, anchor or tool holds what is simulated: it moves freely") == std::string::npos, is_held) << all;
  }
}

// Samples, of which the nearest are three spacings apart.
TEST(ParticleLife, ParticlesTooFarApartForBondsAreAWarningUnlessASurfaceIsGrown) {
  for (const bool grows : {false, true}) {
    simulation::SceneParams p = particleSheet();
    p.pins.clear();
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.oriented_particles.rest_shape = model::RestShape::kFlat;
    p.oriented_particles.spacing = 0.05;
    p.oriented_particles.grow_surface = grows;
    const simulation::Simulation s(p, sheetCloud(8));
    const auto& warnings = s.buildWarnings();
    const bool is_told = std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("fly or fall apart") != std::string::npos;
    });
    EXPECT_EQ(is_told, !grows);
  }
}

// What growth leaves undone is a warning, with the number that ended it, or the place.
TEST(ParticleLife, GrowthThatIsNotCompleteIsAWarning) {
  const auto warningOf = [](const std::function<void(simulation::SceneParams&, cloud::PointCloud&)>& change) {
    simulation::SceneParams p = particleSheet();
    p.pins.clear();
    p.oriented_particles.spacing = 0.1;
    p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * 0.01;
    p.oriented_particles.grow_surface = true;
    p.oriented_particles.growth.max_gap = 4.0;
    cloud::PointCloud cloud = sheetCloud(5);  // a quarter of the unit square apart: rooms for one or two between them
    change(p, cloud);
    cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
    simulation::Simulation s(p, cloud);
    std::string all;
    for (const std::string& warning : s.buildWarnings()) all += warning + "; ";
    return all;
  };
  EXPECT_EQ(warningOf([](auto&, auto&) {}), "");
  const std::string passes = warningOf([](auto& p, auto&) { p.oriented_particles.growth.max_passes = 1; });
  EXPECT_NE(passes.find("growth ended at growth.max_passes, 1: the surface is not complete"), std::string::npos) << passes;
  const std::string particles = warningOf([](auto& p, auto&) { p.oriented_particles.growth.max_particles = 40; });
  EXPECT_NE(particles.find("growth ended at growth.max_particles, 40: the surface is not complete"), std::string::npos)
      << particles;
  const std::string lonely = warningOf([](auto&, auto& cloud) { cloud.positions.emplace_back(0.5, 0.5, 3.0); });
  EXPECT_NE(lonely.find("1 particle belongs to no surface, the first at (0.5, 0.5, 3) m"), std::string::npos) << lonely;
}

// Two balls dent a sphere from both ends. Without the tube between the dents particles between the balls are thrown off.
TEST(ParticleLife, DentsThatMeetBetweenTwoBallsBecomeATunnel) {
  simulation::SceneParams p = loadScene("particles_torus");
  p.cloud.points = 800;
  p.material.bending_rigidity = 0.0635;  // 0.14 E h a^2
  simulation::Simulation s = makeSimulation(p);
  runScene(s);
  EXPECT_EQ(simulation::computeQuantity("components", s), 1.0);
  EXPECT_EQ(simulation::computeQuantity("boundary_loops", s), 0.0);
  EXPECT_EQ(simulation::computeQuantity("euler_characteristic", s), 0.0);
  EXPECT_EQ(simulation::computeQuantity("isolated", s), 0.0);
}

// A soft sheet that breaks under its weight draws up into clumps. Its particles have more bonds each then, and a step costs as
// much more.
TEST(ParticleLife, ASheetThatClumpsIsToldOnce) {
  for (const bool is_heavy : {true, false}) {
    simulation::SceneParams p = particleSheet();
    p.cloud.shape = simulation::CloudParams::Shape::kLattice;
    p.cloud.points = 400;
    p.cloud.size = Vec2(0.3, 0.3);
    p.material.young_modulus = 2e4;
    p.material.thickness = 0.003;
    if (is_heavy) p.gravity = Vec3(0.0, 0.0, -9.81);
    for (const double sign : {-1.0, 1.0}) {
      tool::ToolParams hand;
      hand.id = sign > 0.0 ? "right" : "left";
      hand.mode = tool::Mode::kMove;
      hand.shape.kind = geometry::Solid::Kind::kBox;
      hand.shape.size = Vec3(0.04, 0.4, 0.1);
      hand.path = {{0.0, Vec3(0.14 * sign, 0.0, 0.0)}};
      p.tools.push_back(hand);
    }
    simulation::Simulation s(p, io::makeShape(p.cloud));
    int told = 0;
    for (int k = 0; k < 120; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      told += outcome.notice.find("particles pile up: found ") != std::string::npos;
    }
    EXPECT_EQ(told, is_heavy ? 1 : 0);
  }
}

}  // namespace
}  // namespace deformable_surface::test
