// Steps that wait for commands instead of the clock (input.lockstep): the same run for any speed of the messages and any load of
// the machine.
#include "../bad_clouds.h"
#include "../node_client.h"

#include "deformable_surface/Snapshot.h"
#include "deformable_surface/ToolArray.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2_msgs/TFMessage.h>

#include <atomic>
#include <random>
#include <thread>

namespace deformable_surface::node::test {
namespace {

constexpr std::int64_t kStep = 10'000'000;  // ns

std::string makeScene(const std::string& topics) {
  return R"({model: mass_spring, gravity: [0, 0, -1], pins: [{box: {min: [-1, -1, -1], max: [0.011, 1, 1]}}],
             material: {damping: 1}, input: {lockstep: ")" +
         topics + "\"}}";
}

class LockstepTest : public ::testing::Test {
 protected:
  void start(const std::string& topics) {
    process_ = std::make_unique<NodeProcess>("/driven", makeScene(topics));
    client_ = std::make_unique<NodeClient>("/driven");
    tools_ = client_->handle().advertise<ToolArray>("tools", 1000);
    transforms_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", 1000);
    forces_ = client_->handle().advertise<PointForce>("force", 1000);
    ASSERT_TRUE(client_->waitForNode()) << process_->output();
    ASSERT_TRUE(waitUntil([&] {
      return tools_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0 && forces_.getNumSubscribers() > 0;
    }));
    cloud_ = makeSheet(20, 10);
    cloud_.header.stamp = ros::Time::now();
    ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  }
  /// A stamp in the middle of a step.
  ros::Time stampIn(int step) const { return cloud_.header.stamp + ros::Duration().fromNSec(kStep * step + kStep / 2); }
  void push(int step) {
    PointForce force = makeForce("push", Vec3(0.19, 0.05, 0.0), Vec3(0.0, 0.0005 * (step % 5), 0.002), 0.03, 0.05);
    force.header.stamp = stampIn(step);
    forces_.publish(force);
  }
  void moveBall(int step) {
    ToolArray array;
    array.tools.resize(1);
    Tool& ball = array.tools[0];
    ball.header.stamp = stampIn(step);
    ball.id = "ball";
    ball.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
    ball.primitive.dimensions = {0.03};
    ball.pose.position.x = 0.1 + 0.0005 * step;
    ball.pose.position.y = 0.05;
    ball.pose.position.z = -0.035;
    tools_.publish(array);
  }
  bool hasTaken(int steps) { return client_->waitForDiagnostic("step", steps); }
  std::uint64_t hash() {
    Snapshot exchange;
    exchange.request.name = "now";
    EXPECT_TRUE(ros::service::call("/driven/snapshot", exchange));
    return exchange.response.state_hash;
  }

  std::unique_ptr<NodeProcess> process_;
  std::unique_ptr<NodeClient> client_;
  ros::Publisher tools_, forces_, transforms_;
  PointCloud2 cloud_;
};

TEST_F(LockstepTest, TwoRunsUnderDifferentLoadEndInTheSameState) {
  start("force, tools");
  constexpr int kSteps = 150;
  // At once, faster than real time: the last step that may be taken begins before the last stamp.
  for (int step = 0; step < kSteps; ++step) push(step);
  for (int step = 0; step < kSteps; step += 3) moveBall(step);
  moveBall(kSteps - 1);
  ASSERT_TRUE(hasTaken(kSteps)) << process_->output();
  const std::uint64_t calm = hash();
  EXPECT_EQ(client_->diagnostic("commands late"), 0);

  // All cores are busy, messages come in bursts and pauses, and one topic lags behind the other.
  ASSERT_TRUE(client_->reset().success);
  ASSERT_TRUE(hasTaken(0));
  std::atomic<bool> is_over{false};
  std::vector<std::thread> load;
  for (unsigned k = 0; k < 2 * std::thread::hardware_concurrency(); ++k)
    load.emplace_back([&] {
      while (!is_over) continue;
    });
  std::mt19937 random(1);
  for (int step = 0; step < kSteps; ++step) {
    push(step);
    if (random() % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(random() % 40));
    if (step % 3 == 0 || step == kSteps - 1) moveBall(step);
  }
  EXPECT_TRUE(hasTaken(kSteps)) << process_->output();
  is_over = true;
  for (std::thread& thread : load) thread.join();
  EXPECT_EQ(hash(), calm);
  EXPECT_EQ(client_->diagnostic("commands late"), 0);
}

TEST_F(LockstepTest, AStepWaitsForEveryTopicThatIsNamed) {
  start("force tools");
  for (int step = 0; step < 20; ++step) push(step);
  ASSERT_TRUE(waitUntil([&] {
    return client_->diagnosticText("state").find("waiting for commands after") == 0 &&
           client_->diagnostic("commands waiting") == 20;
  })) << process_->output();
  EXPECT_EQ(client_->diagnostic("step"), 0);
  moveBall(9);
  ASSERT_TRUE(hasTaken(10)) << process_->output();
  // The sender's clock alone drives the steps: a command without a stamp has no place in it.
  client_->publish(makeForce("now", Vec3::Zero(), Vec3::UnitZ()));
  ASSERT_TRUE(client_->waitForDiagnostic("commands refused", 1)) << process_->output();
  EXPECT_NE(process_->output().find("found no stamp; accepted with input.lockstep"), std::string::npos) << process_->output();
  moveBall(19);
  ASSERT_TRUE(hasTaken(20)) << process_->output();
}

TEST_F(LockstepTest, AStepWaitsForTheFramesOfItsCommandsAndTools) {
  start("tools");
  const auto tell = [&](int last) {
    for (int step = -1; step <= last; ++step) {
      tf2_msgs::TFMessage message;
      message.transforms.resize(1);
      message.transforms[0].header.frame_id = cloud_.header.frame_id;
      message.transforms[0].header.stamp = stampIn(step);
      message.transforms[0].child_frame_id = "hand";
      message.transforms[0].transform.translation.x = 0.1 + 0.0005 * step;
      message.transforms[0].transform.rotation.w = 1.0;
      transforms_.publish(message);
    }
  };
  const auto send = [&] {
    ToolArray array;
    array.tools.resize(2);
    for (int k = 0; k < 2; ++k) {
      Tool& ball = array.tools[k];
      ball.header.frame_id = "hand";
      ball.header.stamp = stampIn(40 * k);
      ball.id = k == 0 ? "ball" : "last";
      ball.follow_frame = k == 0;
      ball.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
      ball.primitive.dimensions = {0.03};
      ball.pose.position.y = 0.05;
      ball.pose.position.z = k == 0 ? -0.035 : -1.0;
    }
    tools_.publish(array);
  };
  send();
  ASSERT_TRUE(waitUntil([&] { return process_->output().find("waits for a transform of frame 'hand'") != std::string::npos; }));
  tell(60);
  ASSERT_TRUE(hasTaken(41)) << process_->output();
  const std::uint64_t late = hash();
  EXPECT_EQ(client_->diagnostic("commands late"), 0);
  ASSERT_TRUE(client_->reset().success);
  ASSERT_TRUE(hasTaken(0));
  send();
  ASSERT_TRUE(hasTaken(41)) << process_->output();
  EXPECT_EQ(hash(), late);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "lockstep_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
