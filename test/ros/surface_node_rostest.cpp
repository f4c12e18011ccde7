// What a client meets: the cloud that comes back, forces, and every service, with the node running in a process of its own.
#include "bad_clouds.h"
#include "node_client.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/ToolWrenchArray.h"

#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>
#include <limits>

namespace deformable_surface::node::test {
namespace {

constexpr int kColumns = 21, kRows = 15;
constexpr int kHole = 7;  // every such point is one; since the columns are a multiple, whole columns are
constexpr double kSpacing = 0.02;

/// A sheet as a depth camera would send it: organised, float64, padded, with an extra field and holes. It lies in z = 0 from the
/// origin on; its first columns are to be pinned.
sensor_msgs::PointCloud2 makeSurface(const ros::Time& stamp) {
  PointCloud2 cloud = makeSheet(kColumns, kRows, 32);
  cloud.header.stamp = stamp;
  cloud.header.frame_id = "camera";
  cloud.is_dense = false;
  cloud.fields = {makeField("intensity", 24), makeField("x", 0, PointField::FLOAT64), makeField("y", 8, PointField::FLOAT64),
                  makeField("z", 16, PointField::FLOAT64)};
  for (int i = 0; i < kColumns * kRows; ++i) {
    const bool is_hole = i % kHole == kHole - 1;
    write(cloud, 32 * i, kSpacing * (i % kColumns));
    write(cloud, 32 * i + 8, is_hole ? std::numeric_limits<double>::quiet_NaN() : kSpacing * (i / kColumns));
    write(cloud, 32 * i + 16, 0.0);
    write(cloud, 32 * i + 24, static_cast<float>(i));
  }
  return cloud;
}

std::size_t countOf(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

class SurfaceNodeTest : public ::testing::Test {
 protected:
  SurfaceNodeTest()
      : directory_(std::filesystem::temp_directory_path() / ("deformable_surface_save_" + std::to_string(getpid()))) {
    std::filesystem::create_directory(directory_);
    process_ = std::make_unique<NodeProcess>("/surface", R"(
model: mass_spring
material: {young_modulus: 1.0e5, thickness: 0.001, damping: 1.0}
gravity: [0, 0, 0]
pins: [{box: {min: [-1, -1, -1], max: [0.021, 1, 1]}}]
force: {radius: 0.05, timeout: 0.1}
output: {publish_rate: 100.0}
save_directory: )" + directory_.string());
    client_ = std::make_unique<NodeClient>("/surface");
  }
  ~SurfaceNodeTest() override { std::filesystem::remove_all(directory_); }

  void SetUp() override { ASSERT_TRUE(client_->waitForNode()) << process_->output(); }

  /// Paused, so that only ~step moves the surface.
  sensor_msgs::PointCloud2ConstPtr startPaused() {
    EXPECT_TRUE(client_->pause(true).success);
    cloud_ = makeSurface(ros::Time::now());
    return client_->exchange(cloud_);
  }
  ros::Time stampAfter(int steps) const { return cloud_.header.stamp + ros::Duration().fromNSec(10'000'000LL * steps); }

  std::filesystem::path directory_;
  std::unique_ptr<NodeProcess> process_;
  std::unique_ptr<NodeClient> client_;
  PointCloud2 cloud_;
};

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

TEST_F(SurfaceNodeTest, PinsAndFreesWhatLiesInAShape) {
  ASSERT_TRUE(startPaused());
  SelectRegionRequest far_end;
  far_end.primitive.type = shape_msgs::SolidPrimitive::BOX;
  far_end.primitive.dimensions = {0.1, 1.0, 1.0};
  far_end.pose.position.x = kSpacing * (kColumns - 1);
  const SelectRegionResponse pinned = client_->select("pin", far_end);
  EXPECT_TRUE(pinned.success) << pinned.message;
  EXPECT_GT(pinned.count, 0u);
  const int end = 7 * kColumns + kColumns - 2;
  const auto pull = [&] {
    client_->publish(makeForce("pull", Vec3(kSpacing * (kColumns - 1), 0.1, 0.0), Vec3(0.0, 0.0, 0.02), 0.05));
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 1));
  };
  pull();
  ASSERT_TRUE(client_->step(20).success);
  auto frame = client_->waitForFrame(stampAfter(20));
  ASSERT_TRUE(frame);
  EXPECT_LT(std::abs(readField(*frame, end, "z")), 1e-6);

  EXPECT_EQ(client_->select("unpin", far_end).count, pinned.count);
  ASSERT_TRUE(client_->step(20).success);
  frame = client_->waitForFrame(stampAfter(40));
  ASSERT_TRUE(frame);
  EXPECT_GT(readField(*frame, end, "z"), 1e-4);

