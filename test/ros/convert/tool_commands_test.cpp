// Tools over ROS: conversion of messages, motion of a tool between two messages, and refused messages that change nothing.
#include "deformable_surface/ros/convert/tool_commands.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/convert/tool_decoder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <set>

namespace deformable_surface::node {
namespace {

using geometry::Solid;
using shape_msgs::SolidPrimitive;

constexpr double kStep = 0.01;  // s, the default

Tool makeBall(const std::string& id, const Vec3& position, double radius = 0.1) {
  Tool tool;
  tool.id = id;
  tool.primitive.type = SolidPrimitive::SPHERE;
  tool.primitive.dimensions = {radius};
  tool.pose.position.x = position.x();
  tool.pose.position.y = position.y();
  tool.pose.position.z = position.z();
  return tool;
}

/// Three edges of a metre along the axes.
shape_msgs::Mesh makeTetrahedron() {
  shape_msgs::Mesh mesh;
  mesh.vertices.resize(4);
  mesh.vertices[1].x = mesh.vertices[2].y = mesh.vertices[3].z = 1.0;
  for (const auto& corners : {std::array<std::uint32_t, 3>{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    mesh.triangles.emplace_back();
    for (int c = 0; c < 3; ++c) mesh.triangles.back().vertex_indices[c] = corners[c];
  }
  return mesh;
}

geometry_msgs::TransformStamped makeTransform(const std::string& child, const Vec3& position, double turn_about_z = 0.0) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "map";
  transform.child_frame_id = child;
  transform.transform.translation.x = position.x();
  transform.transform.translation.y = position.y();
  transform.transform.translation.z = position.z();
  transform.transform.rotation.z = std::sin(0.5 * turn_about_z);
  transform.transform.rotation.w = std::cos(0.5 * turn_about_z);
  return transform;
}

class ToolCommandsTest : public testing::Test {
 protected:
  ToolCommandsTest() : simulation_(makeSimulation()), commands_(std::make_unique<ToolCommands>(transforms_)) {}

  /// A sheet at rest, far below the tools.
  static simulation::Simulation makeSimulation() {
    cloud::PointCloud input;
    for (int i = 0; i < 100; ++i) input.positions.emplace_back(0.1 * (i % 10), 0.1 * (i / 10), -50.0);
    input.width = 100;
    simulation::SceneParams params;
    params.gravity.setZero();
    return {params, input};
  }

  void apply(const Tool& tool) { commands_->apply(tool, simulation_, "map"); }
  void step(int count = 1) {
    for (int i = 0; i < count; ++i) {
      for (const std::string& problem : commands_->move(ros::Time(), simulation_, "map")) problems_.push_back(problem);
      ASSERT_TRUE(simulation_.step().ok);
    }
  }
  const tool::ToolParams& only() const { return simulation_.tools().at(0); }
  tool::Pose pose() const { return tool::interpolate(only().path, simulation_.time()); }
  std::string refusal(const Tool& tool) {
    try {
      apply(tool);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  tf2::BufferCore transforms_;
  simulation::Simulation simulation_;
  std::unique_ptr<ToolCommands> commands_;
  std::vector<std::string> problems_;
};

TEST_F(ToolCommandsTest, BecomeEveryPrimitiveAndPlane) {
  Tool tool = makeBall("ball", Vec3(1, 2, 3), 0.25);
  tool.friction = 0.5;
  tool.kinetic_friction = 0.25;
  apply(tool);
  EXPECT_EQ(only().shape.kind, Solid::Kind::kSphere);
  EXPECT_EQ(only().shape.radius, 0.25);
  EXPECT_EQ(only().friction, 0.5);
  EXPECT_EQ(only().kinetic_friction.valueOr(0.0), 0.25);
  EXPECT_EQ(only().mode, tool::Mode::kSolid);
  EXPECT_EQ(pose().position, Vec3(1, 2, 3));

  tool.primitive.type = SolidPrimitive::BOX;
  tool.primitive.dimensions = {0.1, 0.2, 0.3};
  apply(tool);
  EXPECT_EQ(only().shape.kind, Solid::Kind::kBox);
  EXPECT_EQ(only().shape.size, Vec3(0.1, 0.2, 0.3));

  // Height, then radius, as in shape_msgs.
  tool.primitive.type = SolidPrimitive::CYLINDER;
  tool.primitive.dimensions = {0.5, 0.2};
  apply(tool);
  EXPECT_EQ(only().shape.kind, Solid::Kind::kCylinder);
  EXPECT_EQ(only().shape.height, 0.5);
  EXPECT_EQ(only().shape.radius, 0.2);
  tool.primitive.type = SolidPrimitive::CONE;
  apply(tool);
  EXPECT_EQ(only().shape.kind, Solid::Kind::kCone);
  EXPECT_EQ(only().shape.height, 0.5);

  // 3 y + 4 z - 10 = 0 lies two metres along its normal, and is solid towards the origin.
  tool.shape = Tool::PLANE;
  tool.plane.coef = {0.0, 3.0, 4.0, -10.0};
  apply(tool);
  EXPECT_NEAR(geometry::findSignedDistance(only().shape, Vec3::Zero()).distance, -2.0, 1e-15);
  EXPECT_NEAR(geometry::findSignedDistance(only().shape, Vec3(5.0, 2.0, 1.0)).distance, 0.0, 1e-15);
  EXPECT_EQ(simulation_.tools().size(), 1u);
}

TEST_F(ToolCommandsTest, DrawFromAsFarAsTheyAreLarge) {
  Tool tool = makeBall("magnet", Vec3::Zero(), 0.1);
  tool.mode = Tool::ATTRACT;
  tool.strength = 3.0;
  apply(tool);
  EXPECT_EQ(only().mode, tool::Mode::kAttract);
  EXPECT_EQ(only().reach, 0.2);
  tool.primitive.type = SolidPrimitive::CYLINDER;
  tool.primitive.dimensions = {0.5, 0.2};
  apply(tool);
  EXPECT_EQ(only().reach, 0.5);
}

TEST_F(ToolCommandsTest, AMeshIsASolidOfItsOwn) {
  Tool tool = makeBall("wedge", Vec3(0, 0, 1));
  tool.shape = Tool::MESH;
  tool.mesh = makeTetrahedron();
  tool.mode = Tool::ATTRACT;
  tool.strength = 1.0;
  apply(tool);
  ASSERT_EQ(only().shape.kind, Solid::Kind::kMesh);
  EXPECT_NEAR(only().shape.mesh->volume(), 1.0 / 6.0, 1e-15);
  EXPECT_EQ(only().reach, 1.0);
  EXPECT_NEAR(findSignedDistance(only().shape, Vec3(0.1, 0.2, 0.3)).distance, -0.1, 1e-15);
}

TEST_F(ToolCommandsTest, RefuseWhatMeansNothingAndKeepWhatThereIs) {
  apply(makeBall("ball", Vec3(1, 2, 3)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::function<void(Tool&)>, std::string>> wrong = {
      {[](Tool& t) { t.id = ""; }, "first a letter"},
      {[](Tool& t) { t.id = "two words"; }, "first a letter"},
      {[](Tool& t) { t.id = "1st"; }, "first a letter"},
      {[](Tool& t) { t.id = "a/b"; }, "first a letter"},
      {[](Tool& t) { t.id = std::string(65, 'a'); }, "up to 64"},
      {[](Tool& t) { t.action = 1; }, "action: found 1"},
      {[](Tool& t) { t.mode = 6; }, "mode: found 6"},
      {[](Tool& t) { t.mode = Tool::ERASE; }, "mode"},  // a sheet of springs has no particles
      {[](Tool& t) { t.shape = Tool::MESH; }, "mesh.triangles: found 0; accepted: 4 to 20000"},
      {[](Tool& t) {
         t.shape = Tool::MESH;
         t.mesh = makeTetrahedron();
         t.mesh.triangles.pop_back();
         t.mesh.triangles.push_back(t.mesh.triangles[0]);
       },
       "same direction"},
      {[](Tool& t) {
         t.shape = Tool::MESH;
         t.mesh = makeTetrahedron();
         t.mesh.triangles[0].vertex_indices[0] = 0xffffffffu;
       },
       "found the corner"},
      {[](Tool& t) { t.shape = 3; }, "shape: found 3"},
      {[](Tool& t) { t.primitive.type = 0; }, "primitive.type: found 0"},
      {[](Tool& t) { t.primitive.dimensions.clear(); }, "found 0 numbers; accepted: 1"},
      {[](Tool& t) { t.primitive.type = SolidPrimitive::BOX; }, "found 1 numbers; accepted: 3"},
      {[&](Tool& t) { t.primitive.dimensions[0] = nan; }, "radius"},
      {[](Tool& t) { t.primitive.dimensions[0] = 0.0; }, "radius"},
      {[](Tool& t) { t.shape = Tool::PLANE; }, "normal"},
      {[&](Tool& t) {
         t.shape = Tool::PLANE;
         t.plane.coef = {0, 0, 1, nan};
       },
       "offset"},
      {[&](Tool& t) { t.pose.position.x = nan; }, "pose"},
      {[](Tool& t) { t.pose.orientation.w = 2.0; }, "orientation of length 2"},
      {[&](Tool& t) { t.twist.linear.z = nan; }, "twist.linear"},
      {[&](Tool& t) { t.twist.angular.z = nan; }, "twist.angular"},
      {[](Tool& t) { t.twist.angular.z = 1e3; }, "twist.angular"},
      {[](Tool& t) { t.friction = -1.0; }, "friction"},
      {[&](Tool& t) { t.strength = nan; }, "strength"},
      {[](Tool& t) { t.mode = Tool::ATTRACT; }, "strength"},
      {[](Tool& t) { t.strength = 50.0; }, "strength: found 50.0, which mode solid of mass_spring does not use"},
      {[](Tool& t) {
         t.mode = Tool::ATTRACT;
         t.strength = 1.0;
         t.friction = 5.0;
       },
       "friction: found 5.0, which mode attract"},
      {[](Tool& t) {
         t.mode = Tool::MOVE;
         t.friction = 0.1;
       },
       "friction: found 0.1, which mode move"},
      {[](Tool& t) {
         t.mode = Tool::CUT;
         t.strength = 1.0;
       },
       "strength: found 1.0, which mode cut of mass_spring"},
      {[](Tool& t) {
         t.mode = Tool::CUT;
         t.shape = Tool::PLANE;
         t.plane.coef = {0, 0, 1, 0};
       },
       "found plane for mode cut"},
      {[](Tool& t) {
         t.mode = Tool::ATTRACT;
         t.shape = Tool::PLANE;
         t.plane.coef = {0, 0, 1, 0};
       },
       "PLANE that is to ATTRACT"},
      {[](Tool& t) { t.header.frame_id = "nowhere"; }, "nowhere"},
      {[](Tool& t) {
         t.action = Tool::DELETE;
         t.id = "other";
       },
       "no such tool"},
  };
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    Tool tool = makeBall("ball", Vec3(9, 9, 9));
    wrong[i].first(tool);
    const std::string sentence = refusal(tool);
    EXPECT_NE(sentence.find(wrong[i].second), std::string::npos) << i << ": " << sentence;
    EXPECT_EQ(sentence.rfind("tool '", 0), 0u) << i << ": " << sentence;
    EXPECT_NE(sentence.find("accepted"), std::string::npos) << i << ": " << sentence;
    ASSERT_EQ(simulation_.tools().size(), 1u) << i;
    EXPECT_EQ(only().path.size(), 1u) << i;
    EXPECT_EQ(only().path[0].position, Vec3(1, 2, 3)) << i;
  }
}

TEST_F(ToolCommandsTest, AreNoMoreThanAStatedNumber) {
  for (std::uint32_t i = 0; i < kMaxTools; ++i) apply(makeBall("ball" + std::to_string(i), Vec3::Zero()));
  EXPECT_NE(refusal(makeBall("one_more", Vec3::Zero())).find("100"), std::string::npos);
  EXPECT_EQ(refusal(makeBall("ball7", Vec3::UnitX())), "");
  Tool all;
  all.action = Tool::DELETEALL;
  apply(all);
  EXPECT_TRUE(simulation_.tools().empty());
  EXPECT_EQ(refusal(makeBall("one_more", Vec3::Zero())), "");
}

TEST_F(ToolCommandsTest, MoveToTheNewPoseInTheTimeSinceTheMessageBefore) {
  apply(makeBall("ball", Vec3::Zero()));
  step(4);
  apply(makeBall("ball", Vec3(0.4, 0.0, 0.0)));
  EXPECT_EQ(pose().position, Vec3::Zero());
  step(1);
  EXPECT_NEAR(pose().position.x(), 0.1, 1e-12);
  step(3);
  EXPECT_NEAR(pose().position.x(), 0.4, 1e-12);
  step(5);
  EXPECT_NEAR(pose().position.x(), 0.4, 1e-12);

  // A long silence does not become a slow motion, and two messages in one step are no jump.
  step(50);
  apply(makeBall("ball", Vec3(1.4, 0.0, 0.0)));
  step(5);
  EXPECT_NEAR(pose().position.x(), 0.9, 1e-12);
  apply(makeBall("ball", Vec3(7.0, 0.0, 0.0)));
  apply(makeBall("ball", Vec3(1.0, 0.0, 0.0)));
  EXPECT_NEAR(pose().position.x(), 0.9, 1e-12);
  step(1);
  EXPECT_NEAR(pose().position.x(), 1.0, 1e-12);
}

TEST_F(ToolCommandsTest, GoOnWithTheirTwist) {
  Tool tool = makeBall("ball", Vec3(1.0, 0.0, 0.0));
  tool.twist.linear.x = 2.0;
  tool.twist.angular.z = 3.0;
  apply(tool);
  step(100);
  EXPECT_NEAR(pose().position.x(), 3.0, 1e-12);
  EXPECT_NEAR(pose().orientation.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Vec3::UnitZ()))), 0.0, 1e-9);
  // Also at the end of a step, for the friction that is measured there.
  EXPECT_NEAR(tool::findMotion(only().path, simulation_.time()).velocity.x(), 2.0, 1e-9);
  EXPECT_NEAR(tool::findMotion(only().path, simulation_.time()).angular_velocity.z(), 3.0, 1e-9);

  // A tool that is added again is where the new motion has it after the time between two messages.
  tool.pose.position.x = 3.5;
  tool.twist.linear.x = 1.0;
  apply(tool);
  EXPECT_NEAR(pose().position.x(), 3.0, 1e-12);
  step(10);
  EXPECT_NEAR(pose().position.x(), 3.6, 1e-12);
  step(10);
  EXPECT_NEAR(pose().position.x(), 3.7, 1e-12);
}

TEST_F(ToolCommandsTest, StopWhenNoMessageComesForTheirTwist) {
  ToolCommands commands(transforms_, 0.095);
  Tool ball = makeBall("ball", Vec3::Zero());
  ball.twist.linear.x = 1.0;
  ball.twist.angular.z = 1.0;
  std::vector<std::string> problems;
  const auto go = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      for (const std::string& problem : commands.move(ros::Time(), simulation_, "map")) problems.push_back(problem);
      ASSERT_TRUE(simulation_.step().ok);
    }
  };
  commands.apply(ball, simulation_, "map");
  go(9);
  EXPECT_NEAR(pose().position.x(), 0.09, 1e-12);
  EXPECT_TRUE(commands.silent().empty());
  go(6);
  // Its place at the timeout, between two steps.
  EXPECT_NEAR(pose().position.x(), 0.095, 1e-12);
  EXPECT_NEAR(Eigen::AngleAxisd(pose().orientation).angle(), 0.095, 1e-9);
  EXPECT_EQ(commands.silent(), std::set<std::string>{"ball"});
  EXPECT_FALSE(commands.isMoving());
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0], "tool 'ball': no message for 0.095 s; its twist has ended, and its wrench is marked silent");

  // The next message, and each before its timeout.
  for (int k = 0; k < 5; ++k) {
    ball.pose.position.x = 0.095 + 0.05 * k;
    commands.apply(ball, simulation_, "map");
    go(5);
    EXPECT_TRUE(commands.silent().empty());
  }
  EXPECT_NEAR(pose().position.x(), 0.095 + 0.25, 1e-9);
  EXPECT_EQ(problems.size(), 1u);
}

