// Steps from a cloud to a rest surface that surfaces and bodies share: points that pins keep, clamping pins, and refused scenes.
#include "../../src/simulation/rest_parts.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <limits>

namespace deformable_surface::test {
namespace {

using simulation::RestSurface;
using simulation::SceneParams;

TEST(RestParts, CleanInputNeedsThreePointsAndCountsWhatItLeavesOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(simulation::cleanInput(asCloud({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitX()})), InputError);
  const RestSurface s =
      simulation::cleanInput(asCloud({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitX(), Vec3(nan, 0.0, 0.0), Vec3::UnitY()}));
  EXPECT_EQ(s.dense.positions.size(), 3u);
  ASSERT_EQ(s.notes.size(), 2u);
  EXPECT_EQ(s.notes[0].substr(0, 31), "1 input points are not finite, ");
  EXPECT_EQ(s.notes[1], "1 input points coincide with others and move with them");
}

// Millimetres apart, at a place of a map: points that single precision makes the same are warned of.
TEST(RestParts, PointsThatSinglePrecisionMakesTheSameAreWarnedOf) {
  for (const bool is_single : {true, false}) {
    Points points;
    for (int i = 0; i < 40; ++i)
      for (int j = 0; j < 40; ++j) {
        const Vec3 p(4.5e5 + 0.0075 * i, 2e5 + 0.0075 * j, 100.0);
        const Eigen::Vector3f stored = p.cast<float>();
        if (is_single)
          points.emplace_back(stored.cast<double>());
        else
          points.push_back(p);
      }
    points.push_back(points.front());
    const RestSurface s = simulation::cleanInput(asCloud(points));
    ASSERT_EQ(s.warnings.size(), 1u);
    EXPECT_NE(s.warnings[0].find(is_single ? "in steps of 0.0312 m; subtract an offset" : "messages and files of points"),
              std::string::npos)
        << s.warnings[0];
  }
}

TEST(RestParts, AShapeOfAPinThatHoldsNoPointIsRefusedInTheSameWordsByAllModels) {
  for (const char* model : {"mass_spring", "oriented_particles", "elastic_solid"}) {
    SceneParams params;
    params.model = model;
    params.pins.emplace_back();
    params.pins[0].region.min = Vec3(-9.0, -9.0, -9.0);
    params.pins[0].region.max = Vec3(-8.0, -8.0, -8.0);
    const std::string problem = problemOf(params, sheetCloud(10));
    EXPECT_EQ(problem.find("pins[0]: the shape holds none of the 100 points at rest, which lie from ("), 0u) << problem;
    EXPECT_NE(problem.find(" m; accepted: a shape that holds at least one"), std::string::npos) << model << problem;
  }
}

TEST(RestParts, OutputsThatAreTooCoarseForTheSpacingAreWarnedOf) {
  const auto findWarnings = [](double offset) {
    Points points;
    for (int i = 0; i < 40; ++i)
      for (int j = 0; j < 10; ++j) points.emplace_back(offset + 0.025 * i, 2.0 * offset + 0.025 * j, 300.0);
    return simulation::cleanInput(asCloud(points)).warnings;
  };
  EXPECT_TRUE(findWarnings(0.0).empty());
  EXPECT_TRUE(findWarnings(1e4).empty());  // steps of 0.00195 m
  const std::vector<std::string> warnings = findWarnings(1e5);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("coordinates near 2e+05 m go in steps of 0.0156 m, where the spacing of the points is "
                             "0.025 m: subtract an offset from the cloud, or give it in a frame near the surface"),
            std::string::npos)
      << warnings[0];
}

TEST(RestParts, CoordinatesOfMapsAreRefusedWithAdvice) {
  Points points;
  for (int i = 0; i < 5; ++i) points.emplace_back(5e5, 4.6e6 + i, 0.1 * i * i);
  try {
    simulation::cleanInput(asCloud(points));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(
        "cloud: found 0 finite distinct points among 5; accepted: at least 3, within 1e6 m along each axis; 5 points are beyond: "
        "subtract an offset from their coordinates",
        error.what());
  }
}

Points makeGrid() {
  Points points;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) points.emplace_back(0.1 * i, 0.1 * j, 0.0);
  return points;
}

