// An accuracy target in the node: another surface runs while trials choose, and the chosen one begins when that takes nothing
// from the user.
#include "surface_node_fixture.h"

#include "deformable_surface/Snapshot.h"

#include <dynamic_reconfigure/Reconfigure.h>

namespace deformable_surface::node::test {
namespace {

constexpr double kLongest = 90.0;  // s, for trials on a busy machine
const std::string kUntried = "begins with 1000 of 3600 points, as many as without a target";
const std::string kLongTrials = "4.0";  // s of simulated time: commands come before they end

class AccuracyNodeTest : public ::testing::Test {
 protected:
  AccuracyNodeTest() {
    cloud_ = makeSheet(60, 60);
    cloud_.header.stamp = ros::Time::now();
  }

  // The trials take a second or more, and the first surface comes after its set-up.
  void start(const std::string& patience, const std::string& target = "0.01", const std::string& duration = "1.0") {
    process_ = std::make_unique<NodeProcess>("/surface", R"(
model: mass_spring
material: {young_modulus: 1.0e6, thickness: 0.004, damping: 5.0}
gravity: [1, 0, 0]
pins: [{box: {min: [-1, -1, -1], max: [0.021, 1, 1]}}]
accuracy: {remember: false, position_error: )" + target +
                                                             ", patience: " + patience + "}\nduration: " + duration + "\n");
    client_ = std::make_unique<NodeClient>("/surface");
    ASSERT_TRUE(client_->waitForNode()) << process_->output();
  }
  // A surface that takes seconds, also on a fast machine.
  void startToBuild() {
    start("1000.0", "0.01", "100.0");
    client_->publish(makeSheet(500, 500));
    ASSERT_TRUE(waitUntil([&] { return process_->output().find("has been under construction") != std::string::npos; }))
        << process_->output();
  }
  bool waitForAccuracy(const std::string& part) {
    return waitUntil([&] { return client_->diagnosticText("accuracy").find(part) != std::string::npos; }, kLongest);
  }

