// Transforms that arrive late or never. Commands and clouds wait for them for a limited time, with a message.
#include "surface_node_fixture.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2_msgs/TFMessage.h>

namespace deformable_surface::node::test {
namespace {

class FramesTest : public SurfaceNodeTest {
 protected:
  void SetUp() override {
    SurfaceNodeTest::SetUp();
    transforms_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", 100);
    ASSERT_TRUE(waitUntil([&] { return transforms_.getNumSubscribers() > 0; }));
  }
  /// The frame is above the origin of the camera.
  void tell(const std::string& frame, const ros::Time& stamp) {
    tf2_msgs::TFMessage message;
    message.transforms.resize(1);
    message.transforms[0].header.frame_id = "camera";
    message.transforms[0].header.stamp = stamp;
    message.transforms[0].child_frame_id = frame;
    message.transforms[0].transform.translation.z = 0.3;
    message.transforms[0].transform.rotation.w = 1.0;
    transforms_.publish(message);
  }
  void push(const char* id, const char* frame, double force, const ros::Time& stamp = ros::Time()) {
    PointForce message = makeForce(id, Vec3(0.2, 0.1, -0.3), Vec3(0.0, 0.0, force), 0.05);
    message.header.frame_id = frame;
    message.header.stamp = stamp;
    client_->publish(message);
  }
  double height() const { return readPosition(*client_->frames.back(), 7 * kColumns + 10).z(); }

  ros::Publisher transforms_;
};

TEST_F(FramesTest, ACommandWaitsForItsTransformAndThenTakesEffectLate) {
  ASSERT_TRUE(client_->exchange(makeSurface(ros::Time::now()))) << process_->output();
  push("push", "late", 1e-3);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 1)) << process_->output();
  EXPECT_EQ(client_->diagnostic("commands applied"), 0);
  tell("late", ros::Time::now());
  EXPECT_TRUE(waitUntil([&] { return height() > 1e-6; })) << process_->output();
  EXPECT_TRUE(client_->waitForDiagnostic("commands applied", 1));
  EXPECT_EQ(client_->diagnostic("commands late"), 1);
  EXPECT_EQ(client_->diagnostic("commands refused"), 0);
  EXPECT_EQ(countOf("there is no transform from frame 'late' to 'camera'", process_->output()), 1u) << process_->output();
}

TEST_F(FramesTest, ACommandWithAStampWaitsForATransformThatReachesIt) {
  ASSERT_TRUE(client_->exchange(makeSurface(ros::Time::now()))) << process_->output();
  const ros::Time stamp = ros::Time::now();
  tell("tool", stamp - ros::Duration(0.02));
  push("push", "tool", 1e-3, stamp);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 1)) << process_->output();
  tell("tool", stamp + ros::Duration(0.02));
  EXPECT_TRUE(client_->waitForDiagnostic("commands applied", 1)) << process_->output();
}

TEST_F(FramesTest, ACommandWhoseTransformNeverComesIsRefusedAndHoldsNoOtherUp) {
  ASSERT_TRUE(client_->exchange(makeSurface(ros::Time::now()))) << process_->output();
  push("lost", "nowhere", 1e-3);
  push("push", "camera", 1e-3);
  EXPECT_TRUE(waitUntil([&] { return height() > 1e-6; })) << process_->output();
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", 1)) << process_->output();
  EXPECT_EQ(client_->diagnostic("commands waiting"), 0);
  EXPECT_EQ(client_->diagnostic("commands applied"), 1);
}

TEST_F(FramesTest, OfCommandsForTheSameThingTheNewestWaits) {
  ASSERT_TRUE(client_->exchange(makeSurface(ros::Time::now()))) << process_->output();
  for (int k = 0; k < 8; ++k) push("push", "late", 1e-3 * (k % 2 == 0 ? 1.0 : -1.0));
  ASSERT_TRUE(client_->waitForDiagnostic("commands dropped", 7)) << process_->output();
  EXPECT_EQ(client_->diagnostic("commands waiting"), 1);
  tell("late", ros::Time::now());
  EXPECT_TRUE(waitUntil([&] { return height() < -1e-6; })) << process_->output();
}

TEST_F(FramesTest, ACloudIsTakenThoughItsTransformComesAfterTheNextOne) {
  NodeProcess process("/world", "{model: mass_spring, frame_id: camera, gravity: [0, 0, 0]}");
  NodeClient client("/world");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(waitUntil([&] { return transforms_.getNumSubscribers() > 1; }));
  // Every transform comes two clouds late.
  std::vector<ros::Time> stamps;
  const ros::Time begin = ros::Time::now();
  PointCloud2 cloud = makeSurface(begin);
  cloud.header.frame_id = "sensor";
  ASSERT_TRUE(waitUntil([&] {
    stamps.push_back(begin + ros::Duration(0.05 * static_cast<double>(stamps.size())));
    cloud.header.stamp = stamps.back();
    client.publish(cloud);
    waitUntil([] { return false; }, 0.05);
    if (stamps.size() > 2) tell("sensor", stamps[stamps.size() - 3]);
    return client.diagnostic("clouds accepted") > 0 || stamps.size() > 60;
  }));
  EXPECT_GT(client.diagnostic("clouds accepted"), 0) << process.output();
  ASSERT_TRUE(waitUntil([&] { return !client.frames.empty(); })) << process.output();
  EXPECT_NEAR(readPosition(*client.frames.back(), 0).z(), 0.3, 1e-6);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "frames_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
