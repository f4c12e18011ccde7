// Oriented particles over services: single particles are edited, and surfaces grow through them while the node answers.
#include "surface_node_fixture.h"

#include "deformable_surface/FitSurface.h"
#include "deformable_surface/List.h"
#include "deformable_surface/Restore.h"
#include "deformable_surface/RolloutAction.h"
#include "deformable_surface/SetMaterial.h"
#include "deformable_surface/Snapshot.h"
#include "deformable_surface/ToolArray.h"

#include <actionlib/client/action_client.h>

#include <cstdio>
#include <numeric>
#include <thread>

namespace deformable_surface::node::test {
namespace {

using ParticlesTest = SurfaceNodeTest;

TEST_F(ParticlesTest, EditsParticlesAndGrowsASurfaceThroughThem) {
  NodeProcess process("/grown", "{model: oriented_particles, gravity: [0, 0, 0], simplification: {method: none}}");
  NodeClient client("/grown");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.pause(true).success);
  cloud_ = makeSheet(12, 12);
  cloud_.header.stamp = ros::Time::now();
  ASSERT_TRUE(client.exchange(cloud_)) << process.output();
  EditParticlesRequest edit;
  edit.action = EditParticlesRequest::DELETE;
  edit.ids = {66};
  const EditParticlesResponse deleted = client.edit(edit);
  EXPECT_TRUE(deleted.success) << deleted.message;
  EXPECT_NE(deleted.message.find("143 are there"), std::string::npos) << deleted.message;
  EXPECT_FALSE(client.edit(edit).success);
  edit.action = 7;
  EXPECT_FALSE(client.edit(edit).success);

  edit = EditParticlesRequest();
  edit.poses.resize(1);
  edit.poses[0].position.z = 0.5;
  const EditParticlesResponse added = client.edit(edit);
  EXPECT_TRUE(added.success) << added.message;
  EXPECT_EQ(added.added, std::vector<std::uint32_t>{144});
  edit.action = EditParticlesRequest::CREASE;
  edit.ids = {1};
  EXPECT_FALSE(client.edit(edit).success);  // a pose for nothing

  const StepResponse stepped = client.step(3);
  EXPECT_TRUE(stepped.success) << stepped.message << process.output();

  const GrowSurfaceResponse grown = client.growSurface(GrowSurfaceRequest());
  EXPECT_TRUE(grown.success) << grown.message;
  EXPECT_GE(grown.particles, 144u);
  FitSurface by_old_name;
  ASSERT_TRUE(ros::service::call("/grown/fit", by_old_name));
  EXPECT_TRUE(by_old_name.response.success) << by_old_name.response.message;
  EXPECT_NE(process.output().find("~fit is now called ~grow_surface"), std::string::npos) << process.output();
  GrowSurfaceRequest wrong;
  wrong.max_gap = -1.0;
  EXPECT_FALSE(client.growSurface(wrong).success);

  // Springs have no such action.
  ASSERT_TRUE(startPaused());
  const GrowSurfaceResponse refused = client_->growSurface(GrowSurfaceRequest());
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("accepted: oriented_particles"), std::string::npos) << refused.message;
}

