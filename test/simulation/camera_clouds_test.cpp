// Clouds of depth cameras, from the frame to the surface that comes out.
#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "support/camera_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;

CameraFrame take(const CameraScene& scene, double noise, double flying = 0.0, double missing = 0.05) {
  DepthCamera camera;
  camera.width = 120;
  camera.height = 90;
  camera.noise = noise;
  camera.quantum = noise > 0.0 ? 0.125 : 0.0;
  camera.flying = flying;
  camera.missing = missing;
  return takeFrame(camera, scene.sheets);
}

SceneParams makeScene(Index target) {
  SceneParams scene;
  scene.material.thickness = 0.003;
  scene.simplification.target_points = target;
  scene.gravity.setZero();
  scene.accuracy.estimate = false;
  scene.integrator.type = solve::IntegratorType::kStatic;
  return scene;
}

// Pulled at the middle, held at the left.
Points pull(const cloud::PointCloud& cloud, const OrAuto<double>& noise) {
  SceneParams scene = makeScene(300);
  scene.input.noise = noise;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, 0.0);
  pin.region.max = Vec3(-0.08, 1.0, 2.0);
  scene.pins = {pin};
  simulation::ForceParams force;
  force.id = "pull";
  force.point = Vec3(0.05, 0.0, 1.0);
  force.force = Vec3(0.0, 0.0, -0.05);
  force.radius = 0.03;
  scene.forces = {force};
  simulation::Simulation simulation(scene, cloud);
  EXPECT_TRUE(simulation.step().ok);
  Points moved = simulation.surface(false).positions;
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= cloud.positions[i];
  return moved;
}

TEST(CameraClouds, GiveTheNumberOfPointsThatIsAskedFor) {
  for (const CameraScene& scene : {makeTowel(1.0, 30.0), makeGarment(1.0)}) {
    const CameraFrame frame = take(scene, 0.2, 0.5);
    for (const Index target : {100, 1500}) {
      const simulation::RestSurface s = simulation::buildRestSurface(makeScene(target), frame.cloud);
      EXPECT_NEAR(static_cast<double>(s.points.size()), target, 0.05 * target) << scene.name;
    }
  }
}

TEST(CameraClouds, AtRestComeOutAsTheyCameIn) {
  const CameraFrame frame = take(makeFoldedTowel(1.0, 0.02), 0.1);
  simulation::Simulation simulation(makeScene(300), frame.cloud);
  const simulation::Surface& surface = simulation.surface(true);
  ASSERT_EQ(surface.positions.size(), frame.cloud.positions.size());
  Index holes = 0;
  for (Index p = 0; p < frame.size(); ++p) {
    if (!frame.isSeen(p)) {
      ++holes;
      EXPECT_TRUE(std::isnan(surface.positions[p].x()));
      continue;
    }
    EXPECT_LT((surface.positions[p] - frame.cloud.positions[p]).norm(), 1e-9);
    EXPECT_LT(surface.displacement[p], 1e-9f);
  }
  EXPECT_GT(holes, 100);
}

TEST(CameraClouds, MoveAsTheTrueSurfaceDoes) {
  const CameraFrame frame = take(makeTowel(1.0, 0.0), 0.1);
  const Points truth = pull(frame.clean, {}), moved = pull(frame.cloud, {}), as_seen = pull(frame.cloud, 0.0);
  const auto measureError = [&](const Points& points) {
    double sum = 0.0, largest = 0.0;
    for (Index p = 0; p < frame.size(); ++p) {
      if (!frame.isSeen(p)) continue;
      sum += (points[p] - truth[p]).squaredNorm() / frame.size();
      largest = std::max(largest, truth[p].norm());
    }
    return std::sqrt(sum) / largest;
  };
  EXPECT_LT(measureError(moved), 0.03);
  EXPECT_GT(measureError(as_seen), 5.0 * measureError(moved));
}

TEST(CameraClouds, HaveNormalsTowardsTheCamera) {
  CameraFrame frame = take(makeTowel(1.0, 0.0), 0.1);
  const simulation::RestSurface s = simulation::buildRestSurface(makeScene(300), frame.cloud);
  for (std::size_t i = 0; i < s.points.size(); ++i) EXPECT_LT(s.normals[i].dot(s.points[i]), 0.0);
}

