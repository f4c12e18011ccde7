// Forks and snapshots of a run in which something has changed that it was made with: they go on from what is, not from what was.
#include "../../src/simulation/dynamics.h"
#include "../simulation/self_contact_runs.h"

#include <cmath>
#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr int kSteps = 5;

std::pair<std::uint64_t, double> goOn(Simulation& s) {
  run(s, kSteps);
  const double error = s.statistics().error_estimate;
  return {s.stateHash(), std::isnan(error) ? -1.0 : error};  // without an estimate
}

// Copies that are made before the run goes on end as it does, and so does the run itself once it is restored.
void expectSameCopies(Simulation& s, const SceneParams& p, const cloud::PointCloud& cloud) {
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork(), anew(p, cloud);
  anew.restore(snapshot);
  const auto expected = goOn(s);
  EXPECT_EQ(goOn(fork), expected) << "a fork";
  EXPECT_EQ(goOn(anew), expected) << "restored in a simulation built anew";
  s.restore(snapshot);
  EXPECT_EQ(goOn(s), expected) << "restored in the run";
}

simulation::MaterialChangeParams densityOf(double density) {
  simulation::MaterialChangeParams change;
  change.density = density;
  return change;
}

geometry::Region makeBall(const Vec3& center, double radius) { return {geometry::Region::Kind::kSphere, {}, {}, center, radius}; }

tool::ToolParams makeRoughBall() {
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.2;
  ball.friction = 0.5;
  ball.path = {{0.0, Vec3(0.6, 0.0, -0.22)}, {0.2, Vec3(0.6, 0.1, -0.1)}};
  return ball;
}

TEST(ChangedRun, OfASurfaceThatTouchesItselfGoesOnWithItsNewMasses) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  scene.params.contact.friction = 0.3;
  Simulation s(scene.params, scene.cloud);
  run(s, 100);
  s.setMaterial(nullptr, densityOf(3.0 * scene.params.material.density));
  run(s, 50);
  ASSERT_GT(s.statistics().self_contacts, 0u);
  expectSameCopies(s, scene.params, scene.cloud);
}

// Contact with a tool is damped by masses of points between simulation points. On a pad it has areas, which stay.
TEST(ChangedRun, OfASheetOnAToolGoesOnWithItsNewMasses) {
  for (const double compliance : {0.0, 1e-4}) {
    SCOPED_TRACE(compliance);
    SceneParams p = hangingSheet();
    p.tools = {makeRoughBall()};
    p.contact.compliance = compliance;
    Simulation s(p, sheetCloud());
    run(s, 12);
    ASSERT_FALSE(s.contacts().empty());
    const geometry::Region half = makeBall(Vec3(0.6, 0.2, 0.0), 0.25);
    s.setMaterial(&half, densityOf(5.0 * p.material.density));
    run(s, 2);
    ASSERT_FALSE(s.contacts().empty());
    expectSameCopies(s, p, sheetCloud());
  }
}

// Contact is made for the integrator of the scene: springs harden and damping sets in gradually for implicit steps alone.
TEST(ChangedRun, WithAnotherIntegratorKeepsItsContact) {
  SceneParams p = hangingSheet();
  p.tools = {makeRoughBall()};
  Simulation s(p, sheetCloud());
  s.dynamics().chooseIntegrator(IntegratorType::kImplicit);
  run(s, 12);
  ASSERT_FALSE(s.contacts().empty());
  Simulation fork = s.fork();
  EXPECT_EQ(goOn(fork), goOn(s));
}

// Other clamps void what the march has measured. A state that is saved before the next step knows it.
TEST(ChangedRun, WithOtherHeldPointsGoesOnFromBeforeTheNextStep) {
  const std::function<void(Simulation&)> changes[] = {
      [](Simulation& s) { s.pin(makeBall(Vec3(0.5, 0.5, 0.0), 0.3)); },
      [](Simulation& s) { s.unpin(makeBall(Vec3(0.0, 0.5, 0.0), 0.3)); },
      [](Simulation& s) { s.removeTool("hand"); },
  };
  for (const auto& change : changes) {
    SCOPED_TRACE(&change - changes);
    SceneParams p = hangingSheet();
    tool::ToolParams hand;
    hand.id = "hand";
    hand.mode = tool::Mode::kMove;
    hand.shape.radius = 0.3;
    hand.path = {{0.0, Vec3(1.0, 0.5, 0.0)}, {0.5, Vec3(0.8, 0.5, 0.2)}};
    p.tools = {hand};
    Simulation s(p, sheetCloud());
    run(s, 10);
    change(s);
    expectSameCopies(s, p, sheetCloud());
  }
}

// That a force acts on pinned points is told once in a run, and once in each of its coarser copies.
TEST(ChangedRun, HasTheSameEstimateWhateverHasBeenTold) {
  SceneParams p = hangingSheet();
  p.integrator.type = IntegratorType::kVerlet;
  Simulation s(p, sheetCloud());
  run(s, 5);
  simulation::MaterialChangeParams stiffer;
  stiffer.young_modulus = 30.0 * p.material.young_modulus;  // takes other numbers of sub-steps
  s.setMaterial(nullptr, stiffer);
  s.setForce({"useless", Vec3(0.0, 0.5, 0.0), Vec3(0.0, 0.0, 0.01), 0.0, 0.0, 1.0});
  const simulation::Snapshot snapshot = s.snapshot();
  EXPECT_NE(s.step().notice, "");
  const double expected = s.statistics().error_estimate;
  s.restore(snapshot);
  run(s, 1);
  EXPECT_EQ(s.statistics().error_estimate, expected);
}

}  // namespace
}  // namespace deformable_surface::test
