// Estimates the surface behind the noise of depth cameras, and leaves clouds without noise as they are.
#include "deformable_surface/cloud/sensor_noise.h"

#include "../support/camera_scenes.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::cloud {
namespace {

using test::CameraFrame;
using test::CameraScene;

CameraFrame take(const CameraScene& scene, double noise, double quantum, double missing = 0.05, double flying = 0.0) {
  test::DepthCamera camera;
  camera.width = 160;
  camera.height = 120;
  camera.focal_length = 575.0;
  camera.noise = noise;
  camera.quantum = quantum;
  camera.missing = missing;
  camera.flying = flying;
  return test::takeFrame(camera, scene.sheets);
}

// Root mean square distance from the true places of the pixels.
double measureError(const CameraFrame& frame, const CleanCloud& cloud, const Points& points) {
  double sum = 0.0, count = 0.0;
  for (Index p = 0; p < frame.size(); ++p) {
    const Index i = cloud.point_of_input[p];
    if (i < 0 || frame.flies[p]) continue;
    sum += (points[i] - frame.clean.positions[p]).squaredNorm();
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

// Share of the list entries that the rule refuses.
double findRefusedShare(const Points& points) {
  const Lists neighbors = nearestNeighbors(points, 32);
  SurfaceSides sides;
  sides.normals = estimateNormals(points, neighbors);
  const GeodesicGraph graph = buildGeodesicGraph(points, sides, neighbors, {});
  return static_cast<double>(keepGeodesicNeighbors(graph, points, sides, neighbors).num_refused) / neighbors.items.size();
}

TEST(SensorNoise, OfACameraIsWhatItsDisparitiesHave) {
  for (const double noise : {0.05, 0.1, 0.2}) {
    const CameraFrame frame = take(test::makeTowel(1.0, 20.0), noise, 0.125);
    const SensorNoise found = findSensorNoise(frame.cloud, clean(frame.cloud));
    EXPECT_TRUE(found.is_image);
    EXPECT_NEAR(found.deviation, frame.camera.depthNoise(1.0), 0.1 * frame.camera.depthNoise(1.0)) << noise;
    EXPECT_NEAR(found.spacing, 1.0 / 575.0, 0.05 / 575.0);
  }
}

TEST(SensorNoise, IsTakenFromTheSurfaceAndMakesNoGaps) {
  for (const double tilt : {0.0, 30.0}) {
    const CameraFrame frame = take(test::makeTowel(1.0, tilt), 0.1, 0.125);
    const CleanCloud cloud = clean(frame.cloud);
    const SensorNoise found = findSensorNoise(frame.cloud, cloud);
    ASSERT_EQ(found.surface.size(), cloud.positions.size());
    EXPECT_LT(measureError(frame, cloud, found.surface), 0.3 * measureError(frame, cloud, cloud.positions)) << tilt;
    EXPECT_GT(findRefusedShare(cloud.positions), 0.1) << tilt;
    EXPECT_LT(findRefusedShare(found.surface), 0.002) << tilt;
  }
}

// Share of the pairs of neighbouring pixels of one kind that are linked.
double findLinkedShare(const CameraFrame& frame, const PixelLinks& image, bool across_gaps) {
  double linked = 0.0, count = 0.0;
  for (Index p = 0; p < frame.size(); ++p) {
    for (int d = 0; d < 8; ++d) {
      const Index u = p % image.width + kPixelSteps[d][0], v = p / image.width + kPixelSteps[d][1];
      if (u < 0 || u >= image.width || v < 0 || v >= image.height) continue;
      const Index q = v * image.width + u;
      if (!frame.isSeen(p) || !frame.isSeen(q) || test::areTrueNeighbors(frame, p, q) == across_gaps) continue;
      linked += image.links[p] >> d & 1;
      count += 1.0;
    }
  }
  return linked / count;
}

TEST(SensorNoise, LinksPixelsOfOneSurfaceAndNoneAcrossAGap) {
  const CameraFrame towel = take(test::makeTowel(1.0, 60.0), 0.1, 0.125);
  const CameraFrame sheets = take(test::makeTwoSheets(1.0, 0.02), 0.1, 0.125);
  const PixelLinks on_towel = findSensorNoise(towel.cloud, clean(towel.cloud)).links;
  const PixelLinks on_sheets = findSensorNoise(sheets.cloud, clean(sheets.cloud)).links;
  ASSERT_FALSE(on_towel.isEmpty() || on_sheets.isEmpty());
  EXPECT_GT(findLinkedShare(towel, on_towel, false), 0.998);
  EXPECT_GT(findLinkedShare(sheets, on_sheets, false), 0.998);
  EXPECT_LT(findLinkedShare(sheets, on_sheets, true), 0.02);
}

TEST(SensorNoise, IsAtLeastWhatTheStepsOfDepthsMake) {
  // Of a slightly tilted plane most windows lie on one step.
  for (const double tilt : {10.0, 30.0}) {
    const CameraFrame frame = take(test::makeTowel(1.0, tilt), 0.0, 0.125, 0.0);
    const CleanCloud cloud = clean(frame.cloud);
    const SensorNoise found = findSensorNoise(frame.cloud, cloud);
    EXPECT_GT(found.deviation, 0.8 * frame.camera.depthNoise(1.0)) << tilt;
    ASSERT_FALSE(found.surface.empty());
    EXPECT_LT(findRefusedShare(found.surface), 0.002) << tilt;
  }
}

TEST(SensorNoise, TellsThatTooFewStepsLookLikeParts) {
  for (const double tilt : {0.0, 2.0, 20.0}) {
    const CameraFrame frame = take(test::makeTowel(1.0, tilt), 0.0, 0.125, 0.0);
    const CleanCloud cloud = clean(frame.cloud);
    const SensorNoise found = findSensorNoise(frame.cloud, cloud);
    EXPECT_EQ(found.num_levels > 0, tilt == 2.0) << found.num_levels << " levels at " << tilt << " degrees";
    // A step of the disparity at one metre.
    if (tilt == 2.0) {
      EXPECT_NEAR(found.level_step, 0.125 / (575.0 * 0.075), 2e-4);
    }
    EXPECT_EQ(findSensorNoise(frame.cloud, cloud, frame.camera.depthNoise(1.0)).num_levels, 0);
  }
}

TEST(SensorNoise, IsFoundWhereMostPixelsAreMissing) {
  for (const double missing : {0.7, 0.9}) {
    const CameraFrame frame = take(test::makeTowel(1.0, 20.0), 0.1, 0.125, missing);
    const CleanCloud cloud = clean(frame.cloud);
    const SensorNoise found = findSensorNoise(frame.cloud, cloud);
    ASSERT_FALSE(found.surface.empty()) << missing;
    EXPECT_LT(measureError(frame, cloud, found.surface), 0.6 * measureError(frame, cloud, cloud.positions)) << missing;
  }
}

TEST(SensorNoise, LinksNoPixelsWhereHalfOfThemAreMissing) {
  for (const double missing : {0.3, 0.5}) {
    const CameraFrame frame = take(test::makeTowel(1.0, 20.0), 0.1, 0.125, missing);
    const SensorNoise found = findSensorNoise(frame.cloud, clean(frame.cloud));
    EXPECT_TRUE(found.is_image);
    EXPECT_FALSE(found.surface.empty());
    EXPECT_EQ(found.links.isEmpty(), missing == 0.5);
  }
}

TEST(SensorNoise, OfLinesOfPointsIsNone) {
  PointCloud lines;
  for (int i = 0; i < 4000; ++i) lines.positions.emplace_back(0.001 * (i % 1000), 0.03 * (i / 1000), 0.0);
  lines.width = 4000;
  EXPECT_TRUE(findSensorNoise(lines, clean(lines)).surface.empty());
}

TEST(SensorNoise, LeavesSheetsApartThatAreFartherThanItTells) {
  const double gap = 0.015;
  const CameraFrame frame = take(test::makeTwoSheets(1.0, gap), 0.1, 0.125);
  const CleanCloud cloud = clean(frame.cloud);
  const SensorNoise found = findSensorNoise(frame.cloud, cloud);
  ASSERT_FALSE(found.surface.empty());
  EXPECT_LT(found.least_gap, gap);
  Index astray = 0, seen = 0;
  for (Index p = 0; p < frame.size(); ++p) {
    const Index i = cloud.point_of_input[p];
    if (i < 0) continue;
    ++seen;
    astray += std::abs(found.surface[i].z() - frame.clean.positions[p].z()) > 0.5 * gap;
  }
  EXPECT_LT(astray, seen / 200);
}

TEST(SensorNoise, PutsPixelsBesideAStepOnTheirOwnSide) {
  // Four standard deviations apart.
  const double gap = 0.01;
  const test::CameraScene scene = test::makeTwoSheets(1.0, gap);
  Index astray = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    test::DepthCamera camera;
    camera.noise = 0.1;
    camera.quantum = 0.125;
    camera.seed = seed;
    const CameraFrame frame = test::takeFrame(test::aimAt(scene, camera), scene.sheets);
    const CleanCloud cloud = clean(frame.cloud);
    const SensorNoise found = findSensorNoise(frame.cloud, cloud);
    ASSERT_FALSE(found.surface.empty());
    for (Index p = 0; p < frame.size(); ++p) {
      const Index i = cloud.point_of_input[p];
      astray += i >= 0 && std::abs(found.surface[i].z() - frame.clean.positions[p].z()) > 0.5 * gap;
    }
  }
  EXPECT_LE(astray, 20) << "without a look at their neighbours there are some seventy";
}

TEST(SensorNoise, LinksNoRampThatACameraMakesOfAStep) {
  CameraFrame frame = take(test::makeTowel(1.0, 0.0), 0.1, 0.0, 0.0);
  constexpr Index kWidth = 160, kLast = 8;  // columns of the ramp
  for (Index p = 0; p < frame.size(); ++p) {
    const double behind = std::clamp((p % kWidth - kWidth / 2) / static_cast<double>(kLast), 0.0, 1.0);
    frame.cloud.positions[p] *= 1.0 + 0.5 * behind;
  }
  const SensorNoise found = findSensorNoise(frame.cloud, clean(frame.cloud));
  ASSERT_FALSE(found.links.isEmpty());
  Index across = 0;
  for (Index p = 0; p < frame.size(); ++p)
    if (p % kWidth == kWidth / 2 + kLast / 2) across += found.links.links[p] & 1;  // to the right
  EXPECT_EQ(across, 0);
}

TEST(SensorNoise, DoesNotJoinSurfacesByWhatFliesBetweenThem) {
  const CameraFrame frame = take(test::makeTwoSheets(1.0, 0.02), 0.05, 0.125, 0.05, 0.5);
  const CleanCloud cloud = clean(frame.cloud);
  const Points surface = findSensorNoise(frame.cloud, cloud).surface;
  ASSERT_FALSE(surface.empty());
  Index flying = 0, between = 0;
  for (Index p = 0; p < frame.size(); ++p) {
    const Index i = cloud.point_of_input[p];
    if (i < 0 || !frame.flies[p]) continue;
    ++flying;
    double nearest = 1.0;
    for (const double z : {0.98, 1.0, 1.02}) nearest = std::min(nearest, std::abs(surface[i].z() - z));
    between += nearest > 0.005;
  }
  EXPECT_GT(flying, 50);
  EXPECT_LE(between, flying / 50);
}

TEST(SensorNoise, MovesPointsAlongTheirLinesOfSight) {
  const CameraFrame frame = take(test::makeFoldedTowel(1.0, 0.02), 0.1, 0.125);
  CleanCloud cloud = clean(frame.cloud);
  const SensorNoise found = findSensorNoise(frame.cloud, cloud);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i)
    EXPECT_LT(found.surface[i].normalized().cross(cloud.positions[i].normalized()).norm(), 1e-6);

  // The same without rows and columns, and turned about the eye so that x / z and y / z do not show them.
  const Mat3 turn = Eigen::AngleAxisd(1.0, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  PointCloud scattered = frame.cloud;
  scattered.width = static_cast<std::uint32_t>(scattered.size());
  scattered.height = 1;
  for (Vec3& p : scattered.positions) p = turn * p;
  cloud = clean(scattered);
  const SensorNoise again = findSensorNoise(scattered, cloud);
  EXPECT_FALSE(again.is_image);
  ASSERT_TRUE(again.is_seen);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i)
    EXPECT_LT(again.surface[i].normalized().cross(cloud.positions[i].normalized()).norm(), 1e-9);
  Points back = again.surface, seen = cloud.positions;
  for (Vec3& p : back) p = turn.transpose() * p;
  for (Vec3& p : seen) p = turn.transpose() * p;
  EXPECT_LT(measureError(frame, cloud, back), 0.5 * measureError(frame, cloud, seen));
}

// Drivers and filters that drop missing pixels, and programs that shuffle points, leave a list.
TEST(SensorNoise, FindsTheRowsAndColumnsOfAList) {
  const CameraFrame frame = take(test::makeFoldedTowel(1.0, 0.02), 0.1, 0.125, 0.2);
  const SensorNoise found = findSensorNoise(frame.cloud, clean(frame.cloud));
  std::vector<Index> order;
  for (Index p = 0; p < frame.size(); ++p)
    if (frame.isSeen(p)) order.push_back(p);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  order.push_back(order.front());  // a point that is there twice
  PointCloud list;
  for (const Index p : order) list.positions.push_back(frame.cloud.positions[p].cast<float>().cast<double>());
  list.width = static_cast<std::uint32_t>(list.size());
  const CleanCloud cloud = clean(list), organised = clean(frame.cloud);
  const SensorNoise again = findSensorNoise(list, cloud);
  EXPECT_FALSE(found.is_grid_found);
  ASSERT_TRUE(again.is_image && again.is_grid_found);
  EXPECT_NEAR(again.deviation, found.deviation, 0.001 * found.deviation);
  ASSERT_FALSE(again.links.isEmpty());
  const std::vector<Index> points = again.links.findPoints(cloud.point_of_input);
  std::size_t far = 0;  // rounding may select another window
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Index i = cloud.point_of_input[k];
    EXPECT_EQ(std::count(points.begin(), points.end(), i), 1);
    far += (again.surface[i] - found.surface[organised.point_of_input[order[k]]]).norm() > 0.02 * found.deviation;
  }
  EXPECT_LT(far, order.size() / 100);

