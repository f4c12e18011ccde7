// A surface without any particle left is a valid state: every request and command works, or is refused with a sentence.
#include "../../src/simulation/dynamics.h"
#include "clouds.h"
#include "deformable_surface/simulation/expectations.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using tool::Mode;

tool::ToolParams makeTool(const std::string& id, Mode mode, double radius) {
  tool::ToolParams tool;
  tool.id = id;
  tool.mode = mode;
  tool.shape.radius = radius;
  tool.path = {{0.0, Vec3::Zero()}};
  if (mode == Mode::kAttract || mode == Mode::kHeat) tool.strength = 1.0;
  if (mode == Mode::kAttract) tool.reach = 0.1;
  return tool;
}

SceneParams makeScene(solve::IntegratorType type = solve::IntegratorType::kAuto) {
  SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.oriented_particles.spacing = 0.1;
  p.oriented_particles.stretching = true;
  p.oriented_particles.growing = model::Growing::kEdges;
  p.oriented_particles.growth_interval = 0.01;
  p.integrator.time_step = 0.01;
  p.integrator.type = type;
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * 0.01;
  p.pressure = 1.0;
  p.viscous_drag = 1.0;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(0.01, 1.0, 1.0);
  p.pins.push_back(pin);
  p.anchors.push_back({Vec3(0.2, 0.2, 0.0), Vec3(0.2, 0.2, 0.1), 1.0});
  return p;
}

cloud::PointCloud patch() {
  Points points;
  for (Index j = 0; j < 5; ++j)
    for (Index i = 0; i < 5; ++i) points.emplace_back(0.1 * (i + 0.5 * (j % 2)), 0.0866 * j, 0.0);
  return asCloud(points);
}

Simulation makeEmpty(const SceneParams& scene) {
  Simulation s(scene, patch());
  s.setForce({"early", Vec3(0.2, 0.1, 0.0), Vec3(0.0, 0.0, 0.1), 0.0, 0.0, 1e300});
  s.setTool(makeTool("eraser", Mode::kErase, 10.0));
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(outcome.ok) << outcome.problem;
  EXPECT_EQ(s.state().size(), 0);
  EXPECT_NE(outcome.notice.find("the last particle has been removed"), std::string::npos) << outcome.notice;
  s.removeTool("eraser");
  return s;
}

void askForEverything(Simulation& s) {
  s.pinReactions();
  s.toolReactions();
  EXPECT_TRUE(s.contacts().empty());
  EXPECT_TRUE(s.activeForces().empty());
  const simulation::Statistics statistics = s.statistics();
  EXPECT_EQ(statistics.simulation_points, 0u);
  EXPECT_EQ(statistics.kinetic_energy, 0.0);
  EXPECT_EQ(statistics.elastic_energy, 0.0);
  EXPECT_EQ(statistics.potential_energy, 0.0);
  for (const bool with_normals : {false, true})
    for (const Vec3& x : s.surface(with_normals).positions) EXPECT_TRUE(std::isnan(x.x()));
  Points normals;
  s.computeSimulationNormals(normals);
  EXPECT_TRUE(normals.empty());
  std::vector<double> values;
  computePointStrain(s.model(), s.state(), values);
  s.model().links()->refreshDisplay(s.state());
  for (const char* name : {"components", "boundary_loops", "isolated"})
    EXPECT_EQ(simulation::computeQuantity(name, s), 0.0) << name;
  EXPECT_EQ(simulation::computeQuantity("removed", s), simulation::computeQuantity("added", s) + 25.0);
  for (const char* name : {"spacing_mean", "distance_to_torus_rms", "sphere_radius", "distance_to_tools_min", "touching",
                           "distance_to_input_max", "principal_angle_mean", "mean_displacement", "min_x", "volume_ratio"})
    EXPECT_THROW(simulation::computeQuantity(name, s), InputError) << name;
  s.stateHash();
  Simulation fork = s.fork(), viewer = s.viewer();
  viewer.restore(s.sight());
  EXPECT_EQ(viewer.surface(true).positions.size(), s.surface(true).positions.size());
  const simulation::Snapshot snapshot = s.snapshot();
  EXPECT_TRUE(fork.step().ok);
  fork.restore(snapshot);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
}

