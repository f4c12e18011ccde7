// A step that takes long: the node reports it meanwhile, and a reset does not wait for it.
#include "surface_node_fixture.h"

#include <thread>

namespace deformable_surface::node::test {
namespace {

// Two seconds in some 6e5 sub-steps, which keep any computer busy for seconds.
class LongStepTest : public ::testing::Test {
 protected:
  LongStepTest() {
    process_ = std::make_unique<NodeProcess>("/surface", R"(
model: mass_spring
material: {young_modulus: 1.0e9, thickness: 0.001, damping: 1.0}
integrator: {type: verlet, time_step: 2.0}
gravity: [0, 0, -1]
pins: [{box: {min: [-1, -1, -1], max: [0.021, 1, 1]}}]
accuracy: {estimate: false}
)");
    client_ = std::make_unique<NodeClient>("/surface");
    subscriber_ = client_->handle().subscribe<diagnostic_msgs::DiagnosticArray>(
        "/diagnostics", 100, [this](const diagnostic_msgs::DiagnosticArrayConstPtr& message) {
          for (const auto& status : message->status)
            if (status.name == "surface: simulation" && status.message.find("a step has been going on for ") == 0)
              is_told_ = status.level == diagnostic_msgs::DiagnosticStatus::WARN;
        });
  }

  std::unique_ptr<NodeProcess> process_;
  std::unique_ptr<NodeClient> client_;
  ros::Subscriber subscriber_;
  bool is_told_ = false;
};

TEST_F(LongStepTest, IsToldOfWhileItGoesOnAndEndedByAReset) {
  ASSERT_TRUE(client_->waitForNode()) << process_->output();
  PointCloud2 cloud = makeSheet(kColumns, kRows);
  cloud.header.stamp = ros::Time::now();
  ASSERT_TRUE(client_->exchange(cloud)) << process_->output();
  for (int k = 0; k < 2; ++k) {
    is_told_ = false;
    EXPECT_TRUE(waitUntil([&] { return is_told_; })) << process_->output();
    EXPECT_TRUE(client_->reset().success);
  }
  // The same for a call that waits for the step itself.
  is_told_ = false;
  EXPECT_TRUE(waitUntil([&] { return is_told_; })) << process_->output();
  std::thread waiting([&] { EXPECT_TRUE(client_->pause(true).success); });
  EXPECT_TRUE(client_->reset().success);
  waiting.join();
  // The reset did not wait for the step: no frame shows anything but rest.
  for (const sensor_msgs::PointCloud2ConstPtr& frame : client_->frames)
    for (std::size_t i = 0; i < frame->width * frame->height; ++i) EXPECT_EQ(readField(*frame, i, "displacement"), 0.0);
  // It is not reported as a failed step.
  EXPECT_TRUE(waitUntil([&] { return client_->diagnosticText("state") == "paused"; })) << client_->diagnosticText("state");
  EXPECT_EQ(process_->output().find("was interrupted"), std::string::npos) << process_->output();
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "long_step_rostest");
  ros::NodeHandle keep;
  return RUN_ALL_TESTS();
}
