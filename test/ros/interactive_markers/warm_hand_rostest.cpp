// A person draws a handle from the bare sheet of launch/handle.launch, slowly and with jerks of the mouse: the recipe of
// docs/rviz.md. The surface is paused and takes steps only once it has the commands, so that the result does not depend on the
// machine.
#include "../node_client.h"
#include "fake_rviz.h"

#include "deformable_surface/Restore.h"
#include "deformable_surface/Snapshot.h"
#include "deformable_surface/Tool.h"
#include "deformable_surface/ToolArray.h"
#include "deformable_surface/ToolStatusArray.h"
#include "deformable_surface/ToolWrenchArray.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <algorithm>
#include <set>

namespace deformable_surface::node::test {
namespace {

constexpr double kSpacing = 0.0345;                 // m, of the launch file
constexpr double kLongestEdge = 1.75 * kSpacing;    // of triangles, as where the scene's result is counted
constexpr int kSteps = 3;                           // at a time, as between two frames
constexpr double kFar = 0.3;                        // m: a jerk
constexpr double kFoot = -0.2794, kAnvil = 0.2794;  // m: x of the two ends of the handle

Eigen::Quaterniond makeTurn(double degrees) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * kPi / 180.0, Vec3::UnitY()));
}

class WarmHandTest : public ::testing::Test {
 protected:
  WarmHandTest() {
    points_ = client_.handle().subscribe<sensor_msgs::PointCloud2>(
        "simulation_points", 1, [this](const sensor_msgs::PointCloud2ConstPtr& m) { last_points_ = *m; });
    wrenches_ = client_.handle().subscribe<ToolWrenchArray>("tool_wrenches", 100, [this](const ToolWrenchArrayConstPtr& m) {
      contacts_.clear();
      for (const ToolWrench& wrench : m->wrenches) contacts_[wrench.id] = wrench.contacts;
    });
    statuses_ = client_.handle().subscribe<ToolStatusArray>("tool_status", 100, [this](const ToolStatusArrayConstPtr& m) {
      for (const ToolStatus& status : m->tools) {
        last_[status.id] = status;
        if (status.status == ToolStatus::REFUSED) refused_.insert(status.message);
        last_command_ = std::max(last_command_, status.header.seq);
      }
    });
  }

  /// The surface has a command to the tool that is younger than the given one. Only the last status is sure to come.
  bool has(std::uint8_t action, const std::string& tool, std::uint32_t before) const {
    const auto found = last_.find(tool);
    return found != last_.end() && found->second.action == action && found->second.header.seq > before;
  }

  /// At the foot.
  void addHand() {
    for (const char* name : {"surface", "spot", "panel"}) ASSERT_TRUE(rviz_.waitForMarker(name)) << name;
    rviz_.press("surface", Vec3::Zero(), foot_);
    rviz_.release("surface", Vec3::Zero());
    rviz_.choose("spot", "Warm hand");
    const auto findHand = [&] {
      for (const auto& [name, marker] : rviz_.markers)
        if (name.find("hand_") == 0) hand_ = name;
      return !hand_.empty();
    };
    ASSERT_TRUE(waitUntil(findHand));
    warmth_ = hand_ + "_warmth";
    drag(foot_, 0.0);
    EXPECT_EQ(contacts_.count(hand_), 0u);
  }

  bool isAnswered(const std::string& part) {
    return waitUntil([&] { return rviz_.findAnswer().text.find(part) != std::string::npos; });
  }

  /// Moves the marker, and waits until the program has it.
  void drag(const Vec3& position, double degrees) {
    const Eigen::Quaterniond turn = makeTurn(degrees);
    rviz_.drag(hand_, position, turn);
    ASSERT_TRUE(waitUntil([&] {
      const geometry_msgs::Pose& pose = rviz_.markers[hand_].pose;
      return pose.position.x == position.x() && pose.position.z == position.z() && pose.orientation.y == turn.y();
    }));
  }

  /// Chooses from the menu of the hand, and waits until the surface has its command.
  void choose(const std::string& title, std::uint8_t action = Tool::ADD) {
    const std::uint32_t before = last_command_;
    rviz_.choose(hand_, title);
    ASSERT_TRUE(waitUntil([&] { return has(action, hand_, before); })) << title;
  }