  // Two depths in one pixel are no image.
  list.positions.push_back(1.1 * list.positions.front());
  list.width = static_cast<std::uint32_t>(list.size());
  EXPECT_FALSE(findSensorNoise(list, clean(list)).is_image);
}

TEST(SensorNoise, IsSeenByACameraThatStandsAnywhere) {
  CameraFrame frame = take(test::makeTowel(1.0, 0.0), 0.1, 0.125);
  const SensorNoise there = findSensorNoise(frame.cloud, clean(frame.cloud));
  const Eigen::Isometry3d turned = Eigen::Translation3d(3.0, -1.0, 0.5) * Eigen::AngleAxisd(2.0, Vec3(1, 2, -1).normalized());
  for (Vec3& p : frame.cloud.positions) p = turned * p;
  frame.cloud.origin = turned * Vec3::Zero();
  const SensorNoise here = findSensorNoise(frame.cloud, clean(frame.cloud));
  ASSERT_TRUE(here.is_image);
  EXPECT_NEAR(here.deviation, there.deviation, 1e-6 * there.deviation);
  for (std::size_t i = 0; i < here.surface.size(); ++i)
    EXPECT_LT((here.surface[i] - turned * there.surface[i]).norm(), 1e-6) << i;
}

TEST(SensorNoise, IsSeenByACameraThatTheCloudDoesNotName) {
  const Eigen::Isometry3d turned = Eigen::Translation3d(3.0, -1.0, 0.5) * Eigen::AngleAxisd(2.0, Vec3(1, 2, -1).normalized());
  for (const double distance : {0.6, 1.0, 2.0}) {
    for (const double tilt : {0.0, 30.0, 60.0}) {
      CameraFrame frame = take(test::makeTowel(distance, tilt), 0.1, 0.125);
      const SensorNoise there = findSensorNoise(frame.cloud, clean(frame.cloud));
      EXPECT_FALSE(there.is_eye_found);
      // As a driver gives it, in single precision.
      for (Vec3& p : frame.cloud.positions) p = (turned * p).cast<float>().cast<double>();
      const SensorNoise here = findSensorNoise(frame.cloud, clean(frame.cloud));
      ASSERT_TRUE(here.is_image && here.is_eye_found) << distance << ' ' << tilt;
      EXPECT_LT((here.eye - turned * Vec3::Zero()).norm(), 1e-3 * distance);
      EXPECT_NEAR(here.deviation, there.deviation, 1e-2 * there.deviation);
      EXPECT_EQ(here.links.links.size(), there.links.links.size());
      ASSERT_EQ(here.surface.size(), there.surface.size());
      std::size_t far = 0;
      for (std::size_t i = 0; i < here.surface.size(); ++i)
        far += (here.surface[i] - turned * there.surface[i]).norm() > 0.02 * there.deviation;
      EXPECT_LT(far, here.surface.size() / 100);
    }
  }
}

