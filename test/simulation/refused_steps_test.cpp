// Refused steps, whatever the cause: the state is as before, and the run continues as if they had never been tried.
#include "../../src/simulation/dynamics.h"
#include "../support/random_scene.h"
#include "clouds.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <random>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using tool::Mode;

// All outputs that can be requested.
struct Sight {
  std::uint64_t hash, steps;
  double kinetic, elastic, potential, stretch, error;
  Index size;
  std::size_t forces, links;
  std::vector<char> pinned;
  double grip, surface;

  bool operator==(const Sight& o) const {
    const auto isSame = [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; };
    return hash == o.hash && steps == o.steps && isSame(kinetic, o.kinetic) && isSame(elastic, o.elastic) &&
           isSame(potential, o.potential) && isSame(stretch, o.stretch) && isSame(error, o.error) && size == o.size &&
           forces == o.forces && links == o.links && pinned == o.pinned && isSame(grip, o.grip) && isSame(surface, o.surface);
  }
};

std::ostream& operator<<(std::ostream& out, const Sight& s) {
  return out << "hash " << s.hash << " steps " << s.steps << " energies " << s.kinetic << ' ' << s.elastic << ' ' << s.potential
             << " stretch " << s.stretch << " error " << s.error << " points " << s.size << " forces " << s.forces << " links "
             << s.links << " grip " << s.grip << " surface " << s.surface;
}

Sight look(Simulation& s) {
  const simulation::Statistics now = s.statistics();
  Sight sight{s.stateHash(),
              s.stepCount(),
              now.kinetic_energy,
              now.elastic_energy,
              now.potential_energy,
              now.max_stretch,
              now.error_estimate,
              s.state().size(),
              s.forceIds().size(),
              stretchLinksOf(s.model()).size(),
              s.pinned(),
              0.0,
              0.0};
  for (const simulation::ToolReaction& reaction : s.toolReactions()) sight.grip += reaction.force.norm() + reaction.contacts;
  for (const Vec3& x : s.surface(false).positions)
    if (x.allFinite()) sight.surface += x.x() + 3.0 * x.y() - x.z();
  return sight;
}

tool::ToolParams makeTool(const std::string& id, Mode mode, const Vec3& from, const Vec3& to, double radius) {
  tool::ToolParams tool;
  tool.id = id;
  tool.mode = mode;
  tool.shape.radius = radius;
  tool.path = {{0.0, from}, {0.3, to}};
  if (mode == Mode::kHeat) tool.strength = 60.0;
  return tool;
}

struct Scene {
  SceneParams params;
  cloud::PointCloud cloud;
};

// Cut, gripped, pulled, and pushed by a ball that appears inside it.
Scene makeSheetScene(std::mt19937& draw) {
  SceneParams p = hangingSheet();
  p.simplification.target_points = 60 + static_cast<Index>(draw() % 40);
  p.integrator.time_step = 0.02;
  tool::ToolParams knife = makeTool("knife", Mode::kCut, Vec3(0.47, -0.8, 0.0), Vec3(0.47, 0.8, 0.0), 1.0);
  knife.shape.kind = geometry::Solid::Kind::kBox;
  knife.shape.size = Vec3(0.004, 0.2, 2.0);
  const double side = 0.2 * static_cast<double>(draw() % 3);
  p.tools = {makeTool("hand", Mode::kMove, Vec3(0.9, side, 0.0), Vec3(0.8, side, 0.3), 0.1),
             makeTool("ball", Mode::kSolid, Vec3(0.5, 0.1, 0.02), Vec3(0.5, 0.2, 0.2), 0.08), knife};
  p.tools[draw() % 3].start = 0.05;
  p.forces.push_back({"pull", Vec3(0.6, 0.3, 0.0), Vec3(0.3, 0.0, 0.5), 0.2, 0.03, 0.09});
  p.accuracy.estimate = draw() % 2 == 0;
  p.accuracy.estimate = p.accuracy.estimate && draw() % 2 == 0;
  return {p, sheetCloud(20)};
}

