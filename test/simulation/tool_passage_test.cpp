// Passages of a ball through two triangles and into a cube, step by step.
#include "../../src/simulation/tool_passage.h"

#include "support/meshes.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::ContactLoad;
using simulation::Passage;

// A square of 2 m in the plane z = height, of two triangles whose normals point up.
Points makeSquare(double height) {
  return {Vec3(-1.0, -1.0, height), Vec3(1.0, -1.0, height), Vec3(1.0, 1.0, height), Vec3(-1.0, 1.0, height)};
}
const std::vector<model::WeightedTriangle> kSquare{{{0, 1, 2}, 1.0}, {{0, 2, 3}, 1.0}};
const std::vector<ContactLoad::Passed> kAllPassed{{0, {}}, {1, {}}, {2, {}}, {3, {}}};

constexpr double kSpacing = 2.0;

// The heights of a ball and of the square before and after a step.
struct Heights {
  double ball_before, ball_after, square_before = 0.0, square_after = 0.0;
};

struct Course {
  double radius;  // m
  bool is_equilibrium = false;
  ContactLoad::Through through{};
  double time = 0.0;
  bool had_passed = false, has_pressed = false;

  Passage step(const Heights& heights, bool has_passed, double duration = 0.01) {
    geometry::Solid ball;
    ball.radius = radius;
    const simulation::AxisPoints from{{Vec3(0.1, -0.2, heights.ball_before)}, 1}, to{{Vec3(0.1, -0.2, heights.ball_after)}, 1};
    const Points before = makeSquare(heights.square_before), after = makeSquare(heights.square_after);
    const std::vector<ContactLoad::Passed> passed = has_passed ? kAllPassed : std::vector<ContactLoad::Passed>();
    const tool::Pose pose{to.places[0], Eigen::Quaterniond::Identity()};
    const simulation::PassageStep step{ball,   pose,       from,        to,       kSquare,        before, after,
                                       passed, had_passed, has_pressed, kSpacing, is_equilibrium, time,   time + duration};
    time += duration;
    had_passed = has_passed;
    return simulation::findPassage(step, through);
  }
};

TEST(ToolPassage, BetweenThePointsATighterToolIsNarrowAndAWiderOneSnaps) {
  EXPECT_EQ(Course{0.1}.step({0.3, -0.3}, false), Passage::kNarrow);
  EXPECT_EQ(Course{1.5}.step({0.3, -0.3}, false), Passage::kSnapped);
  EXPECT_EQ(Course{0.1}.step({0.3, 0.1}, false), Passage::kNone);
}

TEST(ToolPassage, AnEquilibriumBeyondAWideToolAtRestWasSearchedPastIt) {
  EXPECT_EQ((Course{1.5, true}.step({-2.0, -2.0, 0.0, -2.5}, false)), Passage::kSearched);
  // The tool has moved; it was touched before; it is narrow; the surface moves.
  EXPECT_EQ((Course{1.5, true}.step({-2.1, -2.0, 0.0, -2.5}, false)), Passage::kSnapped);
  EXPECT_EQ((Course{2.5, true}.step({-2.0, -2.0, 0.0, -2.5}, false)), Passage::kSnapped);
  EXPECT_EQ((Course{0.1, true}.step({-2.0, -2.0, 0.0, -2.5}, false)), Passage::kNarrow);
  EXPECT_EQ((Course{1.5, false}.step({-2.0, -2.0, 0.0, -2.5}, false)), Passage::kSnapped);
}

TEST(ToolPassage, ASurfaceThatComesBackBeforeTheToolIsNotPassed) {
  Course course{0.1};
  EXPECT_EQ(course.step({0.3, -0.3}, true), Passage::kNone);
  EXPECT_EQ(course.step({-0.3, -0.3, 0.0, -0.1}, true), Passage::kNone);
  EXPECT_EQ(course.step({-0.3, -0.3, -0.1, -0.5}, true), Passage::kNone);
  EXPECT_FALSE(course.through.isAny());
  EXPECT_EQ(course.step({-0.3, -0.3, -0.5, -0.5}, false), Passage::kNone);
}

TEST(ToolPassage, ASurfaceThatIsHeldNoMoreBehindTheToolIsPassed) {
  Course course{0.1};
  EXPECT_EQ(course.step({0.3, -0.3}, true), Passage::kNone);
  EXPECT_TRUE(course.through.isAny());
  EXPECT_EQ(course.step({-0.3, -0.4}, false), Passage::kNarrow);
  EXPECT_FALSE(course.through.isAny());
}

