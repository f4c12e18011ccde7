#include "clouds.h"
#include "deformable_surface/simulation/tool_reaction.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

double massOf(const simulation::Simulation& s) {
  double mass = 0.0;
  for (double m : s.model().masses()) mass += m;
  return mass;
}

simulation::PinParams pinBox(const Vec3& min, const Vec3& max) {
  simulation::PinParams pin;
  pin.region.min = min;
  pin.region.max = max;
  return pin;
}

simulation::SceneParams staticSheet() {
  simulation::SceneParams p = hangingSheet();
  p.integrator.type = solve::IntegratorType::kStatic;
  return p;
}

// Imbalance of an equilibrium beside the weight: the tolerance of the solver.
constexpr double kBalance = 1e-4;

TEST(PinReactions, TwoEdgesBearTheWeightAndPullAtEachOther) {
  simulation::SceneParams p = staticSheet();
  p.pins = {pinBox(Vec3(-0.001, -1.0, -1.0), Vec3(0.001, 2.0, 1.0)), pinBox(Vec3(0.999, -1.0, -1.0), Vec3(1.001, 2.0, 1.0))};
  simulation::Simulation s(p, sheetCloud());
  run(s, 1);
  const std::vector<simulation::PinReaction> pins = s.pinReactions();
  ASSERT_EQ(pins.size(), 2u);
  EXPECT_EQ(pins[0].id, "pins[0]");
  EXPECT_EQ(pins[1].id, "pins[1]");
  EXPECT_EQ(pins[0].points + pins[1].points, std::count(s.pinned().begin(), s.pinned().end(), 1));
  const double weight = 9.81 * massOf(s);
  EXPECT_LT((pins[0].force + pins[1].force - Vec3(0.0, 0.0, -weight)).norm(), kBalance * weight);
  EXPECT_GT(pins[0].force.x(), 0.5 * weight);
  EXPECT_LT(pins[1].force.x(), -0.5 * weight);
  // All moments about the origin are in balance, too.
  Vec3 moment = Vec3::Zero();
  for (Index i = 0; i < s.state().size(); ++i) moment += s.state().positions[i].cross(s.model().masses()[i] * p.gravity);
  EXPECT_LT((pins[0].torque + pins[1].torque - moment).norm(), kBalance * weight);
}

TEST(PinReactions, PointsPinnedByACommandAreARegionOfTheirOwnUntilTheyAreFree) {
  simulation::Simulation s(staticSheet(), sheetCloud());
  EXPECT_EQ(s.pinReactions().size(), 1u);
  geometry::Region corner;
  corner.min = Vec3(0.9, -1.0, -1.0);
  corner.max = Vec3(1.1, 2.0, 1.0);
  const Index held = s.pin(corner);
  ASSERT_GT(held, 0);
  ASSERT_EQ(s.pinReactions().size(), 2u);
  EXPECT_EQ(s.pinReactions()[1].id, simulation::kOtherPins);
  EXPECT_EQ(s.pinReactions()[1].points, held);
  s.unpin(corner);
  EXPECT_EQ(s.pinReactions().size(), 1u);
}

TEST(Contacts, AreWhatTheToolFeelsPointByPoint) {
  simulation::SceneParams p = hangingSheet();
  p.material.damping = 5.0;
  tool::ToolParams idle, ball;
  idle.id = "idle";
  idle.mode = tool::Mode::kMove;
  idle.path = {{0.0, Vec3(5.0, 0.0, 0.0)}};
  ball.id = "ball";
  ball.shape.radius = 0.3;
  ball.friction = 0.4;
  ball.path = {{0.0, Vec3(0.5, 0.1, -0.35)}, {1.0, Vec3(0.4, 0.1, -0.25)}};
  p.tools = {idle, ball};
  simulation::Simulation s(p, sheetCloud());
  run(s, 60);
  const std::vector<simulation::Contact> contacts = s.contacts();
  const std::vector<simulation::ToolReaction> reactions = s.toolReactions();
  ASSERT_GT(contacts.size(), 2u);
  EXPECT_EQ(static_cast<Index>(contacts.size()), reactions[1].contacts);
  Vec3 sum = Vec3::Zero();
  for (const simulation::Contact& c : contacts) {
    EXPECT_EQ(c.tool, 1);
    EXPECT_LT((c.position - s.state().positions[c.point]).norm(), 0.12);  // the nearest simulation point
    EXPECT_GE(c.force.dot(c.normal), -1e-15 * c.force.norm());            // friction is across the normal but for rounding
    EXPECT_GT(c.depth, 0.0);
    EXPECT_LE(c.depth, reactions[1].penetration);
    sum += c.force;
  }
  EXPECT_LT((sum + reactions[1].force).norm(), 1e-12 * sum.norm());
}

TEST(Contacts, TheStatisticsTellThatToolsTookTimeWhereThereAreAny) {
  simulation::SceneParams p = hangingSheet();
  simulation::Simulation s(p, sheetCloud());
  run(s, 2);
  EXPECT_EQ(s.statistics().time_contact, 0.0);
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.1;
  ball.path.push_back({0.0, Vec3(0.5, 0.0, -0.1), Vec4(0.0, 0.0, 0.0, 1.0)});
  s.setTool(ball);
  run(s, 2);
  EXPECT_GT(s.statistics().time_contact, 0.0);
  EXPECT_LT(s.statistics().time_contact, s.statistics().time_total);
}

TEST(Reactions, SurfaceToolsAndPinsBalanceAtRest) {
  // Newton's third law: the wrenches of pins and tools sum to the weight.
  simulation::SceneParams p = staticSheet();
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.3;
  ball.path = {{0.0, Vec3(0.15, 0.0, -0.45)}};
  p.tools = {ball};
  simulation::Simulation s(p, sheetCloud());
  run(s, 3);
  const simulation::ToolReaction tool = s.toolReactions()[0];
  ASSERT_GT(tool.contacts, 0);
  const double weight = 9.81 * massOf(s);
  EXPECT_LT((s.pinReactions()[0].force + tool.force - Vec3(0.0, 0.0, -weight)).norm(), kBalance * weight);
}

}  // namespace
}  // namespace deformable_surface::test