TEST_F(ToolCommandsTest, AreInTheFrameOfTheirHeader) {
  transforms_.setTransform(makeTransform("hand", Vec3(1.0, 0.0, 0.0), M_PI / 2.0), "test", true);
  Tool tool = makeBall("ball", Vec3(1.0, 0.0, 0.0));
  tool.header.frame_id = "/hand";
  tool.twist.linear.x = 1.0;
  apply(tool);
  EXPECT_NEAR((pose().position - Vec3(1.0, 1.0, 0.0)).norm(), 0.0, 1e-12);
  step(10);
  EXPECT_NEAR((pose().position - Vec3(1.0, 1.1, 0.0)).norm(), 0.0, 1e-12);
}

// A ball above a frame that moves along x.
class FollowingTool : public ToolCommandsTest {
 protected:
  static constexpr double kBegin = 100.0;  // s of the clock at time 0

  void SetUp() override {
    ball_ = makeBall("ball", Vec3(0.0, 0.0, 5.0));
    ball_.header.frame_id = "hand";
    ball_.follow_frame = true;
  }
  void place(double x, double time) {
    geometry_msgs::TransformStamped transform = makeTransform("hand", Vec3(x, 0.0, 0.0));
    transform.header.stamp = ros::Time(kBegin + time);
    transforms_.setTransform(transform, "test");
  }
  void stepOnTheClock() {
    const ros::Time end(kBegin + simulation_.time() + simulation_.params().integrator.time_step);
    for (const std::string& problem : commands_->move(end, simulation_, "map")) problems_.push_back(problem);
    ASSERT_TRUE(simulation_.step().ok);
  }