TEST(RestParts, PointsThatAreAlmostTheSameAreMergedOrWarnedOf) {
  Points points = makeGrid();
  points.push_back(points[5] + Vec3(0.0, 1e-9, 0.0));
  RestSurface s = simulation::cleanInput(asCloud(points));
  EXPECT_EQ(s.dense.positions.size(), 100u);
  EXPECT_EQ(s.dense.point_of_input[100], 5);
  ASSERT_EQ(s.notes.size(), 1u);
  EXPECT_EQ(s.notes[0].substr(0, 60), "1 points are at most 1e-09 m from others, where the spacing ");
  s.points = s.dense.positions;
  simulation::warnOfClosePoints(s);
  EXPECT_TRUE(s.warnings.empty());

  s.points.push_back(s.points[7] + Vec3(0.0, 1e-4, 0.0));
  simulation::warnOfClosePoints(s);
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find("2 simulation points are nearer to another"), std::string::npos) << s.warnings[0];
  EXPECT_NE(s.warnings[0].find("0.0001 m apart"), std::string::npos) << s.warnings[0];
}

TEST(RestParts, ColumnsThatAreNoNormalsAreTold) {
  cloud::PointCloud cloud = asCloud(makeGrid());
  EXPECT_TRUE(simulation::cleanInput(cloud).notes.empty());
  cloud.extra_fields.push_back({"column_4", cloud::ScalarType::kFloat64, 1, std::vector<std::uint8_t>(800)});
  ASSERT_EQ(simulation::cleanInput(cloud).notes.size(), 1u);
}

TEST(RestParts, AnchorsAndForcesFarFromThePointsAreTold) {
  SceneParams params;
  params.anchors.push_back({Vec3(10.0, 0.0, 0.0), Vec3(10.0, 0.0, 1.0), 1.0});
  params.anchors.push_back({Vec3(0.52, 0.41, 0.03), Vec3(0.5, 0.4, 1.0), 1.0});
  for (const double x : {1.0, 3.0}) {
    params.forces.emplace_back();
    params.forces.back().point = Vec3(x, 0.0, 0.0);
  }
  params.forces.push_back(params.forces[1]);
  params.forces[2].radius = 0.1;  // told as it begins
  const RestSurface s = simulation::buildRestSurface(params, asCloud(makeGrid()), 3);
  std::string notes;
  for (const std::string& note : s.notes) notes += note + "\n";
  EXPECT_NE(notes.find("anchors[0]: no simulation point lies within 5 spacings, 0.5 m; it acts on the nearest one, 9.1 m"),
            std::string::npos)
      << notes;
  EXPECT_EQ(notes.find("anchors[1]"), std::string::npos) << notes;
  EXPECT_EQ(notes.find("forces[0]"), std::string::npos) << notes;
  EXPECT_NE(notes.find("forces[1]: no simulation point lies within 5 spacings, 0.5 m; it acts on the nearest one, 2"),
            std::string::npos)
      << notes;
  EXPECT_EQ(notes.find("forces[2]"), std::string::npos) << notes;
}

// A grid of 11 x 3 points, one apart, whose first columns are pinned.
struct Pinned {
  explicit Pinned(double edge) {
    for (int i = 0; i <= 10; ++i)
      for (int j = 0; j < 3; ++j) points.emplace_back(i, j, 0.0);
    simulation::PinParams pin;
    pin.region.min = Vec3(-0.1, -0.1, -0.1);
    pin.region.max = Vec3(edge, 2.1, 0.1);
    params.pins.push_back(pin);
  }
  Points points;
  SceneParams params;
};

