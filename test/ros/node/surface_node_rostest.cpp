// The node from a client's view, in a process of its own: the published cloud, steps, files, failures and the end.
#include "surface_node_fixture.h"

#include <algorithm>

namespace deformable_surface::node::test {
namespace {

TEST_F(SurfaceNodeTest, GivesBackEveryPointInOrderWithItsOtherFields) {
  const auto frame = startPaused();
  ASSERT_TRUE(frame) << process_->output();
  EXPECT_EQ(frame->header.frame_id, "camera");
  EXPECT_EQ(frame->width, static_cast<std::uint32_t>(kColumns));
  EXPECT_EQ(frame->height, static_cast<std::uint32_t>(kRows));
  std::vector<std::string> names;
  for (const auto& field : frame->fields) names.push_back(field.name);
  EXPECT_EQ(names, (std::vector<std::string>{"x", "y", "z", "normal_x", "normal_y", "normal_z", "displacement", "intensity"}));
  for (int i = 0; i < kColumns * kRows; ++i) {
    EXPECT_EQ(readField(*frame, i, "intensity"), i);
    if (i % kHole == kHole - 1) {
      EXPECT_TRUE(std::isnan(readField(*frame, i, "x"))) << i;
      continue;
    }
    EXPECT_LT((readPosition(*frame, i) - readPosition(cloud_, i)).norm(), 1e-7) << i;
    EXPECT_EQ(readField(*frame, i, "displacement"), 0.0);
    EXPECT_NEAR(std::abs(readField(*frame, i, "normal_z")), 1.0, 1e-5);
  }
}

TEST_F(SurfaceNodeTest, MovesAlongTheForceAndHoldsThePinnedPart) {
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  client_->publish(makeForce("pull", Vec3(kSpacing * (kColumns - 1), 0.1, 0.0), Vec3(0.0, 0.0, 0.02), 0.05));
  const int pulled = 7 * kColumns + kColumns - 2, held = 7 * kColumns;
  ASSERT_TRUE(waitUntil([&] { return readField(*client_->frames.back(), pulled, "z") > 0.005; })) << process_->output();
  const PointCloud2& frame = *client_->frames.back();
  EXPECT_LT((readPosition(frame, held) - readPosition(cloud_, held)).norm(), 1e-6);
  EXPECT_GT(frame.header.stamp, cloud_.header.stamp);
  // Frames lie on whole steps of simulation time.
  for (const auto& f : client_->frames) EXPECT_EQ((f->header.stamp - cloud_.header.stamp).toNSec() % 10'000'000, 0);
}

TEST_F(SurfaceNodeTest, ShowsTheSurfaceOfNowToThoseWhoComeLate) {
  ASSERT_TRUE(startPaused());
  ASSERT_TRUE(client_->step(3).success);
  std::vector<sensor_msgs::PointCloud2ConstPtr> seen;
  ros::NodeHandle node;
  const ros::Subscriber late =
      node.subscribe<PointCloud2>("/surface/deformed", 10, [&](const sensor_msgs::PointCloud2ConstPtr& m) { seen.push_back(m); });
  EXPECT_TRUE(waitUntil([&] { return !seen.empty() && seen.back()->header.stamp == stampAfter(3); }));
}

TEST_F(SurfaceNodeTest, StepsOnlyWhilePausedAndRepeatsItselfAfterAReset) {
  EXPECT_FALSE(client_->reset().success);  // there is no surface yet
  ASSERT_TRUE(startPaused());
  const auto run = [&] {
    client_->publish(makeForce("pull", Vec3(0.4, 0.1, 0.0), Vec3(0.0, 0.01, 0.02), 0.05, 0.05));
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 1));
    return client_->step(20);
  };
  const StepResponse first = run();
  EXPECT_TRUE(first.success) << first.message;
  EXPECT_DOUBLE_EQ(first.simulation_time, 0.2);
  EXPECT_GT(first.energy, 0.0);
  const auto frame = client_->waitForFrame(stampAfter(20));
  ASSERT_TRUE(frame);
  EXPECT_NE(client_->step(1).state_hash, first.state_hash);

