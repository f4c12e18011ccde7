// Rest surfaces of a cloud with a gap, for each choice of neighbourhoods, and of a cloud with rows.
#include "deformable_surface/simulation/rest_surface.h"
#include "clouds.h"
#include "deformable_surface/io/shapes.h"
#include "support/gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::test {
namespace {

using simulation::RestSurface;
using simulation::SceneParams;

// Bars of nine rows. Three hundred simulation points are twice as far from each other as the points of the cloud.
SceneParams makeScene(double gap, const OrAuto<double>& geodesic_exponent) {
  SceneParams scene;
  scene.cloud.shape = simulation::CloudParams::Shape::kTwoBars;
  scene.cloud.points = 1500;
  scene.cloud.size = Vec2(1.0, 0.1);
  scene.cloud.gap = gap;
  scene.cloud.jitter = 0.1;
  scene.simplification.target_points = 300;
  scene.neighbors.geodesic_exponent = geodesic_exponent;
  return scene;
}

RestSurface build(double gap, const OrAuto<double>& geodesic_exponent) {
  const SceneParams scene = makeScene(gap, geodesic_exponent);
  return simulation::buildRestSurface(scene, io::makeShape(scene.cloud));
}

RestSurface buildOfAll(cloud::PointCloud cloud) {
  cloud.width = cloud.size();
  SceneParams scene;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  return simulation::buildRestSurface(scene, cloud);
}

Index countParts(const RestSurface& s) {
  Index components = 0;
  cloud::labelComponents(s.rings, components);
  return components;
}

// Ring links from one bar to the other, beyond the joint.
int countAcross(const RestSurface& s) {
  int count = 0;
  for (Index i = 0; i < s.rings.ring.size(); ++i)
    for (const Index* j = s.rings.ring.begin(i); j != s.rings.ring.end(i); ++j)
      count += s.points[i].x() > 0.3 && s.points[i].z() * s.points[*j].z() < 0.0;
  return count;
}

// Dense points of the lower bar that move when the upper one does, beyond the joint.
int countCarriedAlong(const RestSurface& s) {
  Points moved = s.points;
  for (Vec3& p : moved)
    if (p.z() > 0.0) p.y() += 1.0;
  Points dense;
  s.transfer.apply(moved, dense);
  int count = 0;
  for (std::size_t i = 0; i < dense.size(); ++i) {
    const Vec3& rest = s.dense.positions[i];
    count += rest.x() > 0.3 && rest.z() < 0.0 && (dense[i] - rest).norm() > 1e-6;
  }
  return count;
}

bool hasNoteOfGaps(const RestSurface& s) {
  return std::any_of(s.notes.begin(), s.notes.end(),
                     [](const std::string& note) { return note.find("gap") != std::string::npos; });
}

TEST(RestSurface, AGapNarrowerThanTheSimulationPointsAreApartStaysOpen) {
  for (double gap : {0.02, 0.03}) {
    const RestSurface s = build(gap, {});
    EXPECT_EQ(countAcross(s), 0) << "gap " << gap;
    EXPECT_EQ(countCarriedAlong(s), 0) << "gap " << gap;
    EXPECT_FALSE(hasNoteOfGaps(s)) << "gap " << gap;
  }
}

// Strips of two to six rows, one above the other. Neighbourhoods hold about as many points of the other strip.
TEST(RestSurface, LayersSomeSpacingsApartAreTwoSurfaces) {
  for (const int rows : {2, 3, 4, 6})
    for (const double gap : {1.5, 2.0, 2.5, 3.0, 4.0, 5.0}) {
      std::mt19937 random(static_cast<std::uint32_t>(rows));
      const auto draw = [&] { return 0.003 * (2.0 * random() / 4294967296.0 - 1.0); };
      cloud::PointCloud cloud;
      for (int layer = 0; layer < 2; ++layer)
        for (int i = 0; i < 24; ++i)
          for (int j = 0; j < rows; ++j)
            cloud.positions.emplace_back(0.02 * i + draw(), 0.02 * j + draw(), 0.1 * draw() + 0.02 * gap * layer);
      const RestSurface s = buildOfAll(cloud);
      EXPECT_FALSE(s.is_thick) << rows << ' ' << gap;
      EXPECT_EQ(countParts(s), 2) << rows << ' ' << gap;
    }
}

// Planes across the layers hold about as many points as the layers do.
TEST(RestSurface, StackedLayersASpacingApartAreAsManySurfaces) {
  for (const int layers : {3, 5})
    for (const double gap : {1.0, 1.2, 1.4})
      for (const double jitter : {0.0, 0.3}) {
        std::mt19937 random(static_cast<std::uint32_t>(layers));
        const auto draw = [&] { return jitter * (random() / 2147483648.0 - 1.0); };
        cloud::PointCloud cloud;
        for (int k = 0; k < layers; ++k)
          for (int i = 0; i < 16; ++i)
            for (int j = 0; j < 16; ++j) {
              const double x = i + draw(), y = j + draw();
              cloud.positions.emplace_back(0.02 * x, 0.02 * y, 0.02 * gap * k);
            }
        const RestSurface s = buildOfAll(cloud);
        EXPECT_EQ(countParts(s), layers) << gap << ' ' << jitter;
      }
}

// Leaves beside each other of a sheet that is creased at every sixth row. Points above and below others lie on the same surface.
TEST(RestSurface, AnAccordionKeepsItsPoints) {
  for (const double turn : {100.0, 120.0, 140.0}) {
    const double slope = 0.5 * turn * M_PI / 180.0;
    cloud::PointCloud cloud;
    for (int i = 0; i < 36; ++i)
      for (int j = 0; j < 16; ++j) {
        const int along = i % 12 < 6 ? i % 12 : 12 - i % 12;
        cloud.positions.emplace_back(0.02 * i * std::cos(slope), 0.02 * j, 0.02 * along * std::sin(slope));
      }
    const RestSurface s = buildOfAll(cloud);
    EXPECT_EQ(countParts(s), 1) << turn;
    EXPECT_EQ(s.points.size(), cloud.positions.size()) << turn;
  }
}

// The faces of boxes of 12 x 10 spacings. Upper and lower face are as near each other as layers are, and joined by the rim.
TEST(RestSurface, AThinClosedBodyStaysWhole) {
  for (const int thick : {2, 3}) {
    cloud::PointCloud cloud;
    for (int i = 0; i <= 12; ++i)
      for (int j = 0; j <= 10; ++j)
        for (int k = 0; k <= thick; ++k)
          if (i % 12 == 0 || j % 10 == 0 || k % thick == 0) cloud.positions.emplace_back(0.02 * i, 0.02 * j, 0.02 * k);
    const RestSurface s = buildOfAll(cloud);
    EXPECT_EQ(countParts(s), 1) << thick;
    EXPECT_EQ(s.points.size(), cloud.positions.size()) << thick;
  }
}

TEST(RestSurface, EuclideanNeighbourhoodsBridgeIt) {
  const RestSurface s = build(0.02, 1.0);
  EXPECT_GT(countAcross(s), 50);
  EXPECT_GT(countCarriedAlong(s), 50);
}

TEST(RestSurface, CoarserCopiesKeepTheGapOpen) {
  const SceneParams scene = makeScene(0.02, {});
  const RestSurface s = simulation::buildRestSurface(scene, io::makeShape(scene.cloud), 100);
  EXPECT_EQ(countAcross(simulation::buildCoarser(scene, s, 100)), 0);
}

TEST(RestSurface, AGapThatTheSamplingHardlyResolvesIsNoted) {
  // 1.4 spacings.
  EXPECT_TRUE(hasNoteOfGaps(build(0.0175, {})));
}

TEST(RestSurface, TellsWhatSticksTogetherAcrossAGap) {
  const auto tells = [](double along) {
    const Gapped legs = makeLegs(2.0, along, 0.2, 0.0);
    cloud::PointCloud cloud;
    cloud.positions = legs.positions;
    cloud.normals = legs.normals;
    cloud.width = static_cast<std::uint32_t>(legs.positions.size());
    const std::vector<std::string> warnings = simulation::buildRestSurface(SceneParams(), cloud).warnings;
    return std::any_of(warnings.begin(), warnings.end(),
                       [](const std::string& told) { return told.find("its sides stick together") != std::string::npos; });
  };
  EXPECT_TRUE(tells(3.0));
  EXPECT_FALSE(tells(1.0));
}

TEST(RestSurface, TellsOfHolesThatItsPointsBridge) {
  constexpr Index kSide = 40;
  const auto isTold = [](double radius, Index points) {
    Points sheet;
    for (const Vec3& p : makeSheet(kSide, kSide, 1.0, 1.0, 0.3).points)
      if ((p - Vec3(0.5, 0.0, 0.0)).norm() > radius) sheet.push_back(p);
    SceneParams params;
    params.simplification.target_points = points;
    const RestSurface s = simulation::buildRestSurface(params, asCloud(sheet));
    return std::any_of(s.notes.begin(), s.notes.end(),
                       [](const std::string& note) { return note.find("rims of holes") != std::string::npos; });
  };
  EXPECT_TRUE(isTold(0.12, 60));
  EXPECT_FALSE(isTold(0.12, 600));
  EXPECT_FALSE(isTold(0.35, 100));
  for (const Index points : {40, 100, 300}) EXPECT_FALSE(isTold(0.0, points)) << points;
}

TEST(RestSurface, TellsOfGivenNormalsThatItTurns) {
  cloud::PointCloud cloud = asCloud(makeSheet(20, 20, 1.0, 1.0, 0.2).points);
  const auto tells = [&](const std::string& words) {
    const RestSurface s = simulation::buildRestSurface(SceneParams(), cloud);
    return std::any_of(s.notes.begin(), s.notes.end(),
                       [&](const std::string& note) { return note.find(words) != std::string::npos; });
  };
  cloud.normals.assign(cloud.positions.size(), -Vec3::UnitZ());
  EXPECT_TRUE(tells("normals point as the input's do"));
  EXPECT_FALSE(tells("turned"));
  for (const Index i : {44, 130, 255}) cloud.normals[i] = Vec3::UnitZ();
  EXPECT_TRUE(tells("3 given normals point to the other side of the surface than most, and were turned"));
}

// By one rule for all models.
TEST(RestSurface, LengthsThatLookLikeMillimetresAreWarnedOf) {
  for (const char* model : {"mass_spring", "oriented_particles", "elastic_solid"}) {
    for (const double scale : {0.02, 20.0, 60.0}) {
      Points points = makeSheet(14, 14, scale, scale, 0.2).points;
      if (std::string(model) == "elastic_solid")
        for (int layer = 1; layer < 5; ++layer)
          for (Index i = 0; i < 14 * 14; ++i) points.push_back(points[i] + layer * scale / 14.0 * Vec3::UnitZ());
      SceneParams params;
      params.model = model;
      const RestSurface s = simulation::buildRestSurface(params, asCloud(points));
      const bool is_told = std::any_of(s.warnings.begin(), s.warnings.end(), [](const std::string& w) {
        return w.find("m long: lengths are in metres, and these look like millimetres") != std::string::npos;
      });
      EXPECT_EQ(is_told, scale > 50.0) << model << " of " << scale << " m";
    }
  }
}

TEST(RestSurface, TellsThatAPathTurnsByHalfATurnAtOnce) {
  const auto listNotes = [](const std::vector<tool::WaypointParams>& path) {
    SceneParams params;
    params.tools.emplace_back();
    params.tools[0].id = "hand";
    params.tools[0].path = path;
    params.pins.emplace_back();
    params.pins[0].region.min = Vec3(-0.001, -1.0, -1.0);
    params.pins[0].region.max = Vec3(0.001, 1.0, 1.0);
    params.pins[0].path = path;
    std::string all;
    for (const std::string& note : simulation::buildRestSurface(params, asCloud(makeSheet(12, 12, 1.0, 1.0, 0.2).points)).notes)
      if (note.find("180 degrees") != std::string::npos) all += note + "\n";
    return all;
  };
  const Vec4 none(0.0, 0.0, 0.0, 1.0), half(0.7071, 0.7071, 0.0, 0.0), nearly(std::sin(1.56), 0.0, 0.0, std::cos(1.56));
  const std::string told =
      " from 0.5 to 2.0 s the path turns by 180 degrees, and both ways round are as short: a waypoint between "
      "tells which\n";
  EXPECT_EQ(listNotes({{0.0, Vec3::Zero(), none}, {0.5, Vec3::Zero(), none}, {2.0, Vec3::Zero(), half}}),
            "tool 'hand':" + told + "pins[0]:" + told);
  EXPECT_EQ(listNotes({{0.0, Vec3::Zero(), none}, {2.0, Vec3::Zero(), nearly}}), "");
}

TEST(RestSurface, TellsThatPointsLieInRows) {
  const auto warns = [](double apart) {
    const Points points = makeSheet(40, 30, 39.0, 29.0 * apart, 0.1).points;
    const simulation::RestSurface s = simulation::buildRestSurface(simulation::SceneParams(), asCloud(points));
    return std::any_of(s.warnings.begin(), s.warnings.end(),
                       [](const std::string& w) { return w.find("the points lie in rows") == 0; });
  };
  EXPECT_FALSE(warns(1.0));
  EXPECT_TRUE(warns(3.0));
}

// Also of a strip of two rows, which covers less than its points' distances tell.
TEST(RestSurface, TellsOfItsAreaAndThatRowsFarApartLoseIt) {
  const auto build = [](Index along, Index across, double apart) {
    const Points points = makeSheet(along, across, along - 1.0, (across - 1.0) * apart).points;
    return simulation::buildRestSurface(simulation::SceneParams(), asCloud(points));
  };
  const auto warns = [](const simulation::RestSurface& s) {
    return std::any_of(s.warnings.begin(), s.warnings.end(),
                       [](const std::string& w) { return w.find("points have next to no triangles") != std::string::npos; });
  };
  const simulation::RestSurface even = build(21, 16, 1.0);
  EXPECT_EQ(std::count(even.notes.begin(), even.notes.end(), "area 300 m^2, mass 300 kg"), 1);
  for (const simulation::RestSurface& s : {build(21, 16, 2.0), build(40, 2, 1.0)}) EXPECT_FALSE(warns(s));
  EXPECT_FALSE(warns(even));
  EXPECT_TRUE(warns(build(41, 31, 4.0)));
}

TEST(RestSurface, TellsThatPointsHaveOthersNearlyAtTheSamePlace) {
  for (const double apart : {0.02, 0.1}) {
    Points points = makeSheet(20, 20, 19.0, 19.0).points;
    for (Index i = 0; i < 400; ++i) points.push_back(points[i] + apart * Vec3::UnitZ());
    const simulation::RestSurface s = simulation::buildRestSurface(simulation::SceneParams(), asCloud(points));
    ASSERT_EQ(s.warnings.size(), 1u) << apart;
    const std::string found = apart < 0.1 ? "0.02" : "0.1";
    EXPECT_EQ(s.warnings[0].find("most points have others nearly at the same place, at about " + found + " of the distance"), 0u)
        << s.warnings[0];
  }
}

}  // namespace
}  // namespace deformable_surface::test