Scene makeParticleScene(std::mt19937& draw) {
  SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.time_step = 0.002;
  p.integrator.max_iterations = 20;
  p.material.young_modulus = 1e4;
  p.oriented_particles.spacing = 0.1;
  p.oriented_particles.stretching = true;
  p.oriented_particles.growth_interval = 0.002;
  p.oriented_particles.growing = draw() % 2 == 0 ? model::Growing::kEdges : model::Growing::kNone;
  p.oriented_particles.growth.max_particles = 100;
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * 0.01;
  Points points;
  for (Index j = 0; j < 8; ++j)
    for (Index i = 0; i < 8; ++i) points.emplace_back(0.1 * (i + 0.5 * (j % 2)), 0.0866 * j, 0.0);
  p.tools = {makeTool("iron", Mode::kHeat, Vec3(0.2, 0.2, 0.0), Vec3(0.5, 0.2, 0.0), 0.12),
             makeTool("hand", Mode::kMove, Vec3(0.6, 0.5, 0.0), Vec3(0.9, 0.6, 0.1), 0.1),
             makeTool("eraser", Mode::kErase, Vec3(0.0, 0.6, 0.0), Vec3(0.4, 0.6, 0.0), 0.06)};
  p.tools[draw() % 3].start = 0.006;
  p.forces.push_back({"pull", Vec3(0.3, 0.3, 0.0), Vec3(0.0, 0.0, 0.2), 0.2, 0.004, 0.012});
  return {p, asCloud(points)};
}

Scene makeSolidScene(std::mt19937& draw) {
  SceneParams p;
  p.model = "elastic_solid";
  p.cloud.shape = simulation::CloudParams::Shape::kBar;
  p.cloud.points = 120 + static_cast<Index>(draw() % 60);
  p.cloud.size = Vec2(0.4, 0.1);
  p.cloud.height = 0.1;
  p.cloud.jitter = 0.2;
  p.material.poisson_ratio = 0.3;
  p.material.young_modulus = 1e5;
  p.accuracy.estimate = false;
  if (draw() % 2 == 0) p.elastic_solid.plasticity.yield_stress = 2e3;
  p.integrator.time_step = 0.005;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1e-6, 1.0, 1.0);
  p.pins.push_back(pin);
  p.tools = {makeTool("hand", Mode::kMove, Vec3(0.4, 0.0, 0.05), Vec3(0.3, 0.2, 0.1), 0.06),
             makeTool("ball", Mode::kSolid, Vec3(0.2, 0.0, 0.1), Vec3(0.2, 0.0, -0.1), 0.05)};
  p.tools[0].start = 0.01;
  return {p, io::makeShape(p.cloud)};
}

Scene makeScene(int kind, std::mt19937& draw) {
  Scene scene = kind == 0 ? makeSheetScene(draw) : kind == 1 ? makeParticleScene(draw) : makeSolidScene(draw);
  const solve::IntegratorType types[] = {solve::IntegratorType::kAuto, solve::IntegratorType::kVerlet,
                                         kind == 1 ? solve::IntegratorType::kStatic : solve::IntegratorType::kImplicit};
  scene.params.integrator.type = types[draw() % 3];
  return scene;
}

class RefusedSteps : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override { setNumThreads(1); }
  void TearDown() override { setNumThreads(0); }
};

// Before every step of a scene, the step is tried and interrupted at a random check among all of its checks.
TEST_P(RefusedSteps, AnInterruptAnywhereLeavesEverythingAsItWas) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    std::mt19937 draw(seed);
    Scene scene = makeScene(GetParam(), draw);
    if (GetParam() == 1) scene.params.oriented_particles.growing = seed == 1 ? model::Growing::kEdges : model::Growing::kNone;
    Simulation undisturbed(scene.params, scene.cloud), s(scene.params, scene.cloud);
    std::atomic<bool> flag{false};
    undisturbed.setInterrupt(&flag);
    s.setInterrupt(&flag);
    for (int k = 0; k < 8; ++k) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " step " + std::to_string(k));
      simulation::StepOutcome whole;
      long looks = 0;
      {
        const LookCounter counter(flag);
        whole = undisturbed.step();
        looks = counter.count();
      }
      ASSERT_TRUE(whole.ok) << whole.problem;
      ASSERT_GT(looks, undisturbed.dynamics().lastSubsteps());
      const Sight before = look(s);
      bool is_taken = false;  // what an earlier try has found, such as the pattern of a matrix, saves checks in the next
      for (const long at : {1L, 1 + static_cast<long>(draw() % looks), 1 + static_cast<long>(draw() % looks), looks}) {
        {
          const LookCounter counter(flag, at);
          const simulation::StepOutcome outcome = s.step();
          is_taken = outcome.ok;
          if (is_taken) {
            ASSERT_LT(counter.count(), at) << " of " << looks;
            break;
          }
          EXPECT_NE(outcome.problem.find("was interrupted; the state before it is kept"), std::string::npos) << outcome.problem;
          EXPECT_LE(counter.count(), at + 2);  // it ends there, and so do the copies of the error estimate
        }
        flag = false;
        ASSERT_EQ(look(s), before) << at << " of " << looks;
      }
      ASSERT_TRUE(is_taken || s.step().ok);
      ASSERT_EQ(look(s), look(undisturbed));
    }
  }
}

