// Tools that touch the surface between its simulation points.
#include "../../src/simulation/points_between.h"
#include "clouds.h"
#include "deformable_surface/geometry/polyhedron.h"
#include "repeats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

tool::ToolParams makeTool(const geometry::Solid& shape, const std::vector<std::pair<double, Vec3>>& path) {
  tool::ToolParams tool;
  tool.id = "tool";
  tool.shape = shape;
  for (const auto& [time, place] : path) tool.path.push_back({time, place, Vec4(0.0, 0.0, 0.0, 1.0)});
  return tool;
}

geometry::Solid makeBall(double radius) {
  geometry::Solid solid;
  solid.kind = geometry::Solid::Kind::kSphere;
  solid.radius = radius;
  return solid;
}

// A free sheet without weight.
SceneParams floating() {
  SceneParams p;
  p.gravity.setZero();
  p.material.damping = 2.0;
  p.material.bending_rigidity = 1e-4;
  p.simplification.target_points = 150;
  return p;
}

double deepestOf(Simulation& s, const geometry::Solid& shape, const Vec3& place) {
  double deepest = 0.0;
  for (const Vec3& p : s.surface(false).positions)
    deepest = std::max(deepest, -geometry::findSignedDistance(shape, p - place).distance);
  return deepest;
}

TEST(PointsBetween, ABallThatIsSmallerThanTheSpacingDoesNotSlipThrough) {
  // The simulation points are 8 cm apart; the ball has a radius of 2 cm.
  SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.damping = 5.0;
  const auto meet = [&](Index cloud_points) {
    p.contact.cloud_points = cloud_points;
    // Midway between simulation points.
    p.tools.clear();
    Simulation s(p, sheetCloud(60));
    Vec3 gap = Vec3::Zero();
    double widest = 0.0;
    for (double x = 0.5; x < 0.7; x += 0.005)
      for (double y = -0.1; y < 0.1; y += 0.005) {
        double nearest = 1.0;
        for (const Vec3& q : s.state().positions) nearest = std::min(nearest, (q - Vec3(x, y, q.z())).norm());
        if (nearest > widest) gap = Vec3(x, y, 0.0);
        widest = std::max(widest, nearest);
      }
    EXPECT_GT(widest, 0.03);
    s.setTool(makeTool(makeBall(0.02), {{0.0, gap + Vec3(0.0, 0.0, -0.05)}, {1.0, gap + Vec3(0.0, 0.0, 0.05)}}));
    run(s, 100);
    double highest = 0.0;
    for (const Vec3& q : s.surface(false).positions) highest = std::max(highest, q.z());
    return highest;
  };
  EXPECT_LT(meet(0), 0.005);
  EXPECT_GT(meet(8), 0.06);
}

TEST(PointsBetween, TheFullCloudRestsOnABoxAndNotInIt) {
  geometry::Solid box;
  box.kind = geometry::Solid::Kind::kBox;
  box.size = Vec3(0.4, 0.4, 0.2);
  SceneParams p;
  p.material.damping = 3.0;
  p.material.young_modulus = 1e6;
  p.material.bending_rigidity = 1e-4;
  p.simplification.target_points = 300;
  const auto drape = [&](Index cloud_points) {
    p.contact.cloud_points = cloud_points;
    p.tools = {makeTool(box, {{0.0, Vec3(0.5, 0.0, -0.101)}})};
    Simulation s(p, sheetCloud(60));
    run(s, 150);
    return deepestOf(s, box, Vec3(0.5, 0.0, -0.101));
  };
  const double before = drape(0), after = drape(8);
  EXPECT_GT(before, 0.01);
  EXPECT_LT(after, 0.4 * before);
}

