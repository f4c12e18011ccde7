// Clouds that break naive nodes, sent to the running node, each followed by a good one that must be published again.
#include "../bad_clouds.h"
#include "../node_client.h"

namespace deformable_surface::node::test {
namespace {

TEST(BadClouds, ThroughTheRunningNodeLeaveItAnsweringGoodOnes) {
  // The stamp of the cloud identifies the surface.
  NodeProcess process("/surface", "{model: mass_spring, gravity: [0, 0, 0], output: {stamp: simulation}}");
  NodeClient client("/surface");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.pause(true).success);
  const auto countVerdicts = [&] { return client.diagnostic("clouds accepted") + client.diagnostic("clouds refused"); };

  PointCloud2 good = makeSheet();
  good.header.stamp = ros::Time::now();
  ASSERT_TRUE(client.exchange(good));
  ASSERT_TRUE(client.waitForDiagnostic("clouds accepted", 1));
  for (const BadCloud& bad : BadClouds::makeAll()) {
    const double accepted = client.diagnostic("clouds accepted"), verdicts = countVerdicts();
    client.publish(bad.message);
    ASSERT_TRUE(waitUntil([&] { return countVerdicts() == verdicts + 1.0; })) << bad.id << " " << bad.what << "\n"
                                                                              << process.output();
    const bool was_accepted = client.diagnostic("clouds accepted") > accepted;
    if (bad.verdict == Verdict::kAccept) {
      // Some are well-formed messages of points in a line, which give no surface.
      const std::string warning = client.diagnosticText("last warning");
      EXPECT_TRUE(was_accepted || warning.find("span no surface") != std::string::npos)
          << bad.id << " " << bad.what << ": " << warning;
    }
    if (bad.verdict == Verdict::kRefuse) {
      EXPECT_FALSE(was_accepted) << bad.id << " " << bad.what;
    }

    good.header.stamp += ros::Duration(0.001);
    ASSERT_TRUE(client.exchange(good)) << "after " << bad.id << " " << bad.what << "\n" << process.output();
    ASSERT_TRUE(waitUntil([&] { return countVerdicts() == verdicts + 2.0; })) << bad.id;
  }
  EXPECT_TRUE(client.step(1).success);
  EXPECT_TRUE(process.isRunning());
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "bad_clouds_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
