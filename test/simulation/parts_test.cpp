// Surfaces and bodies in several parts. Parts that nothing holds are reported, stay in place in equilibria, and are left out on
// request.
#include "clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::PinParams;
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
    EXPECT_TRUE(contains(s.buildWarnings(), "no pin, anchor or tool holds 2 of 3 parts of what is simulated"));
    EXPECT_TRUE(contains(s.buildWarnings(), "(44 points of the cloud)"));
  }
  SceneParams anchored = hangingDebris();
  anchored.anchors.push_back({Vec3(2.1, 0.1, 0.5), Vec3(2.1, 0.1, 0.5), 10.0});
  EXPECT_TRUE(contains(Simulation(anchored, debris()).buildWarnings(), "1 of 3 parts"));
  SceneParams loose = hangingDebris();
  loose.pins.clear();
  const Simulation falling(loose, debris());
  EXPECT_TRUE(falling.buildWarnings().empty());
  EXPECT_TRUE(contains(falling.buildNotes(), "no pin, anchor or tool holds what is simulated, 3 parts of "));
  loose.input.largest_parts = 1;
  EXPECT_TRUE(contains(Simulation(loose, debris()).buildNotes(), "holds what is simulated: it moves freely"));
  const Simulation whole(hangingDebris(), sheetCloud(30));
  EXPECT_FALSE(contains(whole.buildWarnings(), "parts"));
  EXPECT_FALSE(contains(whole.buildNotes(), "parts"));
}

tool::ToolParams toolAt(const Vec3& place, tool::Mode mode) {
  tool::ToolParams tool;
  tool.id = "tool";
  tool.mode = mode;
  tool.shape.radius = 0.3;
  tool.path = {{0.0, place}};
  return tool;
}

TEST(Parts, AToolHoldsWhatItGripsOrHoldsUpFromTheBeginning) {
  const auto isHeld = [](const tool::ToolParams& tool, const Vec3& gravity) {
    SceneParams p = hangingDebris();
    p.accuracy.estimate = false;
    p.gravity = gravity;
    p.tools = {tool};
    return contains(Simulation(p, debris()).buildWarnings(), "1 of 3 parts");
  };
  const Vec3 down(0.0, 0.0, -9.81), none = Vec3::Zero(), inside(2.1, 0.1, 0.5), below(2.1, 0.1, -0.5);
  EXPECT_TRUE(isHeld(toolAt(below, tool::Mode::kSolid), down));
  EXPECT_FALSE(isHeld(toolAt(below, tool::Mode::kSolid), none));
  EXPECT_FALSE(isHeld(toolAt(below, tool::Mode::kSolid), -down));
  EXPECT_FALSE(isHeld(toolAt(below, tool::Mode::kMove), down));
  EXPECT_TRUE(isHeld(toolAt(inside, tool::Mode::kMove), down));
  EXPECT_FALSE(isHeld(toolAt(inside, tool::Mode::kCut), down));
  tool::ToolParams later = toolAt(inside, tool::Mode::kMove);
  later.start = 1.0;
  EXPECT_FALSE(isHeld(later, down));
  tool::ToolParams magnet = toolAt(below, tool::Mode::kAttract);
  magnet.strength = 1.0;
  magnet.reach = 0.1;
  EXPECT_FALSE(isHeld(magnet, down));
  magnet.reach = 1.0;
  EXPECT_TRUE(isHeld(magnet, down));
}

TEST(Parts, ThatLieOnAToolAreToldWhereOthersAreFrozenOrLeftOut) {
  for (const auto& [treatment, name] : {std::pair(simulation::UnconstrainedParts::kFreeze, "freeze: 2 of 3 parts"),
                                        std::pair(simulation::UnconstrainedParts::kDrop, "drop: 3 of 4 parts")}) {
    SceneParams p = hangingDebris();
    p.accuracy.estimate = false;
    p.input.unconstrained_parts = treatment;
    tool::ToolParams floor = toolAt(Vec3(0.0, 0.0, -1.0), tool::Mode::kSolid);
    floor.id = "floor";
    floor.shape.kind = geometry::Solid::Kind::kPlane;
    p.tools = {floor};
    const Simulation s(p, debris());
    const std::string said = std::string("input.unconstrained_parts ") + name + " count as held by tool 'floor'";
    EXPECT_TRUE(contains(s.buildNotes(), said)) << said;
    p.tools.clear();
    EXPECT_FALSE(contains(Simulation(p, debris()).buildNotes(), "count as held by tool"));
  }
}

