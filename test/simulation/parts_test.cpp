// Surfaces and bodies in several parts: what nothing holds is told, left in place by equilibria, and left out where that is
// asked.
#include "clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

// A sheet of 30 x 30 points, a piece of 8 x 5 and a triangle beside it, and a point far from all.
constexpr Index kSheet = 900, kPiece = 40, kTriangle = 3, kAll = kSheet + kPiece + kTriangle + 1;

cloud::PointCloud debris() {
  Points points = sheetCloud(30).positions;
  for (int i = 0; i < kPiece; ++i) points.emplace_back(2.0 + 0.03 * (i % 8), 0.03 * (i / 8), 0.5);
  for (int i = 0; i < kTriangle; ++i) points.emplace_back(-3.0 + 0.03 * (i % 2), 0.03 * (i / 2), 1.5);
  points.emplace_back(9.0, 9.0, 9.0);
  return asCloud(points);
}

SceneParams hangingDebris(Index simulated = 200) {
  SceneParams p = hangingSheet();
  p.simplification.target_points = simulated;
  return p;
}

bool contains(const std::vector<std::string>& sentences, const std::string& text) {
  return std::any_of(sentences.begin(), sentences.end(), [&](const std::string& s) { return s.find(text) != std::string::npos; });
}

TEST(Parts, TheBuildTellsWhichNothingHolds) {
  for (const Index simulated : {200, 900}) {
    const Simulation s(hangingDebris(simulated), debris());
    EXPECT_TRUE(contains(s.buildWarnings(), "2 of 3 parts of what is simulated held by no pin and no anchor"));
    EXPECT_TRUE(contains(s.buildWarnings(), "(44 points of the cloud)"));
  }
  SceneParams anchored = hangingDebris();
  anchored.anchors.push_back({Vec3(2.1, 0.1, 0.5), Vec3(2.1, 0.1, 0.5), 10.0});
  EXPECT_TRUE(contains(Simulation(anchored, debris()).buildWarnings(), "1 of 3 parts"));
  SceneParams loose = hangingDebris();
  loose.pins.clear();
  const Simulation falling(loose, debris());
  EXPECT_TRUE(falling.buildWarnings().empty());
  EXPECT_TRUE(contains(falling.buildNotes(), "3 of 3 parts"));
  const Simulation whole(hangingDebris(), sheetCloud(30));
  EXPECT_FALSE(contains(whole.buildWarnings(), "parts"));
  EXPECT_FALSE(contains(whole.buildNotes(), "parts"));
}

TEST(Parts, OnlyTheLargestAreKeptWhereThatIsAsked) {
  SceneParams p = hangingDebris();
  Simulation alone(p, sheetCloud(30));
  run(alone, 5);
  for (const Index keep : {1, 2, 3, 9}) {
    p.input.keep_parts = keep;
    Simulation s(p, debris());
    run(s, 5);
    const Points& now = s.surface(false).positions;
    ASSERT_EQ(static_cast<Index>(now.size()), kAll);
    const Index left = kSheet + (keep > 1 ? kPiece : 0) + (keep > 2 ? kTriangle : 0) + (keep > 3 ? 1 : 0);
    for (Index i = 0; i < kAll; ++i) EXPECT_EQ(now[i].allFinite(), i < left) << i << " of " << keep << " parts";
    EXPECT_EQ(contains(s.buildNotes(), "of 4 parts of the cloud are left out"), keep < 4);
    if (keep == 1) {
      EXPECT_EQ(s.stateHash(), alone.stateHash());
      EXPECT_TRUE(s.buildWarnings().empty());
    }
  }
}