  SelectRegionRequest wrong = far_end;
  wrong.pose.position.x = 100.0;
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.primitive.type = shape_msgs::SolidPrimitive::CONE;
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.primitive.dimensions[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.pose.orientation.z = wrong.pose.orientation.w = std::sqrt(0.5);
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.header.frame_id = "nowhere";
  EXPECT_NE(client_->select("pin", wrong).message.find("nowhere"), std::string::npos);
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
  // Nor does a link lead out of the directory.
  const std::filesystem::path outside = directory_.string() + "_outside.ply";
  std::filesystem::create_symlink(outside, directory_ / "link.ply");
  EXPECT_FALSE(client_->save("link.ply").success);
  EXPECT_FALSE(std::filesystem::exists(outside));
}

TEST_F(SurfaceNodeTest, AppliesAWrenchUntilItsTimeout) {
  ASSERT_TRUE(startPaused());
  int num_arrows = -1;
  const ros::Subscriber markers = client_->handle().subscribe<visualization_msgs::MarkerArray>(
      "markers", 10, [&](const visualization_msgs::MarkerArrayConstPtr& m) {
        num_arrows = 0;
        for (const auto& marker : m->markers)
          num_arrows += marker.ns == "forces" && marker.action == visualization_msgs::Marker::ADD;
      });
  ASSERT_TRUE(waitUntil([&] { return num_arrows == 0; }));
  ros::Publisher wrench = client_->handle().advertise<geometry_msgs::WrenchStamped>("wrench", 10);
  ASSERT_TRUE(waitUntil([&] { return wrench.getNumSubscribers() > 0; }));
  geometry_msgs::WrenchStamped message;
  message.header.frame_id = "camera";
  message.wrench.force.z = 0.01;
  wrench.publish(message);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(client_->step(10).success);  // as long as the timeout
  EXPECT_TRUE(waitUntil([&] { return num_arrows == 1; }));
  ASSERT_TRUE(client_->step(1).success);
  EXPECT_TRUE(waitUntil([&] { return num_arrows == 0; }));
}

TEST_F(SurfaceNodeTest, TakesForcesAndGravityFromTheirFrames) {
  const std::string scene = "{model: mass_spring, gravity: [0, 0, -1], gravity_frame: world, output: {publish_rate: 100.0}}";
  NodeProcess process("/tilted", scene);
  NodeClient client("/tilted");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud_));
  ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "waiting for the transform of gravity_frame"; }));
  ASSERT_TRUE(client.pause(true).success);
  EXPECT_FALSE(client.step(1).success);

  // The camera looks down along the world's x: what falls in the world moves along the camera's x.
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "world";
  transform.header.stamp = ros::Time::now();
  transform.child_frame_id = "camera";
  transform.transform.rotation.y = transform.transform.rotation.w = std::sqrt(0.5);
  tf2_ros::StaticTransformBroadcaster broadcaster;
  broadcaster.sendTransform(transform);
  ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "paused" && client.step(1).success; }));
  ASSERT_TRUE(client.step(9).success);
  auto frame = client.waitForFrame(stampAfter(10));
  ASSERT_TRUE(frame);
  const int free_point = 7 * kColumns + 3;
  const Vec3 fallen = readPosition(*frame, free_point) - readPosition(cloud_, free_point);
  EXPECT_NEAR(fallen.x(), 0.5 * 1.0 * 0.1 * 0.1, 1e-3);
  EXPECT_NEAR(fallen.z(), 0.0, 1e-6);

  // A force up in the world, on everything, of more than the weight.
  ASSERT_TRUE(client.reset().success);
  PointForce lift = makeForce("lift", Vec3::Zero(), Vec3(0.0, 0.0, 1.0), 10.0);
  lift.header.frame_id = "world";
  client.publish(lift);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(client.step(20).success);
  frame = client.waitForFrame(stampAfter(20));
  ASSERT_TRUE(frame);
  const Vec3 lifted = readPosition(*frame, free_point) - readPosition(cloud_, free_point);
  EXPECT_LT(lifted.x(), -0.01);
  EXPECT_NEAR(lifted.z(), 0.0, 1e-4);
}

TEST_F(SurfaceNodeTest, RefusesCommandsThatMeanNothing) {
  ASSERT_TRUE(startPaused());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<PointForce> wrong = {makeForce("", Vec3::Zero(), Vec3::UnitZ()),
                                   makeForce("a", Vec3(nan, 0, 0), Vec3::UnitZ()),
                                   makeForce("a", Vec3::Zero(), Vec3(0, nan, 0)),
                                   makeForce("a", Vec3::Zero(), Vec3::UnitZ(), -1.0),
                                   makeForce("a", Vec3::Zero(), Vec3::UnitZ(), 0.0, -1.0),
                                   makeForce("a", Vec3::Zero(), Vec3::UnitZ())};
  wrong.back().header.frame_id = "nowhere";
  for (const PointForce& force : wrong) client_->publish(force);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", wrong.size()));
  const std::uint64_t commanded = client_->step(1).state_hash;
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", wrong.size()));
  ASSERT_TRUE(client_->reset().success);
  EXPECT_EQ(client_->step(1).state_hash, commanded);

}