  ASSERT_TRUE(client_->reset().success);
  const StepResponse second = run();
  EXPECT_EQ(second.state_hash, first.state_hash);
  EXPECT_EQ(second.energy, first.energy);

  EXPECT_FALSE(client_->step(0).success);
  ASSERT_TRUE(client_->pause(false).success);
  const StepResponse running = client_->step(1);
  EXPECT_FALSE(running.success);
  EXPECT_NE(running.message.find("paused"), std::string::npos) << running.message;
}

TEST_F(SurfaceNodeTest, SavesUnderBareNamesOnly) {
  EXPECT_FALSE(client_->save("early.ply").success);
  ASSERT_TRUE(startPaused());
  for (const char* name : {"surface.ply", "surface.pcd"}) {
    const SaveCloudResponse saved = client_->save(name);
    EXPECT_TRUE(saved.success) << saved.message;
    EXPECT_GT(std::filesystem::file_size(directory_ / name), 1000u);
  }
  for (const std::string& name :
       std::vector<std::string>{"", ".ply", "../a.ply", "/etc/a.ply", "a/b.ply", "a.txt", "a b.ply", "-a.ply",
                                std::string("a\0.ply", 6), std::string(1 << 20, 'a') + ".ply"}) {
    EXPECT_FALSE(client_->save(name).success) << name.substr(0, 20);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory_), std::filesystem::directory_iterator()), 2);
  // A link cannot leave the directory either.
  const std::filesystem::path outside = directory_.string() + "_outside.ply";
  std::filesystem::create_symlink(outside, directory_ / "link.ply");
  EXPECT_FALSE(client_->save("link.ply").success);
  EXPECT_FALSE(std::filesystem::exists(outside));
}

TEST_F(SurfaceNodeTest, SaysOnWhichTopicItWaits) {
  // The node still runs, and its output is a file: no output may be buffered.
  EXPECT_TRUE(waitUntil([&] { return countOf("waiting for a cloud on /surface/cloud_in", process_->output()) == 1; }))
      << process_->output();
}

TEST(SurfaceNode, GoesOnAfterAFailedStepWhenItIsReset) {
  NodeProcess process("/surface", "{model: mass_spring, gravity: [0, 0, 0], output: {publish_rate: 100.0}}");
  NodeClient client("/surface");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  const PointCloud2 cloud = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud)) << process.output();
  for (int run = 1; run <= 2; ++run) {
    // So strong that a single step would move its point out of all limits.
    client.publish(makeForce("pull", Vec3(0.2, 0.1, 0.0), Vec3(0.0, 0.0, 1e12)));
    ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "stopped by a failed step"; })) << process.output();
    EXPECT_FALSE(client.step(1).success);  // the state before the step is kept, and the step fails again
    client.frames.clear();
    ASSERT_TRUE(client.reset().success);
    // At rest, and then it steps, without a call of ~pause false.
    const auto isAtRest = [](const sensor_msgs::PointCloud2& frame) {
      double largest = 0.0;
      for (int i = 0; i < kColumns * kRows; ++i) {
        if (i % kHole != kHole - 1) largest = std::max(largest, readField(frame, i, "displacement"));
      }
      return largest == 0.0;
    };
    ASSERT_TRUE(waitUntil([&] { return !client.frames.empty() && isAtRest(*client.frames.back()); })) << process.output();
    ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "running" && client.diagnostic("step") > 10; }))
        << process.output();
  }
  // If the surface was paused before the failure, it is paused after the reset.
  ASSERT_TRUE(client.pause(true).success);
  ASSERT_TRUE(client.reset().success);
  EXPECT_TRUE(client.step(1).success);
}

TEST_F(SurfaceNodeTest, EndsCleanlyOnSigterm) {
  ASSERT_TRUE(client_->exchange(makeSurface(ros::Time::now())));
  process_->send(SIGTERM);
  EXPECT_EQ(process_->waitForExit(), std::optional<int>(0)) << process_->output();
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "surface_node_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
