// Oriented particles over services: single ones are edited, and surfaces grow through them while the node goes on answering.
#include "surface_node_fixture.h"

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

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "particles_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