  Tool ball_;
};

// A pin follows a frame as a tool does: its points are at the frame's pose in tf at the end of each step.
TEST_F(FollowingTool, PinsThatFollowAFrameCarryTheirPointsUntilTheyAreFreed) {
  place(1.0, 0.0);
  place(1.1, 0.1);
  std_msgs::Header header;
  header.frame_id = "hand";
  header.stamp = ros::Time(kBegin);
  geometry::Region edge;
  edge.min = Vec3(0.85, -1.0, -51.0);
  edge.max = Vec3(0.95, 2.0, -49.0);
  const Points rest = simulation_.state().positions;
  EXPECT_FALSE(commands_->isMoving());
  EXPECT_EQ(commands_->pinToFrame(header, edge, simulation_, "map"), 10);
  EXPECT_TRUE(commands_->isMoving());
  for (int k = 1; k <= 10; ++k) {
    stepOnTheClock();
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (edge.contains(rest[i]))
        EXPECT_LT((simulation_.state().positions[i] - rest[i] - Vec3(0.01 * k, 0.0, 0.0)).norm(), 1e-7) << k;
  }
  // Tools are added and removed beside it.
  Tool all;
  all.action = Tool::DELETEALL;
  apply(all);
  EXPECT_TRUE(commands_->isMoving());
  // A snapshot contains it, and it continues.
  const simulation::Snapshot saved = simulation_.snapshot();
  const ToolCommands::Memory memory = commands_->memory();
  place(1.2, 0.2);
  for (int k = 0; k < 10; ++k) stepOnTheClock();
  const std::uint64_t hash = simulation_.stateHash();
  simulation_.restore(saved);
  commands_->setMemory(memory);
  for (int k = 0; k < 10; ++k) stepOnTheClock();
  EXPECT_EQ(simulation_.stateHash(), hash);
  EXPECT_TRUE(problems_.empty());

  geometry::Region everywhere;
  everywhere.kind = geometry::Region::Kind::kSphere;
  everywhere.radius = 1e3;
  EXPECT_EQ(simulation_.unpin(everywhere), 10);
  stepOnTheClock();
  EXPECT_FALSE(commands_->isMoving());
  EXPECT_EQ(commands_->pinToFrame(header, geometry::Region(), simulation_, "map"), 0);
  EXPECT_FALSE(commands_->isMoving());
  header.frame_id = "nowhere";
  EXPECT_THROW(commands_->pinToFrame(header, everywhere, simulation_, "map"), InputError);
  EXPECT_FALSE(commands_->isMoving());
}

