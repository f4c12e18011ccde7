// Surfaces that are pulled towards clouds of a camera.
#include "clouds.h"
#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kRate = 30.0;  // Hz, of the camera

SceneParams trackedSheet() {
  SceneParams p = hangingSheet();
  p.material.young_modulus = 1e3;
  p.gravity.setZero();
  p.integrator.time_step = 1.0 / kRate / 3.0;
  p.input.policy = simulation::InputPolicy::kTrack;
  p.accuracy.estimate = false;  // the same cloud at another time
  return p;
}

// A sheet that bends up from the edge that is held.
double heightAt(double x, double amount) { return amount * x * x; }

// The view of a camera: other points than those of the simulation, in another order, and none within the hole.
cloud::PointCloud observe(double amount, double hole = 0.0) {
  cloud::PointCloud cloud;
  constexpr int kSide = 67;
  for (int k = kSide * kSide - 1; k >= 0; --k) {
    const double x = (k % kSide + 0.3) / kSide, y = (k / kSide + 0.3) / kSide - 0.5;
    const bool is_hidden = std::hypot(x - 0.6, y) < hole;
    cloud.positions.emplace_back(x, y, is_hidden ? std::numeric_limits<double>::quiet_NaN() : heightAt(x, amount));
  }
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

double largestError(const Simulation& s, double amount) {
  double largest = 0.0;
  for (const Vec3& p : s.state().positions) largest = std::max(largest, std::abs(p.z() - heightAt(p.x(), amount)));
  return largest;
}

// Rises over a second, then stands still.
double amountAt(int frame) { return 0.15 * std::min(1.0, frame / kRate); }

double track(Simulation& s, int frames, double hole) {
  for (int frame = 0; frame < frames; ++frame) {
    s.observe(observe(amountAt(frame), hole));
    run(s, 3);
  }
  return amountAt(frames);
}

TEST(Track, FollowsADeformingCloudWithinTheLagOfItsGain) {
  Simulation s(trackedSheet(), sheetCloud());
  const double amount = track(s, 30, 0.0);
  // A critically damped pull with gain g towards a motion with v lags by 2 v / sqrt(g). The edge rises by 0.15 m in a second. The
  // stiffness of the sheet adds less than that again.
  const double lag = 2.0 * 0.15 / std::sqrt(s.params().input.tracking_gain);
  EXPECT_GT(largestError(s, 0.0), 0.1);
  EXPECT_LT(largestError(s, amount), 2.0 * lag);
  EXPECT_LT(s.statistics().tracking_residual, lag);
  EXPECT_GT(s.statistics().tracked_points, 0.9 * s.statistics().simulation_points);
  // Where the cloud stands still the surface reaches it, except for the balance of two springs.
  for (int k = 0; k < 60; ++k) {
    s.observe(observe(amount));
    run(s, 3);
  }
  EXPECT_LT(s.statistics().tracking_residual, 0.1 * lag);
}

TEST(Track, AHoleIsLeftToPhysicsWhichBridgesIt) {
  SceneParams p = trackedSheet();
  // A sheet that is stiff enough to carry the part in the hole along, and to come to rest. A soft one lags for seconds.
  p.material.bending_rigidity = 0.01;
  p.material.damping = 3.0;
  Simulation s(p, sheetCloud());
  constexpr double kHole = 0.25;
  const double amount = track(s, 60, kHole);
  const simulation::Statistics now = s.statistics();
  int inside = 0;
  for (const Vec3& p : s.state().positions) inside += std::hypot(p.x() - 0.6, p.y()) < kHole - 0.05;
  ASSERT_GT(inside, 5);
  // Pinned points count as visible, those behind the hole do not.
  EXPECT_LE(now.tracked_points + inside, now.simulation_points);
  EXPECT_GT(now.tracked_points, now.simulation_points / 2);
  // At worst it spans the hole, and a spacing around it, as straight as a membrane.
  const double spacing = 1.0 / std::sqrt(static_cast<double>(now.simulation_points));
  EXPECT_LT(largestError(s, amount), amount * std::pow(kHole + spacing, 2));
}

TEST(Track, WhatIsSeenOfSomethingElsePullsNothing) {
  Simulation s(trackedSheet(), sheetCloud()), alone(trackedSheet(), sheetCloud());
  cloud::PointCloud far = observe(0.0);
  for (Vec3& p : far.positions) p.z() += 2.0;
  s.observe(far);
  EXPECT_EQ(s.statistics().tracked_points, 0u);
  EXPECT_TRUE(std::isnan(s.statistics().tracking_residual));
  // A wall on the sheet.
  cloud::PointCloud wall;
  for (int k = 0; k < 900; ++k) wall.positions.emplace_back(0.5, k % 30 / 29.0 - 0.5, k / 30 / 29.0 - 0.5);
  wall.width = 900;
  s.observe(wall);
  EXPECT_EQ(s.statistics().tracked_points, 0u);
  run(s, 3);
  run(alone, 3);
  EXPECT_EQ(s.stateHash(), alone.stateHash());
}

TEST(Track, TellsThatTheSurfaceIsLostAndWhenItIsTrackedAgain) {
  Simulation s(trackedSheet(), sheetCloud());
  cloud::PointCloud elsewhere = observe(0.0), half = observe(0.0);
  for (Vec3& p : elsewhere.positions) p.z() += 2.0;
  for (Vec3& p : half.positions)
    if (p.x() < 0.3) p.setConstant(std::numeric_limits<double>::quiet_NaN());
  std::vector<std::string> told;
  const auto follow = [&](const cloud::PointCloud& cloud, int steps) {
    s.observe(cloud);
    for (int k = 0; k < steps; ++k)
      if (const std::string notice = s.step().notice; !notice.empty()) told.push_back(notice);
  };
  follow(observe(0.0), 10);
  follow(half, 10);  // seven tenths
  EXPECT_TRUE(told.empty()) << told.front();
  const std::string most = std::to_string(s.statistics().simulation_points);
  follow(elsewhere, 10);
  follow(elsewhere, 10);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].find("the tracked cloud shows 0 of " + most + " simulation points, and has shown "), 0u) << told[0];
  EXPECT_NE(s.lastingNotices().find("less than half of the points that were tracked before were tracked in 20 of 20 steps"),
            std::string::npos)
      << s.lastingNotices();
  follow(observe(0.0), 120);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_NE(told[1].find("were tracked in 20 of 20 steps, from "), std::string::npos) << told[1];
  EXPECT_NE(told[1].find("none in the last 1 s"), std::string::npos) << told[1];
  // A reset forgets what was shown.
  follow(elsewhere, 1);
  ASSERT_EQ(told.size(), 3u);
  s.reset();
  follow(observe(0.0), 2);
  EXPECT_EQ(told.size(), 3u);
}