// Rows and columns alone are no image: those of a scanner that turns, of a height map, and of a plane without noise.
TEST(SensorNoise, FindsNoCameraWhereNoneStood) {
  std::mt19937 random(5);
  std::normal_distribution<double> off(0.0, 1.0);
  for (const char* kind : {"turning", "map", "plane"}) {
    PointCloud cloud;
    cloud.width = 120;
    cloud.height = 80;
    for (int v = 0; v < 80; ++v)
      for (int u = 0; u < 120; ++u) {
        const double a = 0.02 * u, b = 0.01 * v - 0.4, noise = off(random);
        if (*kind == 't') {
          cloud.positions.push_back(
              (2.0 + 0.01 * noise) * Vec3(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)) + Vec3(5, 3, 1));
        } else if (*kind == 'm') {
          cloud.positions.emplace_back(5.0 + 0.01 * u, 0.01 * v, 1.0 + 0.01 * noise);
        } else {
          cloud.positions.push_back(Vec3(5, 3, 1) + Vec3(a, b, 1.0) / (1.0 + 0.1 * a));
        }
      }
    const SensorNoise found = findSensorNoise(cloud, clean(cloud));
    EXPECT_FALSE(found.is_eye_found || found.is_grid_found) << kind;
    EXPECT_EQ(found.is_image, *kind == 'p') << kind;  // a plane is what a camera anywhere sees, also one at the origin
  }
}