// A scalpel that comes over ROS cuts for good: the hand that follows takes one side along, and the other stays.
TEST_F(ParticlesTest, AScalpelCutsWhileTheNodeRuns) {
  NodeProcess process("/cut",
                      "{model: oriented_particles, gravity: [0, 0, 0], simplification: {method: none}, "
                      "material: {damping: 5.0, bending_rigidity: 3.0e-3}, input: {tool_timeout: 0.0}, "
                      "pins: [{box: {min: [-1, -1, -1], max: [0.011, 1, 1]}}], "
                      "output: {publish_rate: 100.0, stamp: simulation}}");
  NodeClient client("/cut");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ros::Publisher tools = client.handle().advertise<ToolArray>("tools", 10);
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0; }));
  ASSERT_TRUE(client.pause(true).success);
  constexpr int kSide = 12;
  cloud_ = makeSheet(kSide, kSide);
  cloud_.header.stamp = ros::Time::now();
  const sensor_msgs::PointCloud2ConstPtr before = client.exchange(cloud_);
  ASSERT_TRUE(before) << process.output();

  ToolArray array;
  array.tools.resize(1);
  Tool& tool = array.tools[0];
  tool.id = "scalpel";
  tool.mode = Tool::CUT;
  tool.primitive.type = shape_msgs::SolidPrimitive::CYLINDER;
  tool.primitive.dimensions = {0.2, 0.002};
  tool.pose.position.x = 0.045;
  tool.pose.position.y = -0.05;
  tool.twist.linear.y = 0.5;
  tools.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(client.step(45).success) << process.output();
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 0));  // else the next wait would end with the report of the first one

  array.tools.resize(2);
  array.tools[0].action = Tool::DELETE;
  Tool& hand = array.tools[1];
  hand.id = "hand";
  hand.mode = Tool::MOVE;
  hand.primitive.type = shape_msgs::SolidPrimitive::BOX;
  hand.primitive.dimensions = {0.05, 0.3, 0.3};
  hand.pose.position.x = 0.11;
  hand.twist.linear.x = 0.2;
  tools.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 2));
  ASSERT_TRUE(client.step(50).success) << process.output();
  const sensor_msgs::PointCloud2ConstPtr after = client.waitForFrame(stampAfter(95));
  ASSERT_TRUE(after) << process.output();
  for (int i = 0; i < kSide * kSide; ++i) {
    const double moved = readField(*after, i, "x") - readField(*before, i, "x");
    EXPECT_NEAR(moved, i % kSide < 5 ? 0.0 : 0.1, 0.02) << i;
  }
}

// It names what helps particles.
TEST_F(ParticlesTest, LagBehindTheClockIsTold) {
  NodeProcess process("/late",
                      "{model: oriented_particles, gravity: [0, 0, 0], simplification: {method: none}, "
                      "integrator: {time_step: 1.0e-6}}");
  NodeClient client("/late");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  cloud_ = makeSheet(8, 8);
  cloud_.header.stamp = ros::Time::now();
  ASSERT_TRUE(client.exchange(cloud_)) << process.output();
  EXPECT_TRUE(waitUntil([&] {
    const std::string output = process.output();
    return output.find("slower than real time: the last step took") != std::string::npos &&
           output.find("a larger oriented_particles.spacing") != std::string::npos;
  })) << process.output();
}

// With a surface without points every command is accepted or refused with a sentence, and the node continues.
TEST_F(ParticlesTest, AnEmptySurfaceAnswersEverything) {
  NodeProcess process("/emptied",
                      "{model: oriented_particles, gravity: [0, 0, -9.81], simplification: {method: none}, "
                      "save_directory: " +
                          testing::TempDir() + "}");
  NodeClient client("/emptied");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.pause(true).success);
  cloud_ = makeSheet(8, 8);
  cloud_.header.stamp = ros::Time::now();
  ASSERT_TRUE(client.exchange(cloud_)) << process.output();
  EditParticlesRequest edit;
  edit.action = EditParticlesRequest::DELETE;
  edit.ids.resize(64);
  std::iota(edit.ids.begin(), edit.ids.end(), 0);
  const EditParticlesResponse deleted = client.edit(edit);
  ASSERT_TRUE(deleted.success) << deleted.message;

  PointForce force;
  force.id = "pull";
  force.force.z = 1.0;
  client.publish(force);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1)) << process.output();
  const StepResponse stepped = client.step(3);
  EXPECT_TRUE(stepped.success) << stepped.message << process.output();

  SelectRegionRequest everything;
  everything.header.frame_id = cloud_.header.frame_id;
  everything.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
  everything.primitive.dimensions = {10.0};
  for (const char* service : {"pin", "unpin"}) {
    const SelectRegionResponse selected = client.select(service, everything);
    EXPECT_TRUE(selected.success || !selected.message.empty()) << service;
  }
  Snapshot kept;
  kept.request.name = "none";
  ASSERT_TRUE(ros::service::call("/emptied/snapshot", kept));
  EXPECT_TRUE(kept.response.success) << kept.response.message;
  Restore restored;
  restored.request.name = "none";
  ASSERT_TRUE(ros::service::call("/emptied/restore", restored));
  EXPECT_TRUE(restored.response.success) << restored.response.message;
  SetMaterial material;
  material.request.names = {"damping"};
  material.request.values = {2.0};
  ASSERT_TRUE(ros::service::call("/emptied/set_material", material));
  EXPECT_TRUE(material.response.success || !material.response.message.empty());
  const SaveCloudResponse saved = client.save("emptied_surface.ply");
  EXPECT_TRUE(saved.success || !saved.message.empty());
  std::remove((testing::TempDir() + "emptied_surface.ply").c_str());
  const GrowSurfaceResponse grown = client.growSurface(GrowSurfaceRequest());
  EXPECT_TRUE(grown.success || !grown.message.empty());
  actionlib::ActionClient<RolloutAction> rollouts(client.handle(), "rollout");
  ASSERT_TRUE(waitUntil([&] { return rollouts.isServerConnected(); })) << process.output();
  RolloutGoal goal;
  goal.duration = 0.1;
  const auto handle = rollouts.sendGoal(goal);
  EXPECT_TRUE(waitUntil([&] { return handle.getCommState() == actionlib::CommState::DONE; })) << process.output();

  // An added particle moves. A reset restores the others.
  edit = EditParticlesRequest();
  edit.poses.resize(1);
  EXPECT_TRUE(client.edit(edit).success);
  EXPECT_TRUE(client.step(2).success);
  EXPECT_TRUE(client.reset().success);
  const StepResponse again = client.step(2);
  EXPECT_TRUE(again.success) << again.message;
  EXPECT_TRUE(process.isRunning()) << process.output();
}