  /// Takes some steps, and waits for the commands for the next one; false: the hand has arrived, its warmth goes.
  bool takeSteps() {
    const std::uint32_t before = last_command_;
    const auto goesOn = [&] { return has(Tool::ADD, hand_, before) && has(Tool::ADD, warmth_, before); };
    EXPECT_TRUE(client_.step(kSteps).success);
    EXPECT_TRUE(waitUntil([&] { return goesOn() || has(Tool::DELETE, warmth_, before); }));
    return goesOn();
  }
  void waitForHand() {
    while (!HasFailure() && takeSteps()) {}
    ASSERT_TRUE(isAnswered("is at its marker"));
  }

  /// Not in one call, which must end in time.
  void rest() {
    StepResponse last;
    for (int i = 0; i < 10; ++i) {
      last = client_.step(kSteps);
      ASSERT_TRUE(last.success) << last.message;
    }
    RecordProperty("state_hash", std::to_string(last.state_hash));  // the same in every run
  }

  model::ParticleTopology measure() {
    EXPECT_TRUE(waitUntil([&] { return last_points_.header.stamp >= client_.frames.back()->header.stamp; }));
    Points positions, normals;
    for (std::size_t i = 0; i < last_points_.width; ++i) {
      positions.push_back(readPosition(last_points_, i));
      normals.emplace_back(readField(last_points_, i, "normal_x"), readField(last_points_, i, "normal_y"),
                           readField(last_points_, i, "normal_z"));
      normals.back().normalize();
    }
    return model::measureTopology(static_cast<Index>(positions.size()),
                                  model::triangulateParticles(positions, normals, kLongestEdge));
  }

  const Vec3 foot_{kFoot, 0.0, 0.0};
  std::string hand_, warmth_;
  NodeClient client_{"/deformable_surface"};
  FakeRviz rviz_{"/deformable_surface_interactive_markers", "world"};
  sensor_msgs::PointCloud2 last_points_;
  std::map<std::string, std::uint32_t> contacts_;
  std::map<std::string, ToolStatus> last_;  // of each tool
  std::set<std::string> refused_;           // reasons
  std::uint32_t last_command_ = 0;
  ros::Subscriber points_, wrenches_, statuses_;
};

TEST_F(WarmHandTest, DrawsAHandleSlowlyAndWithJerks) {
  ASSERT_TRUE(client_.waitForNode());
  ASSERT_NO_FATAL_FAILURE(addHand());
  rviz_.choose(hand_, "Take hold");
  ASSERT_TRUE(isAnswered("holds"));
  EXPECT_GT(contacts_[hand_], 50u);
  ASSERT_TRUE(client_.pause(true).success);
  ASSERT_TRUE(client_.reset().success);
  ASSERT_TRUE(isAnswered("has let go"));
  ASSERT_TRUE(waitUntil([&] { return contacts_.count(hand_) == 0; }));

  // A stem, slowly; a jerk ends before it leads anywhere.
  choose("Take hold");
  const double top = 8.0 * kSpacing;
  constexpr int kParts = 40;
  for (int i = 1; i <= kParts && !HasFailure(); ++i) {
    if (i % 10 == 0) rviz_.drag(hand_, foot_ + Vec3(kFar, kFar, kFar));
    drag(foot_ + Vec3(0.0, 0.0, top * i / kParts), 0.0);
    takeSteps();
  }
  ASSERT_NO_FATAL_FAILURE(waitForHand());

  // It is bent over, at once and with jerks, by eye: turned, then pulled along its axis, eight times.
  choose("Larger");
  choose("Take hold");
  constexpr int kBends = 8;
  const double turns[kBends] = {24.0, 43.0, 69.0, 92.0, 110.0, 136.0, 159.0, 180.0};
  const double lengths[kBends] = {0.11, 0.12, 0.10, 0.11, 0.11, 0.12, 0.10, 0.11};
  Vec3 at = foot_ + Vec3(0.0, 0.0, top);
  for (int i = 0; i < kBends && !HasFailure(); ++i) {
    drag(at, turns[i]);
    rviz_.drag(hand_, at - Vec3(kFar, 0.0, kFar), makeTurn(turns[i]));
    rviz_.drag(hand_, at, makeTurn(turns[i]));
    at += makeTurn(turns[i]) * Vec3(0.0, 0.0, lengths[i]);
    drag(at, turns[i]);
  }
  ASSERT_NO_FATAL_FAILURE(waitForHand());

  // And down onto the sheet above the anvil.
  drag(Vec3(kAnvil, 0.0, 0.15), 180.0);
  ASSERT_NO_FATAL_FAILURE(waitForHand());
  rest();
  EXPECT_TRUE(waitUntil([&] { return contacts_.count(hand_) > 0 && contacts_.count(warmth_) == 0; }));
  const model::ParticleTopology held = measure();
  EXPECT_EQ(held.components, 1);
  EXPECT_EQ(held.boundary_loops, 1);
  EXPECT_EQ(held.euler_characteristic, -1);
  EXPECT_EQ(held.isolated, 0);

  // It stays when the hand is gone.
  choose("Delete", Tool::DELETE);
  ASSERT_TRUE(waitUntil([&] { return rviz_.markers.count(hand_) == 0; }));
  rest();
  EXPECT_TRUE(waitUntil([&] { return contacts_.count(hand_) == 0; }));
  const model::ParticleTopology left = measure();
  EXPECT_EQ(left.components, 1);
  EXPECT_EQ(left.boundary_loops, 1);
  EXPECT_EQ(left.euler_characteristic, -1);
  EXPECT_EQ(left.isolated, 0);
}