TEST(SensorNoise, LeavesCleanCloudsAsTheyAre) {
  for (const CameraScene& scene : test::makeCameraScenes(1.0)) {
    const CameraFrame frame = take(scene, 0.0, 0.0);
    EXPECT_TRUE(findSensorNoise(frame.cloud, clean(frame.cloud)).surface.empty()) << scene.name;
  }
}

// A sheet with points at random places, and off it by normal noise.
PointCloud makeRoughSheet(double noise, double layer_gap) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::normal_distribution<double> off(0.0, 1.0);
  PointCloud cloud;
  for (int i = 0; i < 2500; ++i) {
    const double x = place(random), y = place(random), z = noise * off(random) + (i % 2) * layer_gap;
    cloud.positions.emplace_back(x, y, z);
  }
  cloud.width = 2500;
  cloud.origin = Vec3(0.0, 0.0, 0.0);
  return cloud;
}

TEST(SensorNoise, OfScatteredPointsIsWhatLargerWindowsHaveToo) {
  const PointCloud cloud = makeRoughSheet(0.01, 0.0);
  const SensorNoise found = findSensorNoise(cloud, clean(cloud));
  EXPECT_FALSE(found.is_seen);
  EXPECT_NEAR(found.deviation, 0.01, 0.0015);
  ASSERT_EQ(found.surface.size(), cloud.positions.size());
  double sum = 0.0;
  for (const Vec3& p : found.surface) sum += p.z() * p.z() / 2500.0;
  EXPECT_LT(std::sqrt(sum), 0.5 * 0.01);
}