TEST(ToolPassage, ASurfaceThatStaysBehindAThickToolIsPassedAfterAWhile) {
  for (const double radius : {0.1, 1.5}) {
    Course course{radius};
    EXPECT_EQ(course.step({0.3, -0.3}, true), Passage::kNone);
    EXPECT_EQ(course.step({-0.3, -0.3}, true, 0.15), Passage::kNone);
    EXPECT_EQ(course.step({-0.3, -0.3}, true, 0.15), radius > 1.0 ? Passage::kSnapped : Passage::kNone) << radius;
  }
}

TEST(ToolPassage, ATriangleThatPushesTheToolBackIsPassedOnlyAfterAWhile) {
  for (const bool comes_back : {true, false}) {
    Course course{1.5};
    course.has_pressed = true;
    EXPECT_EQ(course.step({0.3, -0.3}, false), Passage::kNone);
    EXPECT_TRUE(course.through.isAny());
    EXPECT_EQ(course.step({-0.3, comes_back ? 0.3 : -0.3}, false, 0.15), Passage::kNone);
    EXPECT_EQ(course.step({-0.3, -0.3}, false, 0.15), comes_back ? Passage::kNone : Passage::kSnapped);
  }
}

TEST(ToolPassage, ANarrowToolInATriangleIsThroughAlthoughPlacesPushItBack) {
  Course course{0.1};
  course.has_pressed = true;
  EXPECT_EQ(course.step({0.3, -0.3}, false), Passage::kNarrow);
}

// Whose plane of entry is at the height of the square.
TEST(ToolPassage, AThinToolIsPassedIfPointsAreFarBehindIt) {
  for (const double way : {0.2, 0.4}) {
    Course course{0.1};
    EXPECT_EQ(course.step({-0.3, 0.3}, true), Passage::kNone);
    EXPECT_EQ(course.step({0.3, 0.3, 0.0, -way}, true, 0.3), way > 0.3 ? Passage::kNarrow : Passage::kNone) << way;
  }
}

TEST(ToolPassage, InEquilibriumASurfaceBehindAThickToolIsPassedAtOnce) {
  EXPECT_EQ((Course{1.5, true}.step({0.3, -0.3}, true)), Passage::kSnapped);
  EXPECT_EQ((Course{0.1, true}.step({0.3, -0.3}, true)), Passage::kNone);
}

TEST(ToolPassage, BesideAnEdgeNothingIsPassedHoweverFastTheToolIs) {
  geometry::Solid ball;
  ball.radius = 0.1;
  const simulation::AxisPoints from{{Vec3(1.02, 0.0, 0.5)}, 1}, to{{Vec3(1.02, 0.0, -0.5)}, 1};
  const Points square = makeSquare(0.0);
  ContactLoad::Through through;
  const tool::Pose pose{to.places[0], Eigen::Quaterniond::Identity()};
  const simulation::PassageStep step{ball,       pose,  from,  to,       kSquare, square, square,
                                     kAllPassed, false, false, kSpacing, true,    0.0,    0.01};
  EXPECT_EQ(simulation::findPassage(step, through), Passage::kNone);
  EXPECT_FALSE(through.isAny());
}

TEST(ToolPassage, IntoABodyIsTheFirstStepAtWhoseEndThePlaceIsInside) {
  const Mesh cube = makeBoxMesh(Vec3(2.0, 2.0, 2.0));
  std::vector<model::WeightedTriangle> triangles;
  for (const auto& t : cube.triangles) triangles.push_back({{t[0], t[1], t[2]}, 1.0});
  geometry::Solid ball;
  ball.radius = 0.1;
  const auto find = [&](double before, double after, bool has_passed, bool is_equilibrium) {
    const simulation::AxisPoints from{{Vec3(0.1, 0.2, before)}, 1}, to{{Vec3(0.1, 0.2, after)}, 1};
    const std::vector<ContactLoad::Passed> passed = has_passed ? kAllPassed : std::vector<ContactLoad::Passed>();
    const tool::Pose pose{to.places[0], Eigen::Quaterniond::Identity()};
    return simulation::findPassageIntoBody({ball, pose, from, to, triangles, cube.vertices, cube.vertices, passed, has_passed,
                                            false, kSpacing, is_equilibrium, 0.0, 0.01});
  };
  EXPECT_EQ(find(1.3, 0.7, false, false), Passage::kIntoBody);
  EXPECT_EQ(find(0.7, 0.6, false, false), Passage::kNone);
  EXPECT_EQ(find(1.3, 1.1, false, false), Passage::kNone);
  EXPECT_EQ(find(1.3, 0.7, true, false), Passage::kNone);  // its points are still pushed back
  EXPECT_EQ(find(1.3, 0.7, true, true), Passage::kIntoBody);
}

}  // namespace
}  // namespace deformable_surface::test