// Whatever brings its tools back: a command that was on its way, or a snapshot.
TEST_F(WarmHandTest, LeavesNoToolBehindWhereItHasLetGo) {
  ASSERT_TRUE(client_.waitForNode());
  ASSERT_TRUE(rviz_.waitForMarker("spot"));
  ASSERT_TRUE(client_.pause(true).success);
  ASSERT_TRUE(client_.reset().success);
  ASSERT_NO_FATAL_FAILURE(addHand());
  const auto move = [&] {
    choose("Take hold");
    drag(foot_ + Vec3(0.0, 0.0, 0.28), 0.0);
    ASSERT_TRUE(takeSteps());
    ASSERT_TRUE(takeSteps());
    ASSERT_TRUE(isAnswered("holds"));
    ASSERT_TRUE(waitUntil([&] { return contacts_.count(hand_) + contacts_.count(warmth_) == 2; }));
  };
  const auto expectNoTool = [&] {
    EXPECT_TRUE(waitUntil([&] {
      EXPECT_TRUE(client_.step(1).success);
      return contacts_.count(hand_) + contacts_.count(warmth_) == 0;
    }));
  };
  const auto restore = [&] {
    Restore service;
    service.request.name = "moving";
    ASSERT_TRUE(ros::service::call("/deformable_surface/restore", service));
    ASSERT_TRUE(service.response.success) << service.response.message;
    ASSERT_TRUE(waitUntil([&] { return contacts_.count(hand_) + contacts_.count(warmth_) == 2; }));
  };

  ASSERT_NO_FATAL_FAILURE(move());
  Snapshot snapshot;
  snapshot.request.name = "moving";
  ASSERT_TRUE(ros::service::call("/deformable_surface/snapshot", snapshot));
  ASSERT_TRUE(snapshot.response.success) << snapshot.response.message;

  ASSERT_TRUE(client_.reset().success);
  ASSERT_TRUE(isAnswered("has let go"));
  ros::Publisher late = client_.handle().advertise<ToolArray>("tools", 10);
  ASSERT_TRUE(waitUntil([&] { return late.getNumSubscribers() > 0; }));
  ToolArray commands;
  for (const std::string& id : {hand_, warmth_}) {
    Tool command;
    command.header.frame_id = "world";
    command.header.seq = last_command_ + 1;
    command.id = id;
    command.mode = id == hand_ ? Tool::MOVE : Tool::HEAT;
    command.strength = id == hand_ ? 0.0 : 1.1;
    command.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
    command.primitive.dimensions = {0.1};
    command.pose.position.x = kFoot;
    command.pose.orientation.w = 1.0;
    commands.tools.push_back(command);
  }
  const std::uint32_t before = last_command_;
  late.publish(commands);
  ASSERT_TRUE(waitUntil([&] { return has(Tool::ADD, hand_, before) && has(Tool::ADD, warmth_, before); }));
  ASSERT_TRUE(client_.step(1).success);
  ASSERT_TRUE(waitUntil([&] { return contacts_.count(hand_) + contacts_.count(warmth_) == 2; }));
  expectNoTool();

  ASSERT_NO_FATAL_FAILURE(move());
  ASSERT_NO_FATAL_FAILURE(restore());
  ASSERT_TRUE(isAnswered("has let go"));
  expectNoTool();

  // Nor does it without its marker.
  rviz_.choose(hand_, "Delete");
  ASSERT_TRUE(waitUntil([&] { return rviz_.markers.count(hand_) == 0; }));
  ASSERT_NO_FATAL_FAILURE(restore());
  expectNoTool();
  EXPECT_TRUE(refused_.empty()) << *refused_.begin();
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "warm_hand_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