TEST(SensorNoise, IsNotWhatLayersAndShapesLeave) {
  const PointCloud layers = makeRoughSheet(0.0, 0.015);
  EXPECT_TRUE(findSensorNoise(layers, clean(layers)).surface.empty());

  // Few points on a torus, as far off the planes around them as noise would be.
  PointCloud torus;
  for (int a = 0; a < 24; ++a)
    for (int b = 0; b < 8; ++b) {
      const double u = 2.0 * M_PI * (a + 0.5 * (b % 2)) / 24.0, v = 2.0 * M_PI * b / 8.0;
      torus.positions.emplace_back((1.0 + 0.35 * std::cos(v)) * std::cos(u), (1.0 + 0.35 * std::cos(v)) * std::sin(u),
                                   0.35 * std::sin(v));
    }
  torus.width = static_cast<std::uint32_t>(torus.positions.size());
  EXPECT_TRUE(findSensorNoise(torus, clean(torus)).surface.empty());
}

// A square grid in a plane.
void addLayer(Index along, double length, double height, Points& points) {
  for (Index i = 0; i < along; ++i)
    for (Index j = 0; j < along; ++j) points.emplace_back(length * i / (along - 1.0), length * j / (along - 1.0), height);
}

TEST(SensorNoise, IsNotWhatLayersOfDifferentDensityLeave) {
  for (const Index along : {13, 15, 17}) {
    for (const double gap : {0.6, 0.8, 1.0, 1.2, 1.6}) {  // of the spacing of the coarser layer
      PointCloud layers;
      addLayer(along, 1.0, 0.0, layers.positions);
      addLayer(25, 1.0, gap / (along - 1.0), layers.positions);
      layers.width = static_cast<std::uint32_t>(layers.positions.size());
      EXPECT_TRUE(findSensorNoise(layers, clean(layers)).surface.empty()) << along << " points along, gap " << gap;
    }
  }
}