TEST(Parts, ThatNothingHoldsStayWhereTheyAreWhereThatIsAsked) {
  for (const Index simulated : {200, 900})
    for (const bool has_estimate : {false, true}) {
      SceneParams p = hangingDebris(simulated);
      p.accuracy.estimate = has_estimate;
      p.input.unconstrained_parts = simulation::UnconstrainedParts::kFreeze;
      Simulation s(p, debris());
      EXPECT_TRUE(s.buildWarnings().empty()) << s.buildWarnings()[0];
      EXPECT_TRUE(contains(s.buildNotes(), "input.unconstrained_parts freeze keeps them"));
      const Points rest = s.state().positions;
      run(s, 20);
      double fallen = 0.0;
      for (Index i = 0; i < s.state().size(); ++i) {
        const bool is_loose = rest[i].x() > 1.5 || rest[i].x() < -1.5;
        if (is_loose) EXPECT_EQ(s.state().positions[i], rest[i]);
        if (is_loose) EXPECT_TRUE(s.pinned()[i]);
        fallen = std::max(fallen, (s.state().positions[i] - rest[i]).norm());
      }
      EXPECT_GT(fallen, 1e-3);
      for (const Vec3& point : s.surface(false).positions) EXPECT_TRUE(point.allFinite());
      // Until they are unpinned, and again after a reset.
      geometry::Region piece;
      piece.kind = geometry::Region::Kind::kSphere;
      piece.center = Vec3(2.1, 0.1, 0.5);
      piece.radius = 0.5;
      EXPECT_GT(s.unpin(piece), 3);
      run(s, 20);
      const auto lowest = [&] {
        double z = 1.0;
        for (const Vec3& at : s.state().positions)
          if (at.x() > 1.5) z = std::min(z, at.z());
        return z;
      };
      EXPECT_LT(lowest(), 0.49);
      s.reset();
      run(s, 20);
      EXPECT_EQ(lowest(), 0.5);
    }
}

TEST(Parts, ThatNothingHoldsAreLeftOutWhereThatIsAsked) {
  for (const Index simulated : {200, 900}) {
    SceneParams p = hangingDebris(simulated);
    Simulation alone(p, sheetCloud(30));
    run(alone, 5);
    p.input.unconstrained_parts = simulation::UnconstrainedParts::kDrop;
    Simulation s(p, debris());
    run(s, 5);
    EXPECT_TRUE(contains(s.buildNotes(), "input.unconstrained_parts drop: 3 of 4 parts of the cloud are left out, 44 points"));
    EXPECT_TRUE(s.buildWarnings().empty());
    EXPECT_EQ(s.stateHash(), alone.stateHash());
    const Points& now = s.surface(false).positions;
    for (Index i = 0; i < kAll; ++i) EXPECT_EQ(now[i].allFinite(), i < kSheet) << i;
  }
}

TEST(Parts, OfAllKindsAreFrozenOrLeftOut) {
  for (const std::string model : {"oriented_particles", "elastic_solid"}) {
    const bool is_body = model == "elastic_solid";
    Points points;
    for (int piece = 0; piece < 2; ++piece)
      for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j)
          for (int k = 0; k < (is_body ? 4 : 1); ++k) points.emplace_back(0.1 * i + 3.0 * piece, 0.1 * j, 0.1 * k);
    const Index half = static_cast<Index>(points.size()) / 2;
    SceneParams p;
    p.model = model;
    p.accuracy.estimate = false;
    p.simplification.method = cloud::SimplificationMethod::kNone;
    PinParams pin;
    pin.region.kind = geometry::Region::Kind::kBox;
    pin.region.min = Vec3(-0.05, -1.0, -1.0);
    pin.region.max = Vec3(0.15, 1.0, 1.0);
    p.pins = {pin};
    p.input.unconstrained_parts = simulation::UnconstrainedParts::kFreeze;
    Simulation frozen(p, asCloud(points));
    EXPECT_TRUE(contains(frozen.buildNotes(), "holds 1 of 2 parts of what is simulated"));
    const Points rest = frozen.state().positions;
    run(frozen, 5);
    double moved = 0.0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const double way = (frozen.state().positions[i] - rest[i]).norm();
      if (rest[i].x() > 1.5)
        EXPECT_EQ(way, 0.0);
      else
        moved = std::max(moved, way);
    }
    EXPECT_GT(moved, 1e-5);
    p.input.unconstrained_parts = simulation::UnconstrainedParts::kDrop;
    Simulation dropped(p, asCloud(points));
    EXPECT_EQ(dropped.state().size(), half);
    const Points& now = dropped.surface(false).positions;
    for (Index i = 0; i < 2 * half; ++i) EXPECT_EQ(now[i].allFinite(), i < half) << i;
  }
}

TEST(Parts, OfWhichNothingIsHeldAreNeitherFrozenNorLeftOut) {
  SceneParams p = hangingDebris();
  p.pins.clear();
  for (const simulation::UnconstrainedParts unconstrained_parts :
       {simulation::UnconstrainedParts::kFreeze, simulation::UnconstrainedParts::kDrop}) {
    p.input.unconstrained_parts = unconstrained_parts;
    EXPECT_THROW(Simulation(p, debris()), InputError);
  }
}

TEST(Parts, OnlyTheLargestAreKeptWhereThatIsAsked) {
  SceneParams p = hangingDebris();
  Simulation alone(p, sheetCloud(30));
  run(alone, 5);
  for (const Index keep : {1, 2, 3, 9}) {
    p.input.largest_parts = keep;
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
  p.model = "elastic_solid";
  p.accuracy.estimate = false;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.input.largest_parts = 1;
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
  // A part that falls onto a floor has an equilibrium there.
  p.tools = {floor};
  Simulation above(p, debris());
  EXPECT_EQ(above.step().notice.find("nothing holds"), std::string::npos);
  // In the path of the small piece only.
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