TEST(EmptySurface, AnswersWhateverIsAskedAndGoesOn) {
  for (const solve::IntegratorType type :
       {solve::IntegratorType::kAuto, solve::IntegratorType::kVerlet, solve::IntegratorType::kSymplecticEuler,
        solve::IntegratorType::kExplicitEuler, solve::IntegratorType::kStatic}) {
    SCOPED_TRACE(static_cast<int>(type));
    SceneParams scene = makeScene(type);
    if (!checkParams(scene).empty()) continue;  // this model does not take it
    Simulation s = makeEmpty(scene);
    askForEverything(s);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(s.step().ok);
    askForEverything(s);
  }
}

TEST(EmptySurface, TakesEveryCommandOrRefusesItInASentence) {
  Simulation s = makeEmpty(makeScene());
  s.setForce({"pull", Vec3(0.2, 0.1, 0.0), Vec3(0.0, 0.0, 0.1), 0.0, 0.0, 1e300});
  s.setForce({"around", Vec3(0.2, 0.1, 0.0), Vec3(0.0, 0.0, 0.1), 0.3, 0.0, 1e300});
  const simulation::StepOutcome told = s.step();
  EXPECT_TRUE(told.ok);
  EXPECT_NE(told.notice.find("force 'pull': there is no simulation point"), std::string::npos) << told.notice;
  EXPECT_EQ(s.step().notice, "");  // once
  for (const Mode mode : {Mode::kSolid, Mode::kAttract, Mode::kMove, Mode::kErase, Mode::kCut, Mode::kHeat}) {
    s.setTool(makeTool("tool", mode, 0.2));
    EXPECT_TRUE(s.step().ok);
    askForEverything(s);
    s.moveTool("tool", {{0.0, Vec3(0.1, 0.0, 0.0)}});
    EXPECT_TRUE(s.step().ok);
    s.removeTool("tool");
  }
  geometry::Region everywhere;
  everywhere.min = Vec3::Constant(-10.0);
  everywhere.max = Vec3::Constant(10.0);
  EXPECT_EQ(s.pin(everywhere, true), 0);
  EXPECT_EQ(s.unpin(everywhere), 0);
  s.setGravity(Vec3(0.0, 0.0, -1.0));
  s.setDamping(2.0);
  s.setState(s.state());
  s.dynamics().disturb(0.01);
  EXPECT_EQ(s.numOwnMaterial(), 0);
  try {
    s.observe(patch());
    EXPECT_TRUE(s.step().ok);
  } catch (const InputError& problem) {
    EXPECT_NE(std::string(problem.what()), "");
  }
  try {
    s.growSurface(model::GrowthParams());
  } catch (const InputError& problem) {
    EXPECT_NE(std::string(problem.what()), "");
  }
  EXPECT_TRUE(s.step().ok);
  askForEverything(s);
  s.removeForce("around");
  s.reset();
  EXPECT_EQ(s.state().size(), 25);
  EXPECT_TRUE(s.step().ok);
}

// A waiting force acts as soon as there are particles.
TEST(EmptySurface, FillsAgainAndWaitingForcesBegin) {
  Simulation s = makeEmpty(makeScene());
  s.setForce({"pull", Vec3(0.2, 0.1, 0.0), Vec3(0.0, 0.0, 0.1), 0.0, 0.0, 1e300});
  EXPECT_TRUE(s.step().ok);
  simulation::ParticleEdit edit;
  edit.positions = {Vec3(0.2, 0.1, 0.0), Vec3(0.3, 0.1, 0.0)};
  edit.orientations = {Quaternion::Identity(), Quaternion::Identity()};
  EXPECT_EQ(s.editParticles(edit).size(), 2u);
  EXPECT_TRUE(s.step().ok);
  EXPECT_EQ(s.activeForces().size(), 2u);  // "early" has waited, too
  EXPECT_TRUE(std::isfinite(s.statistics().kinetic_energy));
}

}  // namespace
}  // namespace deformable_surface::test