TEST_F(FollowingTool, IsWhereTfHasItsFrameAtTheEndOfEachStep) {
  place(1.0, 0.0);
  place(2.0, 0.1);
  ball_.header.stamp = ros::Time(kBegin);
  apply(ball_);
  for (int k = 1; k <= 10; ++k) {
    stepOnTheClock();
    EXPECT_NEAR((pose().position - Vec3(1.0 + 0.1 * k, 0.0, 5.0)).norm(), 0.0, 1e-7) << k;  // stamps are rounded to nanoseconds
  }
  EXPECT_TRUE(problems_.empty());
}

// Transforms that come late, and only at every third step: no jumps, and no stops between them.
TEST_F(FollowingTool, MovesEvenlyTowardsWhereItsFrameWasLastSeen) {
  place(0.0, -0.03);
  apply(ball_);
  std::vector<double> x;
  for (int k = 0; k < 30; ++k) {
    if (k % 3 == 0) place(0.01 * (k + 3), 0.01 * k);
    stepOnTheClock();
    x.push_back(pose().position.x());
  }
  for (std::size_t k = 4; k < x.size(); ++k) EXPECT_NEAR(x[k] - x[k - 1], 0.01, 1e-9) << k;
  EXPECT_NEAR(x.back(), 0.30, 1e-9);
  stepOnTheClock();
  EXPECT_NEAR(pose().position.x(), x.back(), 1e-12);  // no further notice: the frame exists
}