// Boxes, a table's corner and a roof of triangles under a sheet of 3600 points, of which 300 are simulated: 5.8 cm apart. Their
// corners and edges carry much of its weight on few points.
TEST(PointsBetween, TheFullCloudIsNoDeeperThanTwoHundredthsOfTheSpacingAtCornersAndEdges) {
  SceneParams p;
  p.material.damping = 10.0;
  p.material.young_modulus = 1e6;
  p.material.bending_rigidity = 1e-4;
  p.simplification.target_points = 300;
  const double allowed = 0.02 / std::sqrt(300.0);
  geometry::Solid box, roof;
  box.kind = geometry::Solid::Kind::kBox;
  box.size = Vec3(0.4, 0.4, 0.2);
  roof.kind = geometry::Solid::Kind::kMesh;
  const Points corners = {{-0.2, -0.2, -0.3}, {0.2, -0.2, -0.3}, {0.2, 0.2, -0.3},
                          {-0.2, 0.2, -0.3},  {0.0, -0.2, 0.0},  {0.0, 0.2, 0.0}};
  roof.mesh = std::make_shared<geometry::Polyhedron>(
      corners,
      std::vector<std::array<Index, 3>>{{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {2, 3, 5}, {1, 2, 5}, {1, 5, 4}, {3, 0, 4}, {3, 4, 5}});
  const struct {
    const char* name;
    geometry::Solid shape;
    Vec3 place;
  } cases[] = {
      {"box", box, Vec3(0.5, 0.0, -0.101)}, {"corner", box, Vec3(0.7, 0.2, -0.101)}, {"roof", roof, Vec3(0.5, 0.0, -0.001)}};
  for (const auto& under : cases) {
    const auto drape = [&](solve::IntegratorType type, int steps) {
      p.integrator.type = type;
      tool::ToolParams tool = makeTool(under.shape, {{0.0, under.place}});
      tool.friction = 0.3;
      p.tools = {tool};
      Simulation s(p, sheetCloud(60));
      run(s, steps);
      return deepestOf(s, under.shape, under.place);
    };
    EXPECT_LT(drape(solve::IntegratorType::kVerlet, 300), allowed) << under.name;
  }
}

TEST(PointsBetween, AreAtMostSoManyInACellAndNeverSimulationPoints) {
  SceneParams p = floating();
  const cloud::PointCloud cloud = sheetCloud(40);
  const simulation::RestSurface rest = simulation::buildRestSurface(p, cloud);
  for (const Index most : {1, 5, 64}) {
    p.contact.cloud_points = most;
    const auto between = simulation::choosePointsBetween(p, rest.dense, rest, false);
    ASSERT_TRUE(between);
    Index largest = 0;
    for (Index c = 0; c < static_cast<Index>(rest.points.size()); ++c) {
      largest = std::max(largest, between->end(c) - between->begin(c));
      for (Index s = between->begin(c); s < between->end(c); ++s)
        EXPECT_GT((between->place(s, rest.points) - rest.points[c]).norm(), 0.005);
    }
    EXPECT_LE(largest, most);
    if (most == 64) EXPECT_EQ(between->size() + static_cast<Index>(rest.points.size()), static_cast<Index>(cloud.size()));
  }
  p.contact.cloud_points = 0;
  EXPECT_FALSE(simulation::choosePointsBetween(p, rest.dense, rest, false));
}

TEST(PointsBetween, SpareOnesFollowTheOthersOfACellAndIncludeItsSimulationPoint) {
  SceneParams p = floating();
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(60));
  const auto all = simulation::choosePointsBetween(p, rest.dense, rest, true);
  const auto between = simulation::choosePointsBetween(p, rest.dense, rest, false);
  Index num_spare = 0;
  for (Index c = 0; c < static_cast<Index>(rest.points.size()); ++c) {
    const Index count = between->end(c) - between->begin(c);
    double nearest = 1.0;
    for (Index k = 0; k < all->end(c) - all->begin(c); ++k) {
      const Index s = all->begin(c) + k;
      const Vec3 place = all->place(s, rest.points);
      EXPECT_EQ(all->isSpare(s), k >= count);
      if (k < count) EXPECT_EQ(place, between->place(between->begin(c) + k, rest.points));
      nearest = std::min(nearest, (place - rest.points[c]).norm());
      num_spare += all->isSpare(s);
    }
    EXPECT_LT(nearest, 1e-9);
    EXPECT_LE(all->end(c) - all->begin(c), simulation::kMostPoints + 1);
  }
  EXPECT_GT(num_spare, 3 * static_cast<Index>(rest.points.size()));
}

TEST(PointsBetween, ASurfaceOfWhichEveryPointIsSimulatedHasNone) {
  SceneParams p = floating();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(12));
  EXPECT_FALSE(simulation::choosePointsBetween(p, rest.dense, rest, false));
}

TEST(PointsBetween, WhereEveryPointIsSimulatedThereArePlacesOnTrianglesAQuarterOfASideApart) {
  SceneParams p = floating();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(12));
  const auto places = simulation::choosePlacesOnTriangles(p, rest);
  ASSERT_TRUE(places);
  // A grid of 11 x 11 squares with one diagonal each: three places on each side and in each triangle.
  EXPECT_EQ(places->size(), 3 * (2 * 11 * 12 + 11 * 11) + 3 * 2 * 11 * 11);
  for (Index s = 0; s < places->size(); ++s) {
    EXPECT_TRUE(places->isSpare(s));
    const Vec3 place = places->place(s, rest.points);
    for (Index t = 0; t < s; ++t) ASSERT_GT((places->place(t, rest.points) - place).norm(), 0.15 / 11.0);
  }
  p.contact.cloud_points = 0;
  EXPECT_FALSE(simulation::choosePlacesOnTriangles(p, rest));
}

