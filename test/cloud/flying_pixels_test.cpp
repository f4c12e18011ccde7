// Flying pixels on frames whose truth is known: pixels between object and background are removed, surfaces stay.
#include "support/depth_picture.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/flying_pixels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>

using namespace deformable_surface;
using cloud::findFlyingPixels;
using cloud::PointCloud;
using test::Camera;
using test::kNothing;

namespace {

constexpr double kJump = 0.02, kFront = 0.8, kBehind = 1.3;
constexpr int kLeft = 50, kRight = 110;  // columns of an object in front

long count(const std::vector<char>& marked) { return std::count(marked.begin(), marked.end(), 1); }

bool isInFront(int column) { return column >= kLeft && column < kRight; }

/// An object in front of a wall. The columns just left of it have depths of their own.
template <class Edge>
PointCloud takeEdge(const Camera& camera, const Edge& edge) {
  return test::takeFrame(camera, [&](int row, int column) {
    const double z = edge(row, kLeft - column);
    return z > 0.0 || std::isnan(z) ? z : isInFront(column) ? kFront : kBehind;
  });
}

/// Whether the marked columns are those that lie 1 .. wide pixels left of the object, in every row but the first and last ones.
void expectOnly(const std::vector<char>& marked, const Camera& camera, int wide) {
  for (int row = 0; row < camera.height; ++row)
    for (int column = 0; column < camera.width; ++column)
      ASSERT_EQ(marked[row * camera.width + column] != 0, column < kLeft && column >= kLeft - wide) << row << " " << column;
}

}  // namespace

TEST(FlyingPixels, OnesThatHangBetweenAThingAndTheWallAreFound) {
  for (const double noise : {0.0, 0.05}) {
    Camera camera;
    camera.noise = noise;
    // Mixed depths as of a time-of-flight camera, each at another place; and as of a resampled frame, all alike.
    expectOnly(
        findFlyingPixels(takeEdge(camera, [](int row, int left) { return left == 1 ? 0.9 + 0.003 * (row % 100) : 0.0; }), kJump),
        camera, 1);
    expectOnly(findFlyingPixels(takeEdge(camera, [](int, int left) { return left == 1 ? 1.0 : 0.0; }), kJump), camera, 1);
    // Two in a row, on a slope.
    expectOnly(findFlyingPixels(takeEdge(camera, [](int, int left) { return left == 1   ? 0.93
                                                                            : left == 2 ? 1.1
                                                                                        : 0.0; }), kJump),
               camera, 2);
  }
}

TEST(FlyingPixels, OnesBesideAShadowAreFound) {
  const Camera camera;
  const PointCloud cloud = takeEdge(camera, [](int, int left) {
    return left == 1 ? 0.95 : left > 1 && left <= 25 ? kNothing : 0.0;
  });
  expectOnly(findFlyingPixels(cloud, kJump), camera, 1);
}

TEST(FlyingPixels, GrazingSurfacesStayWithNoiseAndStepsOfDepth) {
  for (const double noise : {0.0, 0.1}) {
    for (const double degrees : {0.0, 45.0, 75.0, 84.0}) {
      Camera camera;
      camera.noise = noise;
      const double angle = degrees * M_PI / 180.0;
      const Vec3 normal(std::sin(angle), 0.0, std::cos(angle));
      const PointCloud cloud = test::takeFrame(camera, [&](int row, int column) {
        const double z = test::meetPlane(camera.direction(row, column), normal, 1.2 * normal.z());
        return z > 0.4 && z < 4.0 ? z : kNothing;
      });
      EXPECT_EQ(count(findFlyingPixels(cloud, kJump)), 0) << degrees << " degrees, noise " << noise;
    }
  }
}

TEST(FlyingPixels, EdgesStepsAndRoundThingsStay) {
  Camera camera;
  camera.noise = 0.05;
  EXPECT_EQ(count(findFlyingPixels(takeEdge(camera, [](int, int) { return 0.0; }), kJump)), 0);
  // A staircase: a band of three pixels between front and wall is an object.
  EXPECT_EQ(count(findFlyingPixels(takeEdge(camera, [](int, int left) { return left > 0 && left <= 3 ? 1.0 : 0.0; }), kJump)), 0);
  // A cable one pixel wide, in front of everything.
  EXPECT_EQ(count(findFlyingPixels(takeEdge(camera, [](int row, int) { return row == 40 ? 0.6 : 0.0; }), kJump)), 0);
  // A ball, up to its rim.
  const double radius = 0.09;
  const PointCloud ball = test::takeFrame(camera, [&](int row, int column) {
    const Vec3 ray = camera.direction(row, column), middle(0.0, 0.0, 1.0);
    const double along = ray.dot(middle) / ray.squaredNorm();
    const double inside = radius * radius - (along * ray - middle).squaredNorm();
    return inside > 0.0 ? along - std::sqrt(inside / ray.squaredNorm()) : 1.5;
  });
  EXPECT_EQ(count(findFlyingPixels(ball, kJump)), 0);
}