  std::unique_ptr<NodeProcess> process_;
  std::unique_ptr<NodeClient> client_;
  PointCloud2 cloud_;
};

TEST_F(AccuracyNodeTest, TheChosenSurfaceBeginsAnewWhereNoCommandCame) {
  start("0.0");
  ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  EXPECT_TRUE(waitForAccuracy("the fewest tried")) << process_->output();
  EXPECT_EQ(client_->diagnosticText("accuracy").find(kUntried), std::string::npos) << client_->diagnosticText("accuracy");
  const std::string output = process_->output();
  EXPECT_NE(output.find(kUntried), std::string::npos) << output;
  EXPECT_NE(output.find("trials for accuracy.position_error go on in the background"), std::string::npos) << output;
  EXPECT_NE(output.find("the surface begins anew with what trials chose: accuracy.position_error 0.01 m"), std::string::npos)
      << output;
}

TEST_F(AccuracyNodeTest, ACommandKeepsTheSurfaceUntilAReset) {
  start("0.0", "0.01", kLongTrials);
  ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  ASSERT_TRUE(client_->pause(true).success);
  SelectRegionRequest corner;
  corner.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
  corner.primitive.dimensions = {0.05};
  ASSERT_TRUE(client_->select("pin", corner).success) << process_->output();
  EXPECT_TRUE(waitForAccuracy("~reset begins with what trials chose: accuracy.position_error 0.01 m")) << process_->output();
  EXPECT_EQ(client_->diagnosticText("accuracy").find("accuracy.position_error 0.01 m: " + kUntried), 0u);
  EXPECT_TRUE(client_->reset().success);
  EXPECT_TRUE(waitUntil([&] { return client_->diagnosticText("accuracy").find(kUntried) == std::string::npos; }))
      << client_->diagnosticText("accuracy");
}

TEST_F(AccuracyNodeTest, APausedSurfaceStaysUntilAReset) {
  start("0.0", "0.01", kLongTrials);
  ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  ASSERT_TRUE(client_->pause(true).success);
  const double before = client_->step(1).simulation_time;
  EXPECT_TRUE(waitForAccuracy("~reset begins with what trials chose: accuracy.position_error 0.01 m")) << process_->output();
  EXPECT_GT(client_->step(1).simulation_time, before);
  const std::string output = process_->output();
  EXPECT_NE(output.find("goes on as it is, since it has had commands, a pause or snapshots"), std::string::npos) << output;
  EXPECT_TRUE(client_->pause(false).success);
  EXPECT_TRUE(client_->reset().success);
  EXPECT_TRUE(waitUntil([&] { return client_->diagnosticText("accuracy").find(kUntried) == std::string::npos; }))
      << client_->diagnosticText("accuracy");
}

TEST_F(AccuracyNodeTest, ALiveSurfaceStaysWhereNoNumberOfPointsIsFound) {
  for (const char* patience : {"0.0", "1000.0"}) {
    start(patience, "1.0e-7");
    client_->publish(cloud_);
    EXPECT_TRUE(waitForAccuracy("found no number of points that is known to meet accuracy.position_error")) << process_->output();
    EXPECT_EQ(client_->diagnosticText("accuracy").find("accuracy.position_error 1.0e-07 m: " + kUntried), 0u)
        << client_->diagnosticText("accuracy");
    EXPECT_TRUE(client_->reset().success);
    EXPECT_EQ(process_->output().find("begins anew"), std::string::npos) << process_->output();
    EXPECT_NE(process_->output().find("the surface has its 1000 points, after ~reset, too"), std::string::npos)
        << process_->output();
    client_.reset();
    process_.reset();
  }
}

TEST_F(AccuracyNodeTest, SaysThatAResetDropsSnapshots) {
  start("0.0", "0.01", kLongTrials);
  ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  Snapshot snapshot;
  snapshot.request.name = "before";
  ASSERT_TRUE(ros::service::call("/surface/snapshot", snapshot) && snapshot.response.success) << process_->output();
  EXPECT_TRUE(waitForAccuracy("~reset begins with what trials chose, and drops the snapshots")) << process_->output();
  EXPECT_NE(process_->output().find("snapshots; ~reset begins with what trials chose, and drops the snapshots"),
            std::string::npos)
      << process_->output();
  EXPECT_EQ(
      client_->reset().message,
      "the surface is at rest at time 0; it is another one, which trials chose, and the snapshots of the one before (1) are "
      "dropped");
  EXPECT_EQ(client_->reset().message, "the surface is at rest at time 0");
}

TEST_F(AccuracyNodeTest, SaysThatTrialsDidNotKnowChangedValues) {
  start("0.0", "0.01", kLongTrials);
  ASSERT_TRUE(client_->exchange(cloud_)) << process_->output();
  dynamic_reconfigure::Reconfigure change;
  change.request.config.doubles.resize(1);
  change.request.config.doubles[0].name = "material.damping";
  change.request.config.doubles[0].value = 2.0;
  ASSERT_TRUE(ros::service::call("/surface/set_parameters", change)) << process_->output();
  EXPECT_TRUE(waitForAccuracy("~reset begins with what trials chose for the values before the last change or ~restore: accuracy"))
      << process_->output();
}

TEST_F(AccuracyNodeTest, ADiagnosisInAPauseTellsOfTheFirstSurface) {
  startToBuild();
  ASSERT_TRUE(client_->pause(true).success);
  EXPECT_TRUE(waitUntil([&] { return client_->diagnosticText("state") == "paused, while a surface is built"; }))
      << client_->diagnosticText("state");
}

TEST_F(AccuracyNodeTest, APatientNodeBeginsWithTheChosenSurface) {
  start("1000.0");
  client_->publish(cloud_);
  EXPECT_TRUE(waitForAccuracy("the fewest tried")) << process_->output();
  EXPECT_EQ(process_->output().find(kUntried), std::string::npos) << process_->output();
}

TEST_F(AccuracyNodeTest, AnotherCloudDoesNotWaitForThePatienceWithTheFirst) {
  startToBuild();
  PointCloud2 small = makeSheet(10, 10);
  client_->publish(small);
  EXPECT_TRUE(waitUntil([&] { return process_->output().find("100 simulation points") != std::string::npos; }, kLongest))
      << process_->output();
  EXPECT_NE(process_->output().find("begins with 1000 of 250000 points, as many as without a target"), std::string::npos)
      << process_->output();
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "accuracy_rostest");
  ros::NodeHandle keep;
  return RUN_ALL_TESTS();
}