TEST(PointsBetween, CellsOfFewPointsHavePlacesOnTrianglesToo) {
  SceneParams p = floating();
  p.simplification.target_points = 400;  // of 1600: three in a cell
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(40));
  const auto between = simulation::choosePointsBetween(p, rest.dense, rest, true);
  Index num_places = 0;
  for (Index s = 0; s < between->size(); ++s) {
    num_places += between->isPlace(s);
    EXPECT_NEAR(between->place(s, rest.points).z(), 0.0, 1e-6);
  }
  EXPECT_GT(num_places, 4000);
  EXPECT_TRUE(between->isSpare(between->beginSpare(0)));
}

TEST(PointsBetween, WhereEveryPointIsSimulatedASmallBallLiftsTheSheet) {
  SceneParams p = floating();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.accuracy.estimate = false;
  // The points are 9 cm apart. The ball comes up in the middle of a square, or of a side.
  const double spacing = 1.0 / 11.0;
  for (const double across : {0.0, 0.5 * spacing}) {
    const Vec3 gap(0.5, across, 0.0);
    const auto meet = [&](Index cloud_points) {
      p.contact.cloud_points = cloud_points;
      Simulation s(p, sheetCloud(12));
      s.setTool(makeTool(makeBall(0.02), {{0.0, gap + Vec3(0.0, 0.0, -0.05)}, {1.0, gap + Vec3(0.0, 0.0, 0.05)}}));
      run(s, 100);
      double highest = 0.0;
      for (const Vec3& q : s.state().positions) highest = std::max(highest, q.z());
      return highest;
    };
    EXPECT_LT(meet(0), 1e-6) << across;
    EXPECT_GT(meet(8), 0.05) << across;
  }
}

TEST(PointsBetween, PlacesOnTrianglesWithACutSideAreSevered) {
  SceneParams p = floating();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(12));
  const auto places = simulation::choosePlacesOnTriangles(p, rest);
  auto links = rest.model->links()->stretchLinks();
  const Index m = static_cast<Index>(rest.points.size());
  const std::vector<char> none = simulation::findSevered(*places, links, m);
  EXPECT_EQ(std::count(none.begin(), none.end(), 1), 0);
  // A cut from one side to the middle.
  const auto isCut = [&](const std::pair<Index, Index>& link) {
    const Vec3 &a = rest.points[link.first], &b = rest.points[link.second];
    return (a.x() < 0.5) != (b.x() < 0.5) && 0.5 * (a.y() + b.y()) < 0.0;
  };
  links.erase(std::remove_if(links.begin(), links.end(), isCut), links.end());
  const std::vector<char> severed = simulation::findSevered(*places, links, m);
  Index num_severed = 0;
  for (Index s = 0; s < places->size(); ++s) {
    std::vector<Index> followed;
    places->visitWeights(s, [&](Index j, double) { followed.push_back(j); });
    bool has_cut_side = false;
    for (const Index a : followed)
      for (const Index b : followed) has_cut_side = has_cut_side || isCut({a, b});
    EXPECT_EQ(severed[s] != 0, has_cut_side) << places->place(s, rest.points).transpose();
    num_severed += severed[s];
  }
  EXPECT_GT(num_severed, 40);
}

TEST(PointsBetween, ThoseThatFollowBothSidesOfACutAreSevered) {
  SceneParams p = floating();
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(40));
  const auto between = simulation::choosePointsBetween(p, rest.dense, rest, false);
  const Index m = static_cast<Index>(rest.points.size());
  auto links = rest.model->links()->stretchLinks();
  const std::vector<char> none = simulation::findSevered(*between, links, m);
  EXPECT_EQ(std::count(none.begin(), none.end(), 1), 0);
  const auto crosses = [&](const std::pair<Index, Index>& link) {
    return (rest.points[link.first].x() < 0.5) != (rest.points[link.second].x() < 0.5);
  };
  links.erase(std::remove_if(links.begin(), links.end(), crosses), links.end());
  const std::vector<char> severed = simulation::findSevered(*between, links, m);
  for (Index s = 0; s < between->size(); ++s) {
    bool left = false, right = false;
    between->visitWeights(s, [&](Index j, double) { (rest.points[j].x() < 0.5 ? left : right) = true; });
    EXPECT_EQ(severed[s] != 0, left && right);
  }
}

TEST(PointsBetween, ForksAndSnapshotsGoOnBitForBit) {
  SceneParams p = hangingSheet();
  tool::ToolParams tool = makeTool(makeBall(0.05), {{0.0, Vec3(0.6, 0.0, 0.2)}, {1.0, Vec3(0.6, 0.1, -0.2)}});
  tool.friction = 0.5;
  p.tools = {tool};
  expectToGoOnBitForBit(p, sheetCloud(50), 60);
}

}  // namespace
}  // namespace deformable_surface::test