TEST_F(FollowingTool, IsSilentWhileNoTransformComes) {
  commands_ = std::make_unique<ToolCommands>(transforms_, 0.05);
  for (int k = 0; k <= 10; ++k) place(1.0 + 0.1 * k, 0.01 * k);
  apply(ball_);
  for (int k = 0; k < 15; ++k) stepOnTheClock();
  EXPECT_TRUE(commands_->silent().empty());
  for (int k = 0; k < 10; ++k) stepOnTheClock();
  EXPECT_EQ(commands_->silent(), std::set<std::string>{"ball"});
  EXPECT_NEAR(pose().position.x(), 2.0, 1e-9);
  ASSERT_EQ(problems_.size(), 1u);
  EXPECT_EQ(problems_[0],
            "tool 'ball': no transform of frame 'hand' for 0.05 s; it stays where it is, and its wrench is marked silent");
  place(3.0, 0.25);
  stepOnTheClock();
  EXPECT_TRUE(commands_->silent().empty());
}

TEST_F(FollowingTool, IsNotSilentOnAFrameThatNeverChanges) {
  commands_ = std::make_unique<ToolCommands>(transforms_, 0.05);
  transforms_.setTransform(makeTransform("hand", Vec3(1.0, 0.0, 0.0)), "test", true);
  apply(ball_);
  for (int k = 0; k < 20; ++k) stepOnTheClock();
  EXPECT_TRUE(commands_->silent().empty());
  EXPECT_TRUE(problems_.empty());
}