bool isSaid(const std::vector<std::string>& lines, const std::string& words) {
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

TEST(CameraClouds, AreNoBodiesWhichIsSaid) {
  const CameraFrame frame = take(makeTowel(1.0, 30.0), 0.2);
  SceneParams scene = makeScene(300);
  scene.model = "elastic_solid";
  scene.elastic_solid.fill = false;
  const auto isWarned = [&](const cloud::PointCloud& cloud) {
    return isSaid(simulation::buildRestSurface(scene, cloud).warnings, "image of a surface");
  };
  EXPECT_TRUE(isWarned(frame.cloud));
  scene.input.noise = 0.0;
  EXPECT_FALSE(isWarned(frame.cloud));
}

TEST(CameraClouds, StayWholeWhereHalfOfTheirPixelsAreMissing) {
  const double area = simulation::buildRestSurface(makeScene(300), take(makeTowel(1.0, 20.0), 0.0).cloud).area;
  for (const double missing : {0.3, 0.5, 0.6}) {
    const simulation::RestSurface s =
        simulation::buildRestSurface(makeScene(300), take(makeTowel(1.0, 20.0), 0.1, 0.0, missing).cloud);
    EXPECT_NEAR(s.area, area, 0.1 * area) << missing;
    EXPECT_EQ(s.points.size(), 300u) << missing;
  }
}

TEST(CameraClouds, TellWhichGapsTheyMayJoin) {
  const CameraFrame frame = take(makeTwoSheets(1.0, 0.01), 0.1);
  const std::vector<std::string> notes = simulation::buildRestSurface(makeScene(300), frame.cloud).notes;
  EXPECT_TRUE(isSaid(notes, "links may lead across those below"));
  EXPECT_TRUE(isSaid(notes, "if the points are exact, input.noise 0"));
}

TEST(CameraClouds, TellThatTheirNoiseIsTooMuch) {
  for (const double noise : {0.1, 1.0}) {
    const simulation::RestSurface s = simulation::buildRestSurface(makeScene(300), take(makeTowel(1.5, 20.0), noise).cloud);
    EXPECT_EQ(isSaid(s.warnings, "is too much for windows"), noise == 1.0);
  }
}

TEST(CameraClouds, AreBuiltTheSameByAnyNumberOfThreads) {
  // Without noise, with links between pixels, and with too few of these.
  for (const auto& [noise, missing] : {std::pair{0.0, 0.05}, {0.1, 0.05}, {0.1, 0.5}}) {
    const CameraFrame frame = take(makeGarment(1.0), noise, 0.0, missing);
    setNumThreads(1);
    const simulation::RestSurface one = simulation::buildRestSurface(makeScene(300), frame.cloud);
    for (const int threads : {2, 3}) {
      setNumThreads(threads);
      const simulation::RestSurface some = simulation::buildRestSurface(makeScene(300), frame.cloud);
      EXPECT_EQ(some.dense_neighbors.items, one.dense_neighbors.items) << threads;
      EXPECT_EQ(some.dense.normals, one.dense.normals) << threads;
      EXPECT_EQ(some.dense_index, one.dense_index) << threads;
      EXPECT_EQ(some.rings.ring.items, one.rings.ring.items) << threads;
      EXPECT_EQ(some.area, one.area) << threads;
      EXPECT_EQ(some.notes, one.notes) << threads;
    }
  }
  setNumThreads(0);
}

// Large enough that only every second pixel of every second row is used. As finely sampled as the noise allows.
CameraFrame takeLarge(const CameraScene& scene) {
  DepthCamera camera;
  camera.focal_length = 1400.0;
  camera.noise = 0.1;
  camera.quantum = 0.125;
  return takeFrame(aimAt(scene, camera), scene.sheets);
}

TEST(CameraClouds, ThatAreLargeAreSeenInEverySecondPixel) {
  const CameraFrame frame = takeLarge(makeTowel(1.0, 0.0));
  const SceneParams scene = makeScene(500);
  const simulation::RestSurface s = simulation::buildRestSurface(scene, frame.cloud);
  ASSERT_TRUE(isSaid(s.notes, "every second pixel"));
  EXPECT_NEAR(static_cast<double>(s.points.size()), 500.0, 25.0);
  EXPECT_NEAR(s.area, 0.3 * 0.22, 0.01 * 0.3 * 0.22);
  EXPECT_EQ(s.dense.normals.size(), s.dense.positions.size());
  double sum = 0.0;
  for (const Vec3& normal : s.dense.normals) sum += (normal + Vec3::UnitZ()).squaredNorm();
  EXPECT_LT(std::sqrt(sum / static_cast<double>(s.dense.normals.size())), 0.04);
  EXPECT_EQ(std::count(s.cells.owner.begin(), s.cells.owner.end(), -1), 0);
  for (const int threads : {1, 3}) {
    setNumThreads(threads);
    const simulation::RestSurface other = simulation::buildRestSurface(scene, frame.cloud);
    EXPECT_EQ(other.dense.normals, s.dense.normals) << threads;
    EXPECT_EQ(other.dense_index, s.dense_index) << threads;
    EXPECT_EQ(other.cells.owner, s.cells.owner) << threads;
    EXPECT_EQ(other.area, s.area) << threads;
  }
  setNumThreads(0);
}

TEST(CameraClouds, ThatAreLargeMayHaveTheEyeInPlaceOfHoles) {
  CameraFrame frame = takeLarge(makeTowel(1.0, 0.0));
  for (Vec3& p : frame.cloud.positions)
    if (!p.allFinite()) p.setZero();
  const simulation::RestSurface s = simulation::buildRestSurface(makeScene(500), frame.cloud);
  ASSERT_TRUE(isSaid(s.notes, "every second pixel"));
  for (const Vec3& normal : s.dense.normals) ASSERT_NEAR(normal.norm(), 1.0, 1e-6);
}

TEST(CameraClouds, InMillimetresAreWarnedOf) {
  CameraFrame frame = take(makeTowel(1.0, 0.0), 0.1);
  EXPECT_FALSE(isSaid(simulation::buildRestSurface(makeScene(300), frame.cloud).warnings, "millimetres"));
  for (Vec3& p : frame.cloud.positions) p *= 1000.0;
  EXPECT_TRUE(isSaid(simulation::buildRestSurface(makeScene(300), frame.cloud).warnings, "millimetres"));
}

TEST(CameraClouds, WithCoordinatesOfAMapAreWarnedOf) {
  CameraFrame frame = take(makeTowel(1.0, 0.0), 0.1);
  for (Vec3& p : frame.cloud.positions) p += Vec3(4.5e5, 2e5, 0.0);
  const std::vector<std::string> warnings = simulation::buildRestSurface(makeScene(300), frame.cloud).warnings;
  EXPECT_TRUE(isSaid(warnings, "coordinates of a map"));
  EXPECT_FALSE(isSaid(warnings, "millimetres"));
}

TEST(CameraClouds, ThatAreLargeKeepTheirPartsApart) {
  const CameraFrame frame = takeLarge(makeTwoSheets(1.0, 0.01));
  const simulation::RestSurface s = simulation::buildRestSurface(makeScene(500), frame.cloud);
  ASSERT_TRUE(isSaid(s.notes, "every second pixel"));
  std::vector<Index> sheet(s.dense.positions.size());
  for (Index p = 0; p < frame.size(); ++p)
    if (s.dense.point_of_input[p] >= 0) sheet[s.dense.point_of_input[p]] = frame.sheet[p];
  Index across = 0;
  for (std::size_t i = 0; i < sheet.size(); ++i) across += sheet[s.dense_index[s.cells.owner[i]]] != sheet[i];
  EXPECT_EQ(across, 0);
  for (Index i = 0; i < s.rings.ring.size(); ++i)
    for (const Index* j = s.rings.ring.begin(i); j != s.rings.ring.end(i); ++j)
      EXPECT_EQ(sheet[s.dense_index[i]], sheet[s.dense_index[*j]]);
}

TEST(CameraClouds, ThatAreLargeAreSeenInEveryPixelWhereThatMatters) {
  const CameraFrame frame = takeLarge(makeTowel(1.0, 0.0));
  const auto isHalved = [&](const SceneParams& scene) {
    return isSaid(simulation::buildRestSurface(scene, frame.cloud).notes, "every second pixel");
  };
  EXPECT_FALSE(isHalved(makeScene(3000))) << "many points";
  SceneParams scene = makeScene(500);
  simulation::PinParams pin;
  pin.region.min = Vec3(0.1, 0.0, 0.0);
  pin.region.max = Vec3(0.1015, 0.0015, 2.0);
  scene.pins = {pin};
  EXPECT_FALSE(isHalved(scene)) << "a pin as wide as two pixels";
}

TEST(CameraClouds, TellOfMissingRowsAndWhatJoinsThem) {
  for (const double noise : {0.0, 0.1}) {
    CameraFrame frame = take(makeTowel(1.0, 0.0), noise, 0.0, 0.0);
    const auto build = [&](double min_gap) {
      SceneParams scene = makeScene(300);
      scene.input.min_gap = min_gap;
      return simulation::buildRestSurface(scene, frame.cloud);
    };
    EXPECT_FALSE(isSaid(build(0.0).warnings, "lie beside each other in one surface")) << noise;
    for (Index p = 0; p < frame.size(); ++p)
      if (p / frame.camera.width % 20 == 10) frame.cloud.positions[p].setConstant(std::nan(""));
    EXPECT_TRUE(isSaid(build(0.0).warnings, "5 parts lie beside each other in one surface")) << noise;
    EXPECT_FALSE(isSaid(build(0.004).warnings, "lie beside each other in one surface")) << noise;
  }
}

TEST(CameraClouds, AreNotToldApartBelowTheGapThatIsStated) {
  const CameraFrame frame = take(makeTwoSheets(1.0, 0.003), 0.0);
  const auto countAcross = [&](double min_gap) {
    SceneParams scene = makeScene(300);
    scene.input.min_gap = min_gap;
    const simulation::RestSurface s = simulation::buildRestSurface(scene, frame.cloud);
    std::vector<Index> sheet(s.dense.positions.size());
    for (Index p = 0; p < frame.size(); ++p)
      if (s.dense.point_of_input[p] >= 0) sheet[s.dense.point_of_input[p]] = frame.sheet[p];
    Index across = 0;
    for (Index i = 0; i < s.dense_neighbors.size(); ++i)
      for (const Index* j = s.dense_neighbors.begin(i); j != s.dense_neighbors.end(i); ++j) across += sheet[i] != sheet[*j];
    return across;
  };
  EXPECT_EQ(countAcross(0.0), 0);
  EXPECT_GT(countAcross(0.005), 100);
}

}  // namespace
}  // namespace deformable_surface::test