TEST(Parts, OfBodiesAreKeptOrLeftOutToo) {
  Points points;
  for (int piece = 0; piece < 2; ++piece)
    for (int i = 0; i < (piece == 0 ? 8 : 4); ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) points.emplace_back(0.1 * i + 3.0 * piece, 0.1 * j, 0.1 * k);
  SceneParams p;
  p.model = simulation::ModelKind::kElasticSolid;
  p.accuracy.estimate = false;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.input.keep_parts = 1;
  Simulation s(p, asCloud(points));
  EXPECT_EQ(s.state().size(), 128);
  const Points& now = s.surface(false).positions;
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(now[i].allFinite(), i < 128) << i;
}

TEST(Parts, AnEquilibriumLeavesInPlaceWhatNothingHoldsAndSaysSoOnce) {
  for (const Index simulated : {200, 900})
    for (const bool has_estimate : {false, true}) {
      SceneParams p = hangingDebris(simulated);
      p.integrator.type = solve::IntegratorType::kStatic;
      p.accuracy.estimate = has_estimate;
      Simulation s(p, debris());
      const Points rest = s.state().positions;
      const simulation::StepOutcome first = s.step();
      ASSERT_TRUE(first.ok) << first.problem;
      EXPECT_NE(first.notice.find("nothing holds 2 parts"), std::string::npos) << first.notice;
      EXPECT_EQ(s.step().notice, "");
      double sag = 0.0;
      for (std::size_t i = 0; i < rest.size(); ++i) {
        const double moved = (s.state().positions[i] - rest[i]).norm();
        if (std::abs(rest[i].x()) < 1.5) {
          sag = std::max(sag, moved);
        } else {
          EXPECT_EQ(moved, 0.0);
        }
      }
      EXPECT_GT(sag, 0.01);
      EXPECT_LT(sag, 2.0);
      s.reset();
      EXPECT_NE(s.step().notice.find("nothing holds 2 parts"), std::string::npos);
    }
}

TEST(Parts, AToolHoldsOnlyWhatItIsInTheWayOf) {
  tool::ToolParams ball, floor;
  ball.id = "ball";
  ball.shape.radius = 0.1;
  ball.path = {{0.0, Vec3(5.0, 5.0, 5.0)}};
  floor.id = "floor";
  floor.shape.kind = geometry::Solid::Kind::kPlane;
  floor.path = {{0.0, Vec3(0.0, 0.0, -3.0)}};
  SceneParams p = hangingDebris();
  p.integrator.type = solve::IntegratorType::kStatic;
  p.tools = {ball};
  Simulation beside(p, debris());
  const simulation::StepOutcome left = beside.step();
  ASSERT_TRUE(left.ok) << left.problem;
  EXPECT_NE(left.notice.find("nothing holds 2 parts"), std::string::npos) << left.notice;
  // What falls onto a floor finds an equilibrium there.
  p.tools = {floor};
  Simulation above(p, debris());
  EXPECT_EQ(above.step().notice.find("nothing holds"), std::string::npos);
  // In the way of the piece alone.
  p.tools = {ball};
  p.tools[0].shape.radius = 0.3;
  p.tools[0].path = {{0.0, Vec3(2.1, 0.1, -0.5)}};
  Simulation below(p, debris());
  EXPECT_NE(below.step().notice.find("nothing holds 1 part"), std::string::npos);
}

TEST(Parts, AnEquilibriumIsRefusedWhereNothingHoldsAnyOfThem) {
  SceneParams p = hangingDebris();
  p.pins.clear();
  p.integrator.type = solve::IntegratorType::kStatic;
  Simulation s(p, debris());
  const simulation::StepOutcome outcome = s.step();
  EXPECT_FALSE(outcome.ok);
  EXPECT_NE(outcome.problem.find("nothing holds the surface"), std::string::npos) << outcome.problem;
}

TEST(Parts, WithoutLoadsNothingHasToHoldThem) {
  SceneParams p = hangingDebris();
  p.gravity.setZero();
  p.integrator.type = solve::IntegratorType::kStatic;
  Simulation s(p, debris());
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(outcome.ok) << outcome.problem;
  EXPECT_EQ(outcome.notice, "");
}

}  // namespace
}  // namespace deformable_surface::test
