// The camera of the tests against its own description.
#include "camera_frames.h"

#include "camera_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace deformable_surface::test {
namespace {

Index countSeen(const CameraFrame& frame) {
  Index count = 0;
  for (Index i = 0; i < frame.size(); ++i) count += frame.isSeen(i);
  return count;
}

CameraFrame take(const CameraScene& scene, const DepthCamera& camera) { return takeFrame(aimAt(scene, camera), scene.sheets); }

TEST(CameraFrames, ACameraWithoutNoiseSeesTheTruth) {
  DepthCamera camera;
  camera.missing = 0.0;
  const CameraFrame frame = take(makeFoldedTowel(1.0, 0.014), camera);
  Index count = 0;
  for (Index i = 0; i < frame.size(); ++i) {
    ASSERT_EQ(frame.isSeen(i), frame.sheet[i] >= 0 && !frame.in_shadow[i]);
    if (!frame.isSeen(i)) continue;
    ++count;
    ASSERT_NEAR((frame.cloud.positions[i] - frame.positions[i]).norm(), 0.0, 1e-7);  // as floats
    ASSERT_EQ(frame.clean.positions[i], frame.positions[i]);
    // The sheet is at its stated place, up to the sagitta of its cells in the bend.
    const Vec3 placed = frame.sheets[0].place(frame.places[i]);
    ASSERT_NEAR((placed - frame.positions[i]).norm(), 0.0, 1e-4);
    ASSERT_LT(frame.positions[i].dot(frame.normals[i]) * frame.positions[i].z(), frame.positions[i].squaredNorm());
  }
  EXPECT_GT(count, 10000);
}

TEST(CameraFrames, PixelsLieOnTheirRays) {
  DepthCamera camera;
  camera.noise = 0.2;
  const CameraFrame frame = take(makeTowel(1.0, 30.0), camera);
  for (Index i = 0; i < frame.size(); ++i) {
    if (!frame.isSeen(i)) continue;
    const Vec3& p = frame.cloud.positions[i];
    const Vec2 pixel(i % frame.camera.width, i / frame.camera.width);
    ASSERT_NEAR((camera.focal_length * p.head<2>() / p.z() + frame.camera.center() - pixel).norm(), 0.0, 1e-4);
  }
}

TEST(CameraFrames, NoiseOfTheDepthGrowsWithItsSquareAndIsAsStated) {
  for (const double distance : {0.6, 1.0, 2.0}) {
    for (const double quantum : {0.0, 0.125}) {
      for (const Index smoothing : {0, 1}) {
        DepthCamera camera;
        camera.noise = 0.1;
        camera.quantum = quantum;
        camera.smoothing = smoothing;
        const CameraFrame frame = take(makeTowel(distance, 0.0), camera);
        double sum = 0.0;
        for (Index i = 0; i < frame.size(); ++i)
          if (frame.isSeen(i)) sum += std::pow(frame.cloud.positions[i].z() - distance, 2);
        EXPECT_NEAR(std::sqrt(sum / countSeen(frame)) / camera.depthNoise(distance), 1.0, 0.08) << distance << " " << quantum;
      }
    }
  }
}

TEST(CameraFrames, SmoothingMakesNeighboursAlike) {
  for (const Index smoothing : {0, 2}) {
    DepthCamera camera;
    camera.noise = 0.1;
    camera.missing = 0.0;
    camera.smoothing = smoothing;
    const CameraFrame frame = take(makeTowel(1.0, 0.0), camera);
    double both = 0.0, own = 0.0;
    for (Index i = 0; i + 1 < frame.size(); ++i) {
      if (!frame.isSeen(i) || !frame.isSeen(i + 1)) continue;
      both += (frame.cloud.positions[i].z() - 1.0) * (frame.cloud.positions[i + 1].z() - 1.0);
      own += std::pow(frame.cloud.positions[i].z() - 1.0, 2);
    }
    // Means over five pixels share four of them with the next.
    EXPECT_NEAR(both / own, smoothing > 0 ? 0.8 : 0.0, 0.05);
  }
}

TEST(CameraFrames, DisparitiesAreMultiplesOfTheQuantum) {
  DepthCamera camera;
  camera.noise = 0.1;
  camera.quantum = 0.125;
  const CameraFrame frame = take(makeTowel(1.0, 30.0), camera);
  std::set<long> layers;
  for (Index i = 0; i < frame.size(); ++i) {
    if (!frame.isSeen(i)) continue;
    const double steps = camera.disparity(frame.cloud.positions[i].z()) / camera.quantum;
    ASSERT_NEAR(steps, std::round(steps), 1e-3);
    layers.insert(std::lround(steps));
  }
  EXPECT_GT(layers.size(), 20u);
  EXPECT_LT(layers.size(), 60u);
}

TEST(CameraFrames, AsManyPixelsAreMissingAsSaid) {
  DepthCamera camera;
  camera.missing = 0.05;
  const CameraFrame frame = take(makeTwoSheets(1.0, 0.01), camera);
  EXPECT_NEAR(static_cast<double>(countSeen(frame)) / frame.size(), 0.95, 0.005);
}

TEST(CameraFrames, TheProjectorLeavesAShadowAsWideAsTheStepOfTheDisparity) {
  // The upper half lies to the left of the part that it would shade. Turned over, its shadow falls on the other half.
  CameraScene scene = makeTwoSheets(1.0, 0.1);
  for (Vec2& corner : scene.sheets[1].outline) corner.x() = -corner.x();
  DepthCamera camera;
  camera.missing = 0.0;
  const CameraFrame frame = take(scene, camera);
  Index count = 0;
  for (Index i = 0; i < frame.size(); ++i) {
    count += frame.in_shadow[i];
    if (frame.in_shadow[i]) {
      ASSERT_EQ(frame.sheet[i], 0);
      ASSERT_FALSE(frame.isSeen(i));
    }
  }
  EXPECT_NEAR(static_cast<double>(count) / frame.camera.height, camera.disparity(0.9) - camera.disparity(1.0), 0.5);
  EXPECT_EQ(countSeen(take(makeTwoSheets(1.0, 0.1), camera)), frame.size());
}

TEST(CameraFrames, PixelsFlyAtGapsOnlyAndBetweenTheirSides) {
  DepthCamera camera;
  camera.missing = 0.0;
  camera.flying = 0.5;
  const CameraFrame frame = take(makeTwoSheets(1.0, 0.1), camera);
  Index count = 0;
  for (Index i = 0; i < frame.size(); ++i) {
    if (!frame.flies[i]) continue;
    ++count;
    EXPECT_LE(std::abs(i % frame.camera.width - frame.camera.center().x()), 1.0);
    EXPECT_GT(frame.cloud.positions[i].z(), 0.9 - 1e-6);
    EXPECT_LT(frame.cloud.positions[i].z(), 1.0 + 1e-6);
  }
  EXPECT_NEAR(count, frame.camera.height, 0.3 * frame.camera.height);  // half of those on both sides
}

TEST(CameraFrames, WaysOverAFoldedTowelGoRoundItsBend) {
  DepthCamera camera;
  camera.missing = 0.0;
  const CameraScene scene = makeFoldedTowel(1.0, 0.014);
  const CameraFrame frame = take(scene, camera);
  const Index row = frame.camera.height / 2 * frame.camera.width;
  Index num_gaps = 0;
  for (Index i = row; i + 1 < row + frame.camera.width; ++i) {
    if (frame.sheet[i] < 0 || frame.sheet[i + 1] < 0) continue;
    const double unfolded = (frame.places[i] - frame.places[i + 1]).norm();
    EXPECT_NEAR(findTrueDistance(frame, i, i + 1), unfolded, 0.05 * unfolded);
    EXPECT_NEAR(findTrueDistance(frame, i, i + 1), findTrueDistance(frame, i + 1, i), 1e-12);
    if (areTrueNeighbors(frame, i, i + 1)) continue;
    ++num_gaps;
    EXPECT_GT(unfolded, 0.1);
  }
  EXPECT_EQ(num_gaps, 1);
}

TEST(CameraFrames, WaysFromASleeveToTheBodyGoRoundTheArmpit) {
  DepthCamera camera;
  const CameraFrame frame = take(makeGarment(1.0), camera);
  // The pixels that see both sides of the gap, well below the armpit.
  const auto findPixel = [&](const Vec2& place) {
    Index best = 0;
    double least = 1e300;
    for (Index i = 0; i < frame.size(); ++i) {
      if (frame.sheet[i] != 1 || (frame.places[i] - place).norm() >= least) continue;
      least = (frame.places[i] - place).norm();
      best = i;
    }
    return best;
  };
  const Index body = findPixel(Vec2(0.095, 0.03)), sleeve = findPixel(Vec2(0.125, 0.03));
  const Index lower = findPixel(Vec2(0.095, 0.05)), upper = findPixel(Vec2(0.1, -0.06)), beside = findPixel(Vec2(0.11, -0.06));
  EXPECT_NEAR(findTrueDistance(frame, body, sleeve), 2.0 * 0.0715, 0.004);  // by the corner of the outline
  EXPECT_FALSE(areTrueNeighbors(frame, body, sleeve));
  EXPECT_TRUE(areTrueNeighbors(frame, body, lower));
  EXPECT_TRUE(areTrueNeighbors(frame, upper, beside));
}

TEST(CameraFrames, TrueSheetsAreToldApartHoweverNoisyTheyAre) {
  DepthCamera camera;
  camera.noise = 0.2;
  camera.quantum = 0.125;
  for (const double gap : {0.001, 0.01}) {
    const CameraFrame frame = take(makeTwoSheets(1.0, gap), camera);
    const std::vector<Index> pieces = findTruePieces(frame, 100);
    ASSERT_EQ(pieces.size(), 2u);
    EXPECT_EQ(pieces[0] + pieces[1], countSeen(frame));
  }
}

TEST(CameraFrames, NormalsAreThoseOfTheSheet) {
  const CameraFrame frame = take(makeTowel(1.0, 60.0), DepthCamera());
  for (Index i = 0; i < frame.size(); ++i) {
    if (frame.sheet[i] < 0) continue;
    ASSERT_NEAR(std::abs(frame.normals[i].z()), 0.5, 1e-6);
    ASSERT_NEAR(frame.normals[i].x(), 0.0, 1e-6);
  }
}

TEST(CameraFrames, DrawsAreTheSameForEveryNoise) {
  DepthCamera camera, noisy;
  noisy.noise = 0.2;
  const CameraScene scene = makeTowel(1.0, 0.0);
  const CameraFrame a = take(scene, camera), b = take(scene, noisy), c = take(scene, noisy);
  noisy.seed = 2;
  const CameraFrame d = take(scene, noisy);
  Index num_other = 0;
  for (Index i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.isSeen(i), b.isSeen(i));
    if (!b.isSeen(i)) continue;
    ASSERT_EQ(b.cloud.positions[i], c.cloud.positions[i]);
    num_other += !d.isSeen(i) || b.cloud.positions[i] != d.cloud.positions[i];
  }
  EXPECT_GT(num_other, countSeen(a) / 2);
}

}  // namespace
}  // namespace deformable_surface::test