// With two threads two copies of the error estimate step at once. The interrupt comes at a random check of one of them, wherever
// the other is.
TEST_P(RefusedSteps, AnInterruptWhileSeveralThreadsStepLeavesEverythingAsItWas) {
  setNumThreads(2);
  int interrupted = 0;
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    std::mt19937 draw(seed);
    const Scene scene = makeScene(GetParam(), draw);
    Simulation undisturbed(scene.params, scene.cloud), s(scene.params, scene.cloud);
    std::atomic<bool> flag{false};
    undisturbed.setInterrupt(&flag);
    s.setInterrupt(&flag);
    for (int k = 0; k < 8; ++k) {
      long looks = 0;
      {
        const LookCounter counter(flag);
        ASSERT_TRUE(undisturbed.step().ok);
        looks = counter.count();
      }
      const Sight before = look(s);
      bool is_taken = false;
      {
        const LookCounter counter(flag, 1 + static_cast<long>(draw() % looks));
        is_taken = s.step().ok;
      }
      flag = false;
      interrupted += !is_taken;
      if (!is_taken) ASSERT_EQ(look(s), before) << "seed " << seed << " step " << k;
      ASSERT_TRUE(is_taken || s.step().ok);
      ASSERT_EQ(look(s), look(undisturbed)) << "seed " << seed << " step " << k;
    }
  }
  EXPECT_GT(interrupted, 8);  // of 24; fewer checks may be left to this thread than in the other run
}

// Forces that no step can bear, points on top of each other, and heat, in scenes that have run for a while.
TEST_P(RefusedSteps, WhatNoStepBearsLeavesEverythingAsItWas) {
  // A step that would take minutes is interrupted. Those of sheets end after 2,000 to 25,000 checks, which take less time.
  const long most_looks = GetParam() == 0 ? 30000 : 3000;
  int refused = 0, interrupted = 0;
  for (std::uint32_t seed = 100; seed < 112; ++seed) {
    std::mt19937 draw(seed);
    Scene scene = makeScene(GetParam(), draw);
    if (draw() % 2 == 0) scene.params.integrator.type = solve::IntegratorType::kVerlet;
    scene.params.contact.self = false;  // it holds what is thrown many edges through others
    Simulation s(scene.params, scene.cloud);
    for (std::uint32_t k = draw() % 6; k > 0; --k) s.step();
    const int kind = static_cast<int>(draw() % 3);
    if (kind != 0) {
      model::State state = s.state();
      for (std::size_t i = 0; i < state.positions.size(); ++i) {
        state.velocities[i].setZero();
        if (!s.pinned()[i] && draw() % 2 == 0)
          state.positions[i] = state.positions[(i + 1) % state.positions.size()] + Vec3(1e-13 * (kind - 1), 0.0, 0.0);
      }
      s.setState(state);
    }
    s.setForce({"blow", Vec3(0.3, 0.1, 0.0), Vec3(1e12, 1e10, 1e11), 0.2, s.time(), 1e300});
    for (int k = 0; k < 3; ++k) {
      const Sight before = look(s);
      std::atomic<bool> flag{false};
      s.setInterrupt(&flag);
      const LookCounter counter(flag, most_looks);
      const simulation::StepOutcome outcome = s.step();
      s.setInterrupt(nullptr);
      if (outcome.ok) continue;
      ++(flag ? interrupted : refused);
      ASSERT_EQ(look(s), before) << "seed " << seed << " kind " << kind << ' ' << outcome.problem;
    }
  }
  EXPECT_GT(refused, 2);
  EXPECT_GT(refused + interrupted, 10);
}

std::string nameOf(const ::testing::TestParamInfo<int>& info) {
  static const char* const kNames[] = {"Sheets", "Particles", "Solids"};
  return kNames[info.param];
}

INSTANTIATE_TEST_SUITE_P(OfEveryModel, RefusedSteps, ::testing::Values(0, 1, 2), nameOf);

}  // namespace
}  // namespace deformable_surface::test
