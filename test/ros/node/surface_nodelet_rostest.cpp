// The nodelet is the node: in a manager it reaches the same state.
#include "../bad_clouds.h"
#include "../node_client.h"

namespace deformable_surface::node::test {
namespace {

StepResponse run(NodeClient& client) {
  EXPECT_TRUE(client.waitForNode());
  EXPECT_TRUE(client.pause(true).success);
  PointCloud2 cloud = makeSheet(20, 10);
  cloud.header.stamp = ros::Time::now();
  EXPECT_TRUE(client.exchange(cloud));
  return client.step(50);
}

TEST(SurfaceNodelet, ComesToTheStateOfTheNode) {
  NodeProcess process("/alone", "{model: mass_spring, gravity: [0, 0, -1]}");
  NodeClient alone("/alone"), loaded("/loaded");
  const StepResponse expected = run(alone), found = run(loaded);
  EXPECT_TRUE(found.success) << found.message;
  EXPECT_EQ(found.state_hash, expected.state_hash);
  EXPECT_EQ(found.energy, expected.energy);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "surface_nodelet_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
