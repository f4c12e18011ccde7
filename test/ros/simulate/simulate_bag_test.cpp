// Input of `simulate` from a bag: clouds, forces, wrenches and tools at their stamps, and bags that it refuses.
#include "simulate_fixture.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/ToolWrenchArray.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/point_files.h"

#include <geometry_msgs/WrenchStamped.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

namespace deformable_surface::node::test {
namespace {

using SimulateBag = Simulate;

TEST_F(SimulateBag, TakesCloudsAndForcesFromABagInTheOrderOfTheirStamps) {
  // Recorded first, but stamped after the cloud: it acts from the first step at or after 0.045 s on, so for 5 steps.
  writeBag("in.bag", [](rosbag::Bag& bag) { bag.write("/pushes", ros::Time(kStart - 1.0), makeForce(kStart + 0.045, 1.0)); });
  EXPECT_EQ(
      run({"--bag_in", path("in.bag"), "--topic", "force=/pushes", "--bag_out", path("out.bag"), "--final", path("out.ply")}), 0)
      << err_;
  EXPECT_EQ(err_, "");
  const cloud::PointCloud cloud = io::readPointFile(path("out.ply"), 1.0, 1000);
  ASSERT_EQ(cloud.size(), 100);
  // One newton on 0.81 kg: the sheet measures 0.9 m by 0.9 m and weighs 1 kg/m^2.
  EXPECT_NEAR(cloud.positions[55].z(), 0.5 / 0.81 * 0.05 * 0.05, 1e-6);
  const rosbag::Bag bag(path("out.bag"));
  EXPECT_EQ(rosbag::View(bag).getBeginTime(), ros::Time(kStart));
  EXPECT_NEAR(rosbag::View(bag).getEndTime().toSec(), kStart + 0.1, 1e-6);
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    if (const auto deformed = message.instantiate<sensor_msgs::PointCloud2>()) {
      EXPECT_EQ(deformed->header.frame_id, "sheet");
    }
  }
}

TEST_F(SimulateBag, TakesAForceWithoutAStampFromTheStepInWhichItWasRecorded) {
  // It begins at 0.04 s, so it is 6 steps long.
  writeBag("in.bag", [](rosbag::Bag& bag) { bag.write("/pushes", ros::Time(kStart + 0.045), makeForce(0.0, 1.0)); });
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--topic", "force=/pushes", "--final", path("out.ply")}), 0) << err_;
  EXPECT_NEAR(io::readPointFile(path("out.ply"), 1.0, 1000).positions[55].z(), 0.5 / 0.81 * 0.06 * 0.06, 1e-6);
}

TEST_F(SimulateBag, TakesTopicsWithAndWithoutALeadingSlash) {
  {
    rosbag::Bag bag(path("in.bag"), rosbag::bagmode::Write);
    bag.write("deformable_surface/cloud_in", ros::Time(kStart), makeCloud(ros::Time(kStart)));
    bag.write("/pushes", ros::Time(kStart), makeForce(kStart, 1.0));
  }
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--topic", "force=pushes"}), 0) << err_;
  EXPECT_NE(out_.find("clouds 1, forces 1, wrenches 0"), std::string::npos) << out_;
}

TEST_F(SimulateBag, RefusesATopicThatTheBagDoesNotHave) {
  writeBag("in.bag", [](rosbag::Bag& bag) { bag.write("/pushes", ros::Time(kStart), makeForce(kStart, 1.0)); });
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--topic", "force=/pulls"}), 2);
  EXPECT_NE(err_.find("'/pulls'"), std::string::npos) << err_;
  EXPECT_NE(err_.find("one of '/pushes'"), std::string::npos) << err_;
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--topic", "wrench=/wrench"}), 2);
  EXPECT_NE(err_.find("this bag has none"), std::string::npos) << err_;
}

TEST_F(SimulateBag, CountsTheCommandsThatCameAfterItsEnd) {
  writeBag("in.bag", [](rosbag::Bag& bag) {
    for (const double time : {0.05, 0.1, 0.15, 2.5})
      bag.write("/deformable_surface/force", ros::Time(kStart + time), makeForce(kStart + time, 1.0));
  });
  EXPECT_EQ(run({"--bag_in", path("in.bag")}), 0) << err_;
  EXPECT_NE(out_.find("clouds 1, forces 1, wrenches 0"), std::string::npos) << out_;
  EXPECT_NE(out_.find("3 of 5 clouds and commands, from 0.1 to 2.5 s after the first cloud; the run ended at 0.1 s"),
            std::string::npos)
      << out_;
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--duration", "0.2"}), 0) << err_;
  EXPECT_NE(out_.find("1 of 5 clouds and commands, from 2.5 to 2.5 s"), std::string::npos) << out_;
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--duration", "2.6"}), 0) << err_;
  EXPECT_EQ(out_.find("not taken"), std::string::npos) << out_;
}

TEST_F(SimulateBag, LooksAtNoExpectationsOfTheScenesOwnCloud) {
  writeBag("in.bag", [](rosbag::Bag&) {});
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--set", "expect={max_displacement: [1, 2]}"}), 0) << err_;
  EXPECT_EQ(out_.find("not as expected"), std::string::npos) << out_;
  EXPECT_NE(out_.find("note: expect is not checked"), std::string::npos) << out_;
}

TEST_F(SimulateBag, EndsAForceAfterItsDuration) {
  writeBag("in.bag",
           [](rosbag::Bag& bag) { bag.write("/deformable_surface/force", ros::Time(kStart), makeForce(kStart, 1.0, 0.02)); });
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--final", path("out.ply")}), 0) << err_;
  const double fall = io::readPointFile(path("out.ply"), 1.0, 1000).positions[55].z();
  // Two steps under the force, then eight at the speed that it caused.
  EXPECT_NEAR(fall, 1.0 / 0.81 * (0.5 * 0.02 * 0.02 + 0.02 * 0.08), 1e-6);
}

TEST_F(SimulateBag, BringsTheCloudIntoTheFrameOfTheScene) {
  // Upside down, one metre up.
  writeBag("in.bag", [](rosbag::Bag& bag) {
    geometry_msgs::TransformStamped sheet;
    sheet.header.frame_id = "room";
    sheet.header.stamp = ros::Time(kStart);
    sheet.child_frame_id = "sheet";
    sheet.transform.translation.z = 1.0;
    sheet.transform.rotation.x = 1.0;
    tf2_msgs::TFMessage transforms;
    transforms.transforms.push_back(sheet);
    bag.write("/tf_static", ros::Time(kStart), transforms);
  });
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--set", "frame_id=room", "--final", path("out.ply")}), 0) << err_;
  const cloud::PointCloud cloud = io::readPointFile(path("out.ply"), 1.0, 1000);
  EXPECT_TRUE(cloud.positions[58].isApprox(Vec3(0.8, -0.5, 1.0), 1e-6)) << cloud.positions[58];
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--set", "frame_id=nowhere"}), 2);
  EXPECT_NE(err_.find("there is no transform from frame 'sheet' to 'nowhere'"), std::string::npos) << err_;
}

TEST_F(SimulateBag, AppliesAWrenchAtItsFrameUntilTheTimeout) {
  writeBag("in.bag", [](rosbag::Bag& bag) {
    // The tip's z axis points along -z of the sheet.
    geometry_msgs::TransformStamped tip;
    tip.header.frame_id = "sheet";
    tip.header.stamp = ros::Time(kStart);
    tip.child_frame_id = "tip";
    tip.transform.translation.x = tip.transform.translation.y = 0.45;
    tip.transform.rotation.x = 1.0;
    tf2_msgs::TFMessage transforms;
    transforms.transforms.push_back(tip);
    bag.write("/tf_static", ros::Time(kStart), transforms);
    geometry_msgs::WrenchStamped wrench;
    wrench.header.frame_id = "tip";
    wrench.header.stamp = ros::Time(kStart);
    wrench.wrench.force.z = 1.0;
    bag.write("/deformable_surface/wrench", ros::Time(kStart), wrench);
    wrench.header.frame_id = "nowhere";
    bag.write("/deformable_surface/wrench", ros::Time(kStart), wrench);
  });
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--set", "force={radius: 2.0, timeout: 0.02}", "--final", path("out.ply")}), 0)
      << err_;
  const double rise = io::readPointFile(path("out.ply"), 1.0, 1000).positions[55].z();
  EXPECT_NEAR(rise, -1.0 / 0.81 * (0.5 * 0.02 * 0.02 + 0.02 * 0.08), 1e-6);
  EXPECT_EQ(countLines(err_), 1u) << err_;
  EXPECT_NE(err_.find("nowhere"), std::string::npos) << err_;
}

/// The frame "hand" moves along x through the sheet for twelve seconds; a transform every centisecond.
void writeHand(rosbag::Bag& bag, double begin = 0.0) {
  for (int k = 0; k <= 1200; ++k) {
    if (0.01 * k < begin) continue;
    tf2_msgs::TFMessage transforms;
    transforms.transforms.resize(1);
    geometry_msgs::TransformStamped& hand = transforms.transforms[0];
    hand.header.frame_id = "sheet";
    hand.header.stamp = ros::Time(kStart + 0.01 * k);
    hand.child_frame_id = "hand";
    hand.transform.translation.x = 0.1 + 0.05 * k;
    hand.transform.translation.y = 0.45;
    hand.transform.rotation.w = 1.0;
    bag.write("/tf", hand.header.stamp, transforms);
  }
}

PointForce makePush(double stamp) {
  PointForce push;
  push.header.frame_id = "hand";
  push.header.stamp = ros::Time(stamp);
  push.id = "push";
  push.force.z = 1.0;
  push.radius = 0.15;
  return push;
}

// Recorded between two steps, without a stamp, or with the stamp of the step and of the newest transform: the same result.
TEST_F(SimulateBag, ACommandWithoutAStampMeansItsFrameAsItWasWhenItWasRecorded) {
  const auto hashOf = [&](const std::string& topic, double stamp) {
    writeBag("in.bag", [&](rosbag::Bag& bag) {
      writeHand(bag);
      const ros::Time recorded(kStart + 0.045);
      geometry_msgs::WrenchStamped wrench;
      ToolArray array;
      array.tools.resize(1);
      Tool& grip = array.tools[0];
      grip.id = "grip";
      grip.mode = Tool::MOVE;
      grip.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
      grip.primitive.dimensions = {0.12};
      grip.twist.linear.z = 1.0;
      grip.header.frame_id = wrench.header.frame_id = "hand";
      grip.header.stamp = wrench.header.stamp = ros::Time(stamp);
      wrench.wrench.force.z = 1.0;
      if (topic == "force") bag.write("/deformable_surface/force", recorded, makePush(stamp));
      if (topic == "wrench") bag.write("/deformable_surface/wrench", recorded, wrench);
      if (topic == "tools") bag.write("/deformable_surface/tools", recorded, array);
    });
    EXPECT_EQ(run({"--bag_in", path("in.bag")}), 0) << err_;
    EXPECT_EQ(err_, "");
    return out_.substr(out_.find("state hash"));
  };
  const std::string at_rest = hashOf("none", 0.0);
  for (const char* topic : {"force", "wrench", "tools"}) {
    EXPECT_EQ(hashOf(topic, 0.0), hashOf(topic, kStart + 0.04)) << topic;
    EXPECT_NE(hashOf(topic, 0.0), at_rest) << topic;
  }
}

TEST_F(SimulateBag, ACommandWithoutAStampWaitsForItsFrameAsTheNodeDoes) {
  const auto hashOf = [&](double begin, double stamp, double recorded) {
    writeBag("in.bag", [&](rosbag::Bag& bag) {
      writeHand(bag, begin);
      bag.write("/deformable_surface/force", ros::Time(kStart + recorded), makePush(stamp));
    });
    EXPECT_EQ(run({"--bag_in", path("in.bag")}), 0) << err_;
    return out_.substr(out_.find("state hash"));
  };
  // From the step at the time of the first transform, which begins before it.
  EXPECT_EQ(hashOf(0.06, 0.0, 0.025), hashOf(0.0, kStart + 0.06, 0.06));
  EXPECT_EQ(err_, "");
  // Longer than the node waits.
  hashOf(3.0, 0.0, 0.025);
  EXPECT_EQ(countLines(err_), 1u) << err_;
  EXPECT_NE(err_.find("found 'hand' without a stamp, and no transform to 'sheet'"), std::string::npos) << err_;
}

TEST_F(SimulateBag, TakesToolsFromABagAtTheirStampsAndWritesTheirWrenches) {
  writeBag("in.bag", [](rosbag::Bag& bag) {
    // A tool grips the whole sheet, and lifts it from 0.03 s on. The second tool of the array is stamped before the first.
    ToolArray array;
    array.tools.resize(2);
    Tool& lift = array.tools[0];
    lift.id = "hand";
    lift.mode = Tool::MOVE;
    lift.header.stamp = ros::Time(kStart + 0.03);
    lift.header.frame_id = "sheet";
    lift.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
    lift.primitive.dimensions = {5.0};
    array.tools[1] = lift;
    array.tools[1].header.stamp = ros::Time(kStart);
    lift.pose.position.z = 0.3;
    bag.write("/deformable_surface/tools", ros::Time(kStart - 1.0), array);
    array.tools.resize(1);
    array.tools[0].header.frame_id = "nowhere";
    bag.write("/deformable_surface/tools", ros::Time(kStart), array);
  });
  EXPECT_EQ(
      run({"--bag_in", path("in.bag"), "--set", "gravity=[0, 0, -2]", "--final", path("out.ply"), "--bag_out", path("out.bag")}),
      0)
      << err_;
  // The three hundredths of a second since the previous message were enough.
  EXPECT_NEAR(io::readPointFile(path("out.ply"), 1.0, 1000).positions[55].z(), 0.3, 1e-6);
  EXPECT_EQ(countLines(err_), 1u) << err_;
  EXPECT_NE(err_.find("nowhere"), std::string::npos) << err_;
  EXPECT_NE(out_.find("commands to tools 2"), std::string::npos) << out_;
  const rosbag::Bag bag(path("out.bag"));
  ToolWrenchArray last;
  for (const rosbag::MessageInstance& message : rosbag::View(bag))
    if (const auto wrenches = message.instantiate<ToolWrenchArray>()) last = *wrenches;
  ASSERT_EQ(last.wrenches.size(), 1u);
  EXPECT_EQ(last.wrenches[0].id, "hand");
  EXPECT_NEAR(last.wrenches[0].wrench.force.z, -0.81 * 2.0, 1e-6);  // the weight of 0.81 kg
  EXPECT_EQ(last.header.frame_id, "sheet");
}

TEST_F(SimulateBag, ReplacesTheSurfaceByALaterCloudUnlessToldToIgnoreIt) {
  writeBag("in.bag", [](rosbag::Bag& bag) {
    bag.write("/deformable_surface/cloud_in", ros::Time(kStart + 0.05), makeCloud(ros::Time(kStart + 0.05)));
  });
  const std::vector<std::string> arguments{"--bag_in", path("in.bag"), "--set", "gravity=[0, 0, -2]", "--final", path("out.ply")};
  EXPECT_EQ(run(arguments), 0) << err_;
  EXPECT_NEAR(io::readPointFile(path("out.ply"), 1.0, 1000).positions[55].z(), -0.05 * 0.05, 1e-6);
  std::vector<std::string> ignoring = arguments;
  ignoring.insert(ignoring.end(), {"--set", "input.policy=ignore"});
  EXPECT_EQ(run(ignoring), 0) << err_;
  EXPECT_NEAR(io::readPointFile(path("out.ply"), 1.0, 1000).positions[55].z(), -0.1 * 0.1, 1e-6);
}

TEST_F(SimulateBag, SkipsARefusedCloudAndSaysSo) {
  {
    rosbag::Bag bag(path("in.bag"), rosbag::bagmode::Write);
    sensor_msgs::PointCloud2 broken = makeCloud(ros::Time(kStart));
    broken.data.resize(10);
    bag.write("/points", ros::Time(kStart), broken);
    bag.write("/points", ros::Time(kStart + 1.0), makeCloud(ros::Time(kStart + 1.0)));
  }
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--topic", "cloud_in=/points", "--bag_out", path("out.bag")}), 0) << err_;
  EXPECT_EQ(countLines(err_), 1u) << err_;
  const rosbag::Bag bag(path("out.bag"));
  EXPECT_EQ(rosbag::View(bag).getBeginTime(), ros::Time(kStart + 1.0));
}

TEST_F(SimulateBag, RefusesBagsThatItCannotUse) {
  writeBag("in.bag",
           [](rosbag::Bag& bag) { bag.write("/deformable_surface/force", ros::Time(kStart), geometry_msgs::WrenchStamped()); });
  EXPECT_EQ(run({"--bag_in", path("in.bag")}), 2);
  EXPECT_NE(err_.find("geometry_msgs/WrenchStamped"), std::string::npos) << err_;

  writeBag("in.bag", [](rosbag::Bag&) {});
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--topic", "cloud_in=/points"}), 2);
  EXPECT_NE(err_.find("/deformable_surface/cloud_in"), std::string::npos) << err_;  // of what there is

  const std::string whole = readFile(path("in.bag"));
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, whole.size() / 2, whole.size() - 10}) {
    std::ofstream(path("cut.bag"), std::ios::binary) << whole.substr(0, size);
    EXPECT_EQ(run({"--bag_in", path("cut.bag")}), 2) << size;
    EXPECT_EQ(countLines(err_), 1u) << err_;
  }
}

TEST_F(SimulateBag, GivesTheSameBagForTheSameBag) {
  writeBag("in.bag", [](rosbag::Bag& bag) { bag.write("/deformable_surface/force", ros::Time(kStart), makeForce(kStart, 1.0)); });
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--bag_out", path("a.bag")}), 0);
  EXPECT_EQ(run({"--bag_in", path("in.bag"), "--bag_out", path("b.bag")}), 0);
  EXPECT_EQ(readFile(path("a.bag")), readFile(path("b.bag")));
}

}  // namespace
}  // namespace deformable_surface::node::test