TEST_F(SurfaceNodeTest, RefusesToolsThatMeanNothingAndLosesNothing) {
  ASSERT_TRUE(startPaused());
  ros::Publisher tools = client_->handle().advertise<ToolArray>("tools", 10);
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0; }));
  const std::uint64_t before = client_->step(1).state_hash;
  ToolArray array;
  array.tools.resize(101);
  tools.publish(array);
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", 1));
  EXPECT_NE(client_->diagnosticText("last complaint").find("found 101 tools in a message"), std::string::npos);
  array.tools.resize(2);
  array.tools[0].id = "no name";
  array.tools[1].id = "sieve";
  array.tools[1].shape = Tool::MESH;
  tools.publish(array);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 2));
  ASSERT_TRUE(client_->step(1).success);
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", 3));
  EXPECT_NE(client_->diagnosticText("last complaint").find("tool 'sieve' mesh: found 0 triangles"),
            std::string::npos)
      << client_->diagnosticText("last complaint");
  ASSERT_TRUE(client_->reset().success);
  EXPECT_EQ(client_->step(1).state_hash, before);
}

TEST_F(SurfaceNodeTest, ATableCarriesTheWeightAndSaysSoInBothFrames) {
  NodeProcess process("/lying", "{model: mass_spring, gravity: [0, 0, -2], integrator: {type: static}}");
  NodeClient client("/lying");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ros::Publisher tools = client.handle().advertise<ToolArray>("tools", 10);
  ToolWrenchArray wrenches;
  const ros::Subscriber all = client.handle().subscribe<ToolWrenchArray>(
      "tool_wrenches", 10, [&](const boost::shared_ptr<const ToolWrenchArray>& m) { wrenches = *m; });
  geometry_msgs::WrenchStamped wrench;
  const ros::Subscriber one = client.handle().subscribe<geometry_msgs::WrenchStamped>(
      "tools/table/wrench", 10, [&](const geometry_msgs::WrenchStampedConstPtr& m) { wrench = *m; });
  double mass = 0.0;
  const ros::Subscriber points = client.handle().subscribe<PointCloud2>(
      "simulation_points", 10, [&](const sensor_msgs::PointCloud2ConstPtr& m) {
        mass = 0.0;
        for (std::size_t i = 0; i < m->width; ++i) mass += readField(*m, i, "mass");
      });
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0 && all.getNumPublishers() > 0; }));
  ASSERT_TRUE(client.pause(true).success);
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud_));

  // The table's own y axis is up, and so is its plane's normal.
  ToolArray array;
  array.tools.resize(1);
  Tool& table = array.tools[0];
  table.id = "table";
  table.shape = Tool::PLANE;
  table.plane.coef = {0.0, 1.0, 0.0, 0.0};
  table.pose.orientation.x = table.pose.orientation.w = std::sqrt(0.5);
  tools.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(waitUntil([&] { return client.step(1).success && one.getNumPublishers() > 0; }));
  ASSERT_TRUE(waitUntil([&] { return client.step(1).success && wrench.header.frame_id == "camera" && mass > 0.0; }));
  const double weight = 2.0 * mass;
  EXPECT_NEAR(wrench.wrench.force.z, -weight, 1e-5 * weight);
  EXPECT_NEAR(wrench.wrench.force.x, 0.0, 1e-12 * weight);
  ASSERT_TRUE(waitUntil([&] { return wrenches.header.stamp >= wrench.header.stamp && !wrenches.wrenches.empty(); }));
  ASSERT_EQ(wrenches.wrenches.size(), 1u);
  EXPECT_EQ(wrenches.wrenches[0].id, "table");
  EXPECT_NEAR(wrenches.wrenches[0].wrench.force.y, -weight, 1e-5 * weight);
  EXPECT_GT(wrenches.wrenches[0].contacts, 0u);
  EXPECT_GT(wrenches.wrenches[0].penetration, 0.0);

  array.tools[0].action = Tool::DELETE;
  tools.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(waitUntil([&] {
    client.pause(true);
    client.step(1);
    return wrenches.wrenches.empty();
  }));
}