TEST(FlyingPixels, OutlinesOfAnyDirectionAreSearched) {
  const Camera camera;
  for (const double degrees : {0.0, 30.0, 45.0, 60.0, 90.0, 135.0}) {
    const double angle = degrees * M_PI / 180.0;
    // Across the outline: in front, one pixel of a mixture, the wall.
    const auto across = [&](int row, int column) { return std::cos(angle) * (column - 80.3) + std::sin(angle) * (row - 60.2); };
    const auto isMixed = [&](int row, int column) { return std::abs(across(row, column)) < 0.5; };
    const std::vector<char> marked =
        findFlyingPixels(test::takeFrame(camera,
                                         [&](int row, int column) {
                                           return isMixed(row, column) ? 1.0 : across(row, column) < 0.0 ? kFront : kBehind;
                                         }),
                         kJump);
    for (int row = 4; row + 4 < camera.height; ++row)
      for (int column = 4; column + 4 < camera.width; ++column)
        ASSERT_EQ(marked[row * camera.width + column] != 0, isMixed(row, column)) << degrees << ": " << row << " " << column;
  }
}

TEST(FlyingPixels, TheToleranceGrowsWithTheSquareOfTheDistance) {
  Camera camera;
  camera.step = 0.0;
  const auto hang = [&](double scale) {
    PointCloud cloud = takeEdge(camera, [](int, int left) { return left == 1 ? 1.0 : 0.0; });
    for (Vec3& p : cloud.positions) p *= scale;
    return cloud;
  };
  // In 1/z a scene that is twice as far away has half of the jump.
  const double jump = 1.0 / kFront - 1.0 / 1.0, other_jump = 1.0 / 1.0 - 1.0 / kBehind;
  ASSERT_GT(jump, other_jump);
  for (const double scale : {0.5, 1.0, 2.0}) {
    EXPECT_GT(count(findFlyingPixels(hang(scale), 0.97 * other_jump / scale)), 0) << scale;
    EXPECT_EQ(count(findFlyingPixels(hang(scale), 1.03 * other_jump / scale)), 0) << scale;
  }
}

TEST(FlyingPixels, ACloudInAnotherFrameKnowsWhereItsEyeIs) {
  Camera camera;
  camera.noise = 0.05;
  PointCloud cloud = takeEdge(camera, [](int, int left) { return left == 1 ? 1.0 : 0.0; });
  const std::vector<char> marked = findFlyingPixels(cloud, kJump);
  EXPECT_GT(count(marked), 0);
  const Eigen::Isometry3d transform =
      Eigen::Translation3d(3.0, -2.0, 5.0) * Eigen::AngleAxisd(2.0, Vec3(1.0, 2.0, -1.0).normalized());
  for (Vec3& p : cloud.positions) p = transform * p;
  cloud.origin = transform * cloud.origin;
  EXPECT_EQ(findFlyingPixels(cloud, kJump), marked);
  cloud.viewpoint = cloud.origin;
  cloud.origin.setZero();
  EXPECT_EQ(findFlyingPixels(cloud, kJump), marked);
}

TEST(FlyingPixels, TheNumberOfThreadsDoesNotMatterAndHolesDoNotFly) {
  Camera camera;
  camera.noise = 0.3;
  const PointCloud cloud = takeEdge(camera, [](int row, int left) { return (row + left) % 7 == 0 ? kNothing : 0.0; });
  setNumThreads(1);
  const std::vector<char> marked = findFlyingPixels(cloud, 0.005);
  EXPECT_GT(count(marked), 0);
  for (Index i = 0; i < cloud.size(); ++i) EXPECT_FALSE(marked[i] && !cloud.positions[i].allFinite());
  for (const int threads : {2, 3}) {
    setNumThreads(threads);
    EXPECT_EQ(findFlyingPixels(cloud, 0.005), marked);
  }
  setNumThreads(0);
}

TEST(FlyingPixels, OddFramesAreRefusedOrHaveNone) {
  PointCloud cloud = test::takeFrame(Camera(), [](int, int) { return 1.0; });
  EXPECT_THROW(findFlyingPixels(cloud, 0.0), InputError);
  EXPECT_THROW(findFlyingPixels(cloud, kNothing), InputError);
  cloud.width *= cloud.height;
  cloud.height = 1;
  EXPECT_THROW(findFlyingPixels(cloud, kJump), InputError);
  EXPECT_EQ(count(findFlyingPixels(test::takeFrame(Camera(), [](int, int) { return kNothing; }), kJump)), 0);
  // All at the eye.
  PointCloud at_eye = test::takeFrame(Camera(), [](int, int) { return 1.0; });
  for (Vec3& p : at_eye.positions) p.setZero();
  EXPECT_EQ(count(findFlyingPixels(at_eye, kJump)), 0);
}