TEST(RestParts, OfEachPinThreePointsThatAreFarApartAreKept) {
  const Pinned p(4.1);
  const std::vector<Index> kept = simulation::choosePinPoints(p.params, p.points);
  ASSERT_EQ(kept.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(p.params.pins[0].region.contains(p.points[kept[k]])) << k;
    EXPECT_GE((p.points[kept[k]] - p.points[kept[(k + 1) % 3]]).norm(), 2.0) << k;
  }
  const Pinned single(0.1);
  EXPECT_EQ(simulation::choosePinPoints(single.params, single.points), (std::vector<Index>{0, 1, 2}));
}

TEST(RestParts, OfEachGripAtRestThreePointsAreKeptToo) {
  Pinned p(1.1);
  tool::ToolParams grip;
  grip.mode = tool::Mode::kMove;
  grip.shape.kind = geometry::Solid::Kind::kSphere;
  grip.shape.radius = 1.5;
  grip.path = {{0.0, Vec3(9.0, 1.0, 0.0)}, {1.0, Vec3(20.0, 1.0, 0.0)}};
  p.params.tools = {grip};
  const std::vector<Index> kept = simulation::chooseHeldPoints(p.params, p.points);
  ASSERT_EQ(kept.size(), 6u);
  for (int k = 3; k < 6; ++k) EXPECT_LT((p.points[kept[k]] - Vec3(9.0, 1.0, 0.0)).norm(), 1.5);
  // Not of those that begin later, or do something else. One that holds nothing is no error.
  p.params.tools[0].start = 0.1;
  EXPECT_EQ(simulation::chooseHeldPoints(p.params, p.points), simulation::choosePinPoints(p.params, p.points));
  p.params.tools[0] = grip;
  p.params.tools[0].mode = tool::Mode::kSolid;
  EXPECT_EQ(simulation::chooseHeldPoints(p.params, p.points), simulation::choosePinPoints(p.params, p.points));
  p.params.tools[0] = grip;
  p.params.tools[0].path[0].position.z() = 50.0;
  EXPECT_EQ(simulation::chooseHeldPoints(p.params, p.points), simulation::choosePinPoints(p.params, p.points));
}

TEST(RestParts, APinThatHoldsNothingIsRefusedByItsNumber) {
  Pinned p(4.1);
  p.params.pins.push_back(p.params.pins[0]);
  p.params.pins[1].region.min = Vec3(50.0, 0.0, 0.0);
  p.params.pins[1].region.max = Vec3(51.0, 1.0, 1.0);
  try {
    simulation::choosePinPoints(p.params, p.points);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 8), "pins[1]:");
  }
}

TEST(RestParts, RowsSideBySideAreABandAndOneRowIsNone) {
  const Pinned rows(1.1), row(0.1);
  EXPECT_TRUE(simulation::isBandOfRows(rows.points, rows.params.pins[0], 1.0));
  EXPECT_FALSE(simulation::isBandOfRows(row.points, row.params.pins[0], 1.0));
  EXPECT_NEAR(simulation::measureBand(row.points, row.params.pins[0]), 0.0, 1e-9);
  EXPECT_NEAR(simulation::measureBand(rows.points, rows.params.pins[0]), std::sqrt(12.0) * 0.5, 1e-9);
}

TEST(RestParts, PinsMarkTheSimulationPointsInThemAndTheirTurns) {
  Pinned p(1.1);
  RestSurface s;
  s.points = p.points;
  simulation::applyPins(p.params, s);
  EXPECT_EQ(std::count(s.pinned.begin(), s.pinned.end(), 1), 6);
  EXPECT_EQ(std::count(s.pinned_turns.begin(), s.pinned_turns.end(), 1), 0);
  p.params.pins[0].orientation = true;
  simulation::applyPins(p.params, s);
  EXPECT_EQ(s.pinned_turns, s.pinned);
  EXPECT_TRUE(s.warnings.empty());
  p.params.pins[0].region.max = Vec3(20.0, 2.1, 0.1);
  simulation::applyPins(p.params, s);
  EXPECT_EQ(s.warnings, std::vector<std::string>{"pins hold every simulation point: nothing can move"});
}

}  // namespace
}  // namespace deformable_surface::test
