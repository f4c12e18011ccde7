// Links of a robot as tools: conversion of a URDF, and how the tools follow the frames.
#include "deformable_surface/ros/convert/robot_tools.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/convert/tool_commands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace deformable_surface::node {
namespace {

class RobotToolsTest : public testing::Test {
 protected:
  RobotToolsTest() {
    std::string name = (std::filesystem::temp_directory_path() / "robot_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    // A tetrahedron with edges of a metre along the axes, as in STL files: corners repeated for every triangle.
    std::ofstream stl(folder_ / "tip.stl");
    const int corners[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const char* const places[4] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
    stl << "solid tip\n";
    for (const auto& t : corners) {
      stl << "facet normal 0 0 0\nouter loop\n";
      for (int c : t) stl << "vertex " << places[c] << "\n";
      stl << "endloop\nendfacet\n";
    }
    stl << "endsolid tip\n";
  }
  ~RobotToolsTest() override { std::filesystem::remove_all(folder_); }

  std::string makeUrdf() const {
    return "<robot name='arm'><link name='base'/>"
           "<link name='hand.1'>"
           "<collision><origin xyz='0 0 0.5' rpy='0 1.5707963267948966 0'/><geometry><cylinder radius='0.1' "
           "length='0.4'/></geometry></collision>"
           "<collision><origin xyz='0 0 1'/><geometry><mesh filename='file://" +
           (folder_ / "tip.stl").string() +
           "' scale='0.1 0.1 0.1'/></geometry></collision></link>"
           "<joint name='wrist' type='fixed'><parent link='base'/><child link='hand.1'/></joint></robot>";
  }

  std::filesystem::path folder_;
};

TEST_F(RobotToolsTest, EveryPieceOfCollisionGeometryIsAToolThatFollowsItsLink) {
  const std::vector<Tool> tools = makeRobotTools(makeUrdf(), {{"hand.1", 0.3}});
  ASSERT_EQ(tools.size(), 2u);
  EXPECT_EQ(tools[0].id, "hand_1");
  EXPECT_EQ(tools[1].id, "hand_1_1");
  for (const Tool& tool : tools) {
    EXPECT_EQ(tool.header.frame_id, "hand.1");
    EXPECT_TRUE(tool.follow_frame);
    EXPECT_EQ(tool.friction, 0.3);
    EXPECT_EQ(tool.mode, int{Tool::SOLID});
  }
  EXPECT_EQ(tools[0].primitive.type, int{shape_msgs::SolidPrimitive::CYLINDER});
  EXPECT_EQ(tools[0].primitive.dimensions, (std::vector<double>{0.4, 0.1}));
  EXPECT_EQ(tools[0].pose.position.z, 0.5);
  EXPECT_NEAR(tools[0].pose.orientation.y, std::sqrt(0.5), 1e-12);
  EXPECT_EQ(tools[1].shape, int{Tool::MESH});
  EXPECT_EQ(tools[1].mesh.vertices.size(), 4u);
}

TEST_F(RobotToolsTest, WaitForTheirFrameAndThenGoWithIt) {
  cloud::PointCloud input;
  for (int i = 0; i < 100; ++i) input.positions.emplace_back(0.1 * (i % 10), 0.1 * (i / 10), -50.0);
  input.width = 100;
  simulation::SceneParams params;
  params.gravity.setZero();
  simulation::Simulation simulation(params, input);
  tf2::BufferCore transforms;
  ToolCommands commands(transforms);
  commands.setStanding(makeRobotTools(makeUrdf(), {{"hand.1", 0.0}}));
  EXPECT_EQ(commands.move(ros::Time(), simulation, "map").size(), 2u);  // a sentence each
  EXPECT_TRUE(simulation.tools().empty());
  const auto place = [&](double x) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "map";
    transform.child_frame_id = "hand.1";
    transform.transform.translation.x = x;
    transform.transform.rotation.w = 1.0;
    transforms.setTransform(transform, "test", true);
  };
  place(3.0);
  EXPECT_TRUE(commands.move(ros::Time(), simulation, "map").empty());
  ASSERT_EQ(simulation.tools().size(), 2u);
  EXPECT_NEAR((tool::interpolate(simulation.tools()[0].path, 0.0).position - Vec3(3.0, 0.0, 0.5)).norm(), 0.0, 1e-12);
  simulation.step();
  place(4.0);
  EXPECT_TRUE(commands.move(ros::Time(), simulation, "map").empty());
  simulation.step();
  EXPECT_NEAR(tool::interpolate(simulation.tools()[1].path, simulation.time()).position.x(), 4.0, 1e-12);

  // A deleted tool stays deleted until everything is reset.
  for (const char* id : {"hand_1", "hand_1_1"}) {
    Tool gone;
    gone.id = id;
    gone.action = Tool::DELETE;
    commands.apply(gone, simulation, "map");
  }
  commands.move(ros::Time(), simulation, "map");
  EXPECT_TRUE(simulation.tools().empty());
  simulation.reset();
  commands.forget();
  commands.move(ros::Time(), simulation, "map");
  EXPECT_EQ(simulation.tools().size(), 2u);
}

TEST_F(RobotToolsTest, NamesThatMakeNoToolOfTheirOwnAreRefused) {
  const auto refusal = [](const std::vector<std::string>& names) -> std::string {
    const std::string piece = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
    std::string urdf = "<robot name='arm'>";
    std::vector<tool::RobotLinkParams> links;
    for (const std::string& name : names) {
      if (urdf.find("'" + name + "'") == std::string::npos) urdf += "<link name='" + name + "'>" + piece + piece + "</link>";
      links.push_back({name, 0.0});
    }
    for (std::size_t k = 1; k < names.size() && names[k] != names[0]; ++k)
      urdf += "<joint name='j" + std::to_string(k) + "' type='fixed'><parent link='" + names[0] + "'/><child link='" + names[k] +
              "'/></joint>";
    try {
      makeRobotTools(urdf + "</robot>", links);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({"left_pad", "right_pad"}), "");
  EXPECT_NE(refusal({"left-pad", "left_pad"}).find("'left-pad' and 'left_pad' both become the tool 'left_pad'"),
            std::string::npos)
      << refusal({"left-pad", "left_pad"});
  EXPECT_NE(refusal({"pad", "pad.1"}).find("both become the tool 'pad_1'"), std::string::npos);
  EXPECT_NE(refusal({"pad", "pad"}).find("'pad' and 'pad' both become"), std::string::npos);
  const std::string longest(64, 'a');  // the id of its second piece is longer
  EXPECT_NE(refusal({longest}).find("accepted: names that give ids of up to 64 characters"), std::string::npos);
}

TEST_F(RobotToolsTest, WhatIsNotThereIsRefusedWithItsName) {
  const auto refusal = [](const std::string& urdf, const std::string& link) -> std::string {
    try {
      makeRobotTools(urdf, {{link, 0.0}});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal("no xml", "hand").find("cannot be read"), std::string::npos);
  EXPECT_NE(refusal(makeUrdf(), "foot").find("no link 'foot'"), std::string::npos);
  EXPECT_NE(refusal(makeUrdf(), "base").find("no collision geometry"), std::string::npos);
  const std::string missing =
      "<robot name='a'><link name='l'><collision><geometry><mesh "
      "filename='file:///nowhere.stl'/></geometry></collision></link></robot>";
  EXPECT_NE(refusal(missing, "l").find("nowhere.stl"), std::string::npos) << refusal(missing, "l");
  EXPECT_THROW(readDescription("/nowhere.urdf"), InputError);
}

}  // namespace
}  // namespace deformable_surface::node