TEST(SensorNoise, MayBeStatedOrDenied) {
  const CameraFrame frame = take(test::makeTowel(1.0, 0.0), 0.1, 0.125);
  const CleanCloud cloud = clean(frame.cloud);
  EXPECT_TRUE(findSensorNoise(frame.cloud, cloud, 0.0).surface.empty());
  const SensorNoise stated = findSensorNoise(frame.cloud, cloud, 0.005);
  EXPECT_DOUBLE_EQ(stated.deviation, 0.005);
  EXPECT_GT(stated.window, findSensorNoise(frame.cloud, cloud).window);
  EXPECT_THROW(findSensorNoise(frame.cloud, cloud, -1.0), InputError);
  EXPECT_THROW(findSensorNoise(frame.cloud, cloud, std::nan("")), InputError);
}

TEST(SensorNoise, DoesNotDependOnTheNumberOfThreads) {
  const CameraFrame frame = take(test::makeGarment(1.0), 0.1, 0.125);
  const CleanCloud cloud = clean(frame.cloud);
  setNumThreads(1);
  const SensorNoise one = findSensorNoise(frame.cloud, cloud);
  setNumThreads(3);
  const SensorNoise three = findSensorNoise(frame.cloud, cloud);
  setNumThreads(0);
  EXPECT_EQ(one.surface, three.surface);
}

TEST(SensorNoise, TakesAnyCloud) {
  PointCloud cloud;
  cloud.width = 40;
  cloud.height = 30;
  cloud.positions.assign(1200, Vec3::Constant(std::nan("")));
  for (int i = 0; i < 1200; i += 2) cloud.positions[i] = Vec3(i % 40, i / 40, 0.0);  // on the eye's plane
  EXPECT_TRUE(findSensorNoise(cloud, clean(cloud)).surface.empty());
  for (int i = 0; i < 1200; i += 2) cloud.positions[i] = Vec3(0.0, 0.0, 1.0 + i);  // on one ray
  EXPECT_TRUE(findSensorNoise(cloud, clean(cloud)).surface.empty());
  cloud.positions.assign(1200, Vec3::Zero());  // in the eye
  EXPECT_TRUE(findSensorNoise(cloud, clean(cloud)).surface.empty());
}

}  // namespace
}  // namespace deformable_surface::cloud