TEST(Track, BelongsToSnapshotsAndForksAndEndsWithAReset) {
  SceneParams p = trackedSheet();
  p.accuracy.estimate = true;
  Simulation s(p, sheetCloud());
  track(s, 5, 0.2);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork();
  run(s, 4);
  const std::uint64_t expected = s.stateHash();
  run(fork, 4);
  EXPECT_EQ(fork.stateHash(), expected);
  s.reset();
  EXPECT_EQ(s.statistics().tracked_points, 0u);
  s.restore(snapshot);
  run(s, 4);
  EXPECT_EQ(s.stateHash(), expected);
}

TEST(Track, CloudsOfNextToNothingAreRefusedAndTheOneBeforeStays) {
  Simulation s(trackedSheet(), sheetCloud());
  s.observe(observe(0.01));
  const std::uint32_t before = s.statistics().tracked_points;
  EXPECT_GT(before, 0u);
  cloud::PointCloud empty;
  EXPECT_THROW(s.observe(empty), InputError);
  empty.positions.assign(5, Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  empty.width = 5;
  EXPECT_THROW(s.observe(empty), InputError);
  EXPECT_EQ(s.statistics().tracked_points, before);
}

TEST(Track, WorksWithEveryMethodAndWithParticles) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kImplicit}) {
    SceneParams p = trackedSheet();
    p.integrator.type = type;
    Simulation s(p, sheetCloud());
    track(s, 12, 0.0);
    EXPECT_LT(s.statistics().tracking_residual, 2.0 * 0.15 / std::sqrt(p.input.tracking_gain)) << static_cast<int>(type);
    EXPECT_GT(largestError(s, 0.0), 0.02) << static_cast<int>(type);
  }
  SceneParams p = trackedSheet();
  p.model = "oriented_particles";
  p.material.bending_rigidity = 0.01;
  p.material.damping = 5.0;
  Simulation s(p, sheetCloud());
  s.observe(observe(0.0));
  EXPECT_GT(s.statistics().tracked_points, 0u);
  run(s, 3);
}

}  // namespace
}  // namespace deformable_surface::test