TEST_F(FollowingTool, StaysWhereItIsWhileItsFrameIsLost) {
  place(1.0, 0.0);
  apply(ball_);
  stepOnTheClock();
  transforms_.clear();
  stepOnTheClock();
  stepOnTheClock();
  EXPECT_NEAR(pose().position.x(), 1.0, 1e-12);
  ASSERT_EQ(problems_.size(), 2u);
  EXPECT_NE(problems_[0].find("tool 'ball'"), std::string::npos) << problems_[0];
  EXPECT_NE(problems_[0].find("stays where it is"), std::string::npos) << problems_[0];
  place(4.0, 0.03);
  for (int k = 0; k < 3; ++k) stepOnTheClock();
  EXPECT_NEAR(pose().position.x(), 4.0, 1e-12);
}

TEST_F(ToolCommandsTest, KeepWhatTheyHoldWhenTheyAreGivenAnew) {
  Tool tool = makeBall("hand", Vec3(0.4, 0.4, -50.0), 0.15);
  tool.mode = Tool::MOVE;
  apply(tool);
  step(3);
  const Index held = simulation_.toolReactions().at(0).contacts;
  EXPECT_GT(held, 0);
  tool.pose.position.z += 0.05;
  apply(tool);
  step(3);
  EXPECT_EQ(simulation_.toolReactions().at(0).contacts, held);
  double highest = -1e9;
  for (const Vec3& p : simulation_.state().positions) highest = std::max(highest, p.z());
  EXPECT_NEAR(highest, -50.0 + 0.05, 1e-9);
}

TEST_F(ToolCommandsTest, TakeOverToolsOfTheScene) {
  tool::ToolParams given;
  given.id = "ball";
  given.path.emplace_back();
  simulation_.setTool(given);
  apply(makeBall("ball", Vec3(1.0, 0.0, 0.0)));
  EXPECT_EQ(pose().position, Vec3::Zero());
  step(10);
  EXPECT_NEAR(pose().position.x(), 1.0, 1e-12);
  Tool gone;
  gone.action = Tool::DELETE;
  gone.id = "ball";
  apply(gone);
  EXPECT_TRUE(simulation_.tools().empty());
  step(1);
}

}  // namespace
}  // namespace deformable_surface::node