TEST_F(SurfaceNodeTest, EditsParticlesAndGrowsASurfaceThroughThem) {
  NodeProcess process("/particles", "{model: oriented_particles, gravity: [0, 0, 0], simplification: {method: none}}");
  NodeClient client("/particles");
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

  const FitSurfaceResponse fitted = client.fit(FitSurfaceRequest());
  EXPECT_TRUE(fitted.success) << fitted.message;
  EXPECT_GE(fitted.particles, 144u);
  FitSurfaceRequest wrong;
  wrong.max_gap = -1.0;
  EXPECT_FALSE(client.fit(wrong).success);

  // Springs have none.
  ASSERT_TRUE(startPaused());
  const FitSurfaceResponse refused = client_->fit(FitSurfaceRequest());
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("accepted: oriented_particles"), std::string::npos) << refused.message;
}

TEST_F(SurfaceNodeTest, SaysOnWhichTopicItWaits) {
  // The node still runs, and its output is a file: nothing may be held back.
  EXPECT_TRUE(waitUntil([&] { return countOf("waiting for a cloud on /surface/cloud_in", process_->output()) == 1; }))
      << process_->output();
}

TEST_F(SurfaceNodeTest, TellsOfEveryCauseButNotOfEveryMessage) {
  ASSERT_TRUE(startPaused());
  client_->publish(makeForce("a", Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0), Vec3::UnitZ()));
  for (const double radius : {-1.0, -0.5, -12.0, -1e-7}) client_->publish(makeForce("a", Vec3::Zero(), Vec3::UnitZ(), radius));
  client_->publish(makeForce("b", Vec3::Zero(), Vec3::UnitZ(), 0.0, -1.0));
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 6));
  ASSERT_TRUE(client_->step(1).success);
  const std::string output = process_->output();
  EXPECT_EQ(countOf("force 'a' point: found", output), 1u) << output;
  EXPECT_EQ(countOf("force 'a' radius: found", output), 1u) << output;
  EXPECT_EQ(countOf("force 'b' duration: found", output), 1u) << output;
}

TEST_F(SurfaceNodeTest, TellsOnceOfAForceThatActsFarAwayOrOnPinnedPointsOnly) {
  ASSERT_TRUE(startPaused());
  const auto pull = [&](double height) {
    client_->publish(makeForce("far1", Vec3(0.4, 0.1, height), 1e-3 * Vec3::UnitZ(), 0.05));
    client_->publish(makeForce("far2", Vec3(0.4, 0.1, -height), 1e-3 * Vec3::UnitZ(), 0.05));
    client_->publish(makeForce("held", Vec3(0.0, 0.1, 0.0), 1e-3 * Vec3::UnitZ(), 0.021));
    client_->publish(makeForce("good", Vec3(0.2, 0.1, 0.0), 1e-3 * Vec3::UnitZ(), 0.05));
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 4));
    EXPECT_TRUE(client_->step(1).success);
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 0));
  };
  pull(1.0);
  pull(2.0);
  const std::string output = process_->output();
  const std::string far_away = ": no simulation point lies within its radius of 0.05 m; it acts on the nearest one, 1 m from";
  EXPECT_EQ(countOf("force 'far1'" + far_away, output), 1u) << output;
  EXPECT_EQ(countOf("force 'far2'" + far_away, output), 1u) << output;
  EXPECT_EQ(countOf("force 'held': all", output), 1u) << output;
  EXPECT_EQ(countOf("force 'good'", output), 0u) << output;
}

TEST(SurfaceNode, GoesOnAfterAFailedStepWhenItIsReset) {
  NodeProcess process("/surface", "{model: mass_spring, gravity: [0, 0, 0], output: {publish_rate: 100.0}}");
  NodeClient client("/surface");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  const PointCloud2 cloud = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud)) << process.output();
  for (int run = 1; run <= 2; ++run) {
    // So strong that a single step would carry its point out of all bounds.
    client.publish(makeForce("pull", Vec3(0.2, 0.1, 0.0), Vec3(0.0, 0.0, 1e12)));
    ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "stopped by a failed step"; })) << process.output();
    EXPECT_FALSE(client.step(1).success);  // the state before it is kept, and fails again
    client.frames.clear();
    ASSERT_TRUE(client.reset().success);
    // At rest first, and then steps, though nobody said ~pause false. Frames from before, at rest too, may still come.
    std::size_t rest = 0;
    const auto isAtRest = [](const sensor_msgs::PointCloud2& frame) {
      double largest = 0.0;
      for (int i = 0; i < kColumns * kRows; ++i) {
        if (i % kHole != kHole - 1) largest = std::max(largest, readField(frame, i, "displacement"));
      }
      return largest == 0.0;
    };
    ASSERT_TRUE(waitUntil([&] {
      const auto isBegin = [&](std::size_t k) {
        return isAtRest(*client.frames[k]) && client.frames[k + 2]->header.stamp > client.frames[k]->header.stamp;
      };
      while (rest + 2 < client.frames.size() && !isBegin(rest)) ++rest;
      return rest + 2 < client.frames.size();
    })) << process.output();
  }
  // Who paused before the failure finds it paused after the reset.
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