// A sheet that would grow by a hundred rows all around.
class GrowingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(client_.waitForNode()) << process_.output();
    cloud_ = makeSheet(20, 20);
    cloud_.header.stamp = ros::Time::now();
    client_.publish(cloud_);
    // Any frame: on a busy machine the first may be skipped.
    ASSERT_TRUE(waitUntil([&] { return !client_.frames.empty(); })) << process_.output();
    caller_ = std::thread([this] {
      GrowSurface exchange;
      exchange.request.edge_rows = 100;
      exchange.request.max_particles = 60000;
      is_answered_ = ros::service::call("/growing/grow_surface", exchange);
      answer_ = exchange.response;
    });
    ASSERT_TRUE(waitUntil([&] { return client_.diagnosticText("state") == "growing a surface"; })) << process_.output();
  }
  void TearDown() override {
    process_.send(SIGTERM);
    EXPECT_EQ(process_.waitForExit(), std::optional<int>(0)) << process_.output();
    if (caller_.joinable()) caller_.join();
  }

  NodeProcess process_{"/growing",
                       "{model: oriented_particles, gravity: [0, 0, 0], simplification: {method: none}, "
                       "oriented_particles: {growth: {max_passes: 10000}}}"};
  NodeClient client_{"/growing"};
  PointCloud2 cloud_;
  std::thread caller_;
  bool is_answered_ = false;
  GrowSurfaceResponse answer_;
};

TEST_F(GrowingTest, AnswersMeanwhileAndRefusesWhatWouldChangeTheSurface) {
  SelectRegionRequest everything;
  everything.header.frame_id = cloud_.header.frame_id;
  everything.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
  everything.primitive.dimensions = {10.0};
  const SelectRegionResponse pinned = client_.select("pin", everything);
  EXPECT_FALSE(pinned.success);
  EXPECT_NE(pinned.message.find("being grown"), std::string::npos) << pinned.message;
  const GrowSurfaceResponse second = client_.growSurface(GrowSurfaceRequest());
  EXPECT_FALSE(second.success);
  EXPECT_NE(second.message.find("being grown"), std::string::npos) << second.message;
  List list;
  ASSERT_TRUE(ros::service::call("/growing/list", list));
  EXPECT_TRUE(list.response.success) << list.response.message;
  EXPECT_EQ(client_.diagnosticText("state"), "growing a surface");
}

TEST_F(GrowingTest, AResetGoesFirst) {
  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("/growing/reset", reset));
  EXPECT_TRUE(reset.response.success) << reset.response.message;
  EXPECT_TRUE(client_.pause(true).success);
  const StepResponse stepped = client_.step(2);
  EXPECT_TRUE(stepped.success) << stepped.message;
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "particles_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
