// The error estimate of oriented particles with kept bonds: against all particles, when it ends, and that it changes no result.
#include "support/figures.h"

#include "deformable_surface/base/parallel.h"

#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::Statistics;

constexpr int kSteps = 20;

// A thin sheet with one edge clamped, let go under gravity.
SceneParams makeSheet(Index points, Index simulated, const std::string& more = "") {
  SceneParams scene = parseScene(R"(
model: oriented_particles
oriented_particles: {bonds: kept}
cloud: {shape: sheet, size: [0.3, 0.3], jitter: 0.2}
material: {young_modulus: 2.0e4, thickness: 0.002, density: 1000.0, damping: 2.0}
pins: [{box: {min: [-1, -1, -1], max: [-0.1, 1, 1]}}]
integrator: {time_step: 0.01}
)" + more);
  scene.cloud.points = points;
  scene.simplification.method = points == simulated ? cloud::SimplificationMethod::kNone : cloud::SimplificationMethod::kDelaunay;
  scene.simplification.target_points = points == simulated ? 0 : simulated;
  return scene;
}

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// The note that there is none; empty if there is one.
std::string findNote(const Simulation& s) {
  for (const std::string& note : s.buildNotes())
    if (note.rfind("no error estimate", 0) == 0) return note;
  return "";
}

TEST(ParticleEstimate, CoversTheErrorAgainstAllParticlesInMotion) {
  SceneParams all = makeSheet(800, 800);
  all.accuracy.estimate = false;
  Simulation full = makeSimulation(all), s = makeSimulation(makeSheet(800, 200));
  ASSERT_EQ(s.state().size(), 200);
  ASSERT_EQ(findNote(s), "");
  double motion = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    ASSERT_TRUE(full.step().ok && s.step().ok);
    const Points& now = full.surface(false).positions;
    const Statistics found = s.statistics();
    motion = std::max(motion, findLargestDistance(now, full.input().positions));
    EXPECT_LE(findLargestDistance(s.surface(false).positions, now), found.error_estimate) << k;
    EXPECT_TRUE(found.error_bounded);
    EXPECT_TRUE(found.error_calibrated);
  }
  EXPECT_GT(motion, 0.05);
  EXPECT_LT(s.statistics().error_estimate, 0.5 * motion);
}

TEST(ParticleEstimate, IsThatOfTheStepsAloneWhereEveryParticleIsSimulated) {
  Simulation s = makeSimulation(makeSheet(400, 400));
  for (int k = 0; k < kSteps; ++k) ASSERT_TRUE(s.step().ok);
  const Statistics found = s.statistics();
  EXPECT_EQ(found.error_space + found.error_transfer, 0.0);
  EXPECT_GT(found.error_time, 0.0);
  EXPECT_EQ(found.error_estimate, found.error_time);
}

TEST(ParticleEstimate, ANoteSaysWhereThereIsNone) {
  SceneParams loose = makeSheet(400, 200);
  loose.oriented_particles.bonds = model::ParticleBonds::kFree;
  Simulation free = makeSimulation(loose);
  EXPECT_NE(findNote(free).find("bonds: kept only"), std::string::npos) << findNote(free);
  EXPECT_TRUE(std::isnan(free.statistics().error_estimate));
  Simulation folded = makeSimulation(makeSheet(400, 200, "creases: [{box: {min: [0.0, -1, -1], max: [0.05, 1, 1]}}]"));
  EXPECT_NE(findNote(folded).find("creases"), std::string::npos) << findNote(folded);
}

// One sentence, when it ends; a reset brings it back, and a scene without such a change never says it.
TEST(ParticleEstimate, EndsWithASentenceWhereCopiesCannotFollow) {
  const char* const kKnife = R"(
tools: [{id: knife, mode: cut, shape: {box: {size: [0.005, 0.02, 0.2]}}, path: [{time: 0.0, position: [0.021, -0.25, 0]},
  {time: 0.1, position: [0.021, 0.25, 0]}]}]
)";
  const char* const kHeat = R"(
tools: [{id: iron, mode: heat, shape: {sphere: {radius: 0.05}}, strength: 500, path: [{time: 0.05, position: [0.1, 0, 0]}]}]
)";
  const char* const kTear = R"(
forces: [{id: pull, point: [0.15, 0, 0], force: [200, 0, 0], radius: 0.05}]
)";
  const auto edit = [](Simulation& s) {
    simulation::ParticleEdit remove;
    remove.action = simulation::ParticleAction::kDelete;
    remove.ids = {s.state().traits[100].id};
    s.editParticles(remove);
  };
  struct Case {
    const char* name;
    const char* scene;
    std::function<void(Simulation&)> act;
    bool ends;
  };
  for (const Case& c : {Case{"nothing", "", {}, false}, Case{"knife", kKnife, {}, true}, Case{"heat", kHeat, {}, true},
                        Case{"tear", kTear, {}, true}, Case{"edit", "", edit, true}}) {
    Simulation s = makeSimulation(makeSheet(600, 200, c.scene));
    for (const bool is_again : {false, true}) {
      if (is_again) s.reset();
      EXPECT_EQ(s.statistics().error_estimate, 0.0) << c.name;
      int told = 0;
      for (int k = 0; k < kSteps; ++k) {
        if (k == 3 && c.act && !is_again) c.act(s);
        const simulation::StepOutcome outcome = s.step();
        ASSERT_TRUE(outcome.ok) << c.name << ": " << outcome.problem;
        told += outcome.notice.find("no error estimate until the next reset") != std::string::npos ||
                outcome.notice.find("cannot be estimated until the next reset") != std::string::npos;
      }
      const bool ends = c.ends && !(c.act && is_again);
      EXPECT_EQ(std::isinf(s.statistics().error_estimate), ends) << c.name;
      EXPECT_EQ(s.statistics().error_bounded, !ends) << c.name;
      if (!c.act) {
        EXPECT_EQ(told, ends ? 1 : 0) << c.name;
      }
    }
  }
}

TEST(ParticleEstimate, ChangesNoBitOfTheResultAndIsTheSameForEveryNumberOfThreadsAndFromASnapshot) {
  SceneParams scene = makeSheet(600, 300);
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
    EXPECT_EQ(s.stateHash(), hash);
    EXPECT_EQ(s.statistics().error_estimate, estimate);
  }
  setNumThreads(0);
  scene.accuracy.estimate = false;
  Simulation plain = makeSimulation(scene);
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(plain.step().ok);
  EXPECT_EQ(plain.stateHash(), hash);
}

}  // namespace
}  // namespace deformable_surface::test
