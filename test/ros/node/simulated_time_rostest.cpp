// The node on /clock: it waits while the clock stands, starts again when the clock jumps back, and reaches the same state with
// the same messages, in each of two instances.
#include "../bad_clouds.h"
#include "../node_client.h"

#include "deformable_surface/DeformedUpdate.h"
#include "deformable_surface/ToolWrenchArray.h"

#include <rosgraph_msgs/Clock.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>

namespace deformable_surface::node::test {
namespace {

constexpr char kScene[] = R"({model: mass_spring, gravity: [0, 0, -1], pins: [{box: {min: [-1, -1, -1], max: [0.011, 1, 1]}}],
                              output: {publish_rate: 100.0}})";
constexpr std::int64_t kStart = 100'000'000'000, kStep = 10'000'000;  // ns

ros::Time toTime(std::int64_t nanoseconds) {
  ros::Time time;
  return time.fromNSec(static_cast<std::uint64_t>(nanoseconds));
}

class SimulatedTimeTest : public ::testing::Test {
 protected:
  SimulatedTimeTest() : process_("/one", kScene), client_("/one") {
    clock_ = client_.handle().advertise<rosgraph_msgs::Clock>("/clock", 1000);
  }
  void SetUp() override {
    ASSERT_TRUE(client_.waitForNode()) << process_.output();
    // roscpp's own subscription and the node's, and that of this process.
    ASSERT_TRUE(waitUntil([&] { return clock_.getNumSubscribers() >= 2; }));
    cloud_ = makeSheet(20, 10);
    cloud_.header.stamp = toTime(kStart);
  }

  void tick(std::int64_t time) {
    rosgraph_msgs::Clock message;
    message.clock = toTime(time);
    clock_.publish(message);
  }
  void tick(std::int64_t from, std::int64_t to) {
    for (std::int64_t time = from; time <= to; time += kStep) tick(time);
  }

  /// The messages of a run from kStart on, and the state after half a second.
  std::string run(NodeClient& client) {
    // The cloud waits until the node has a clock.
    tick(kStart);
    EXPECT_TRUE(client.exchange(cloud_));
    const double applied = client.diagnostic("commands applied");
    for (int i = 0; i < 5; ++i) {
      PointForce force = makeForce("pull", Vec3(0.19, 0.05, 0.0), Vec3(0.0, 0.001 * i, 0.002), 0.02, 0.07);
      force.header.stamp = toTime(kStart + (3 + 8 * i) * kStep);
      client.publish(force);
    }
    EXPECT_TRUE(client.waitForDiagnostic("commands waiting", 5));
    const ros::Time end = cloud_.header.stamp + ros::Duration(0.5);
    client.stamps.erase(end);
    tick(kStart + kStep, kStart + 50 * kStep);
    const auto frame = client.waitForFrame(end);
    EXPECT_TRUE(frame);
    EXPECT_TRUE(client.waitForDiagnostic("commands applied", std::max(applied, 0.0) + 5.0));
    return frame ? std::string(frame->data.begin(), frame->data.end()) : "";
  }

  NodeProcess process_;
  NodeClient client_;
  ros::Publisher clock_;
  PointCloud2 cloud_;
};

TEST_F(SimulatedTimeTest, StandsWhileTheClockStands) {
  client_.publish(cloud_);
  ASSERT_TRUE(waitUntil([&] { return client_.diagnosticText("state") == "waiting for the clock"; }));
  EXPECT_EQ(client_.step(1).message, "there is no surface yet; the clock has not started: nothing came on /clock");
  EXPECT_TRUE(waitUntil([&] { return client_.diagnosticText("last warning").find("nothing came on /clock in 10 s") == 0; }, 60.0))
      << process_.output();
  tick(kStart);
  ASSERT_TRUE(client_.waitForFrame(cloud_.header.stamp)) << process_.output();
  tick(kStart + 5 * kStep);
  ASSERT_TRUE(client_.waitForFrame(toTime(kStart + 5 * kStep)));
  // One period of the diagnostics later it has not moved.
  const double step = 5;
  ASSERT_TRUE(client_.waitForDiagnostic("step", step));
  ASSERT_TRUE(waitUntil([&] { return client_.diagnostic("steps per second") == 0.0; }));
  EXPECT_EQ(client_.diagnostic("step"), step);
  EXPECT_EQ(client_.frames.back()->header.stamp, toTime(kStart + 5 * kStep));
}

TEST_F(SimulatedTimeTest, DoesNotCatchUpAForwardJump) {
  tick(kStart);
  ASSERT_TRUE(client_.exchange(cloud_)) << process_.output();
  tick(kStart + 1'000 * kStep);
  tick(kStart + 1'001 * kStep);
  ASSERT_TRUE(client_.waitForFrame(toTime(kStart + 1'001 * kStep)));
  tick(kStart + 1'003 * kStep);
  ASSERT_TRUE(client_.waitForDiagnostic("step", 3));
}

TEST_F(SimulatedTimeTest, RepeatsItselfWhenTheClockJumpsBackAndInAnotherInstance) {
  const std::string first = run(client_);
  ASSERT_FALSE(first.empty()) << process_.output();
  EXPECT_EQ(client_.diagnostic("clock jumps back"), 0);
  // A looping bag: the cloud comes again.
  EXPECT_EQ(run(client_), first);
  ASSERT_TRUE(client_.waitForDiagnostic("clock jumps back", 1));

  NodeProcess other_process("/two", kScene);
  NodeClient other("/two");
  ASSERT_TRUE(other.waitForNode()) << other_process.output();
  const std::uint32_t needed = clock_.getNumSubscribers();
  ASSERT_TRUE(waitUntil([&] { return clock_.getNumSubscribers() >= std::max(needed, 3u); }));
  EXPECT_EQ(run(other), first);
}

TEST_F(SimulatedTimeTest, CountsCommandsThatComeAfterTheirStepAndTakesThemAllTheSame) {
  tick(kStart);
  ASSERT_TRUE(client_.exchange(cloud_)) << process_.output();
  tick(kStart + kStep, kStart + 20 * kStep);
  ASSERT_TRUE(client_.waitForFrame(toTime(kStart + 20 * kStep)));
  PointForce force = makeForce("pull", Vec3(0.19, 0.05, 0.0), Vec3(0.0, 0.0, 0.002), 0.02);
  for (const int step : {5, 40}) {
    force.header.stamp = toTime(kStart + step * kStep);
    client_.publish(force);
  }
  ASSERT_TRUE(client_.waitForDiagnostic("commands waiting", 2));
  tick(kStart + 21 * kStep, kStart + 50 * kStep);
  EXPECT_TRUE(client_.waitForDiagnostic("commands applied", 2)) << process_.output();
  EXPECT_TRUE(client_.waitForDiagnostic("commands late", 1));
}

TEST_F(SimulatedTimeTest, BehindTheClockByItsDelayItTakesInTimeWhatWouldElseBeLate) {
  constexpr std::int64_t kDelay = 10 * kStep;
  NodeProcess process("/behind", std::string(kScene, sizeof kScene - 2) + ", input: {delay: 0.1}}");
  NodeClient client("/behind");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  const std::uint32_t needed = clock_.getNumSubscribers();
  ASSERT_TRUE(waitUntil([&] { return clock_.getNumSubscribers() >= std::max(needed, 3u); }));
  const std::string expected = run(client_);  // every command in time, without a delay

  tick(kStart);
  ASSERT_TRUE(client.exchange(cloud_)) << process.output();
  for (int step = 1; step <= 50; ++step) {
    // Each comes eight steps after its stamp.
    if (step % 8 == 3 && step >= 11 && step <= 43) {
      const int i = (step - 11) / 8;
      PointForce force = makeForce("pull", Vec3(0.19, 0.05, 0.0), Vec3(0.0, 0.001 * i, 0.002), 0.02, 0.07);
      force.header.stamp = toTime(kStart + (3 + 8 * i) * kStep);
      ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 0)) << step << process.output();
      client.publish(force);
      ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1)) << step << process.output();
    }
    tick(kStart + step * kStep);
  }
  const ros::Time end = cloud_.header.stamp + ros::Duration(0.5);
  tick(kStart + 51 * kStep, kStart + 50 * kStep + kDelay);
  const auto frame = client.waitForFrame(end);
  ASSERT_TRUE(frame) << process.output();
  EXPECT_EQ(std::string(frame->data.begin(), frame->data.end()), expected);
  EXPECT_TRUE(client.waitForDiagnostic("step", 50));
  EXPECT_EQ(client.diagnostic("commands late"), 0);
}

// Stamps as tf2 and RViz with another fixed frame need them: by the clock, whatever a pause or a reset did to simulation time.
TEST_F(SimulatedTimeTest, OutputsAreStampedWithTheTimeOfTheClockThroughPausesAndResets) {
  Statistics statistics;
  ToolWrenchArray wrenches;
  std::map<std::string, std::vector<ros::Time>> stamps;
  const auto note = [&](const std::string& topic, const ros::Time& stamp) { stamps[topic].push_back(stamp); };
  ros::NodeHandle& node = client_.handle();
  std::vector<ros::Subscriber> subscribers = {
      node.subscribe<Statistics>("statistics", 1000,
                                 [&](const StatisticsConstPtr& m) {
                                   statistics = *m;
                                   note("statistics", m->header.stamp);
                                 }),
      node.subscribe<ToolWrenchArray>("tool_wrenches", 1000,
                                      [&](const ToolWrenchArray::ConstPtr& m) { note("tool_wrenches", m->header.stamp); }),
      node.subscribe<DeformedUpdate>("deformed_update", 1000,
                                     [&](const DeformedUpdate::ConstPtr& m) { note("deformed_update", m->header.stamp); }),
      node.subscribe<visualization_msgs::MarkerArray>("markers", 1000, [&](const visualization_msgs::MarkerArray::ConstPtr& m) {
        for (const auto& marker : m->markers) note("markers", marker.header.stamp);
      })};
  for (const ros::Subscriber& subscriber : subscribers)
    ASSERT_TRUE(waitUntil([&] { return subscriber.getNumPublishers() > 0; })) << subscriber.getTopic();
  const auto goTo = [&](std::int64_t from, int steps) {
    for (int k = 1; k <= steps; ++k) {
      tick(from + k * kStep);
      ASSERT_TRUE(client_.waitForFrame(toTime(from + k * kStep))) << process_.output();
    }
  };
  tick(kStart);
  ASSERT_TRUE(client_.exchange(cloud_)) << process_.output();
  goTo(kStart, 5);

  // A pause of a second. A subscriber that connects during the pause gets the present surface.
  ASSERT_TRUE(client_.pause(true).success);
  const std::int64_t paused = kStart + 105 * kStep;
  tick(kStart + 50 * kStep);
  tick(paused);
  // The diagnostics show when the node has received the clock.
  std::vector<ros::Time> diagnosed;
  const ros::Subscriber diagnostics = node.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 100, [&](const diagnostic_msgs::DiagnosticArrayConstPtr& m) { diagnosed.push_back(m->header.stamp); });
  ASSERT_TRUE(waitUntil([&] { return !diagnosed.empty() && diagnosed.back() >= toTime(paused); }));
  subscribers.push_back(node.subscribe<PointCloud2>(
      "simulation_points", 1000, [&](const PointCloud2::ConstPtr& m) { note("simulation_points", m->header.stamp); }));
  EXPECT_TRUE(waitUntil([&] { return !stamps["simulation_points"].empty(); })) << process_.output();
  EXPECT_EQ(stamps["simulation_points"].front(), toTime(paused));
  ASSERT_TRUE(client_.pause(false).success);
  goTo(paused, 5);
  ASSERT_TRUE(waitUntil([&] { return statistics.step == 10; }));
  EXPECT_EQ(statistics.header.stamp, toTime(paused + 5 * kStep));
  EXPECT_NEAR(statistics.simulation_time, 0.1, 1e-12);  // which pauses leave out
  EXPECT_EQ(statistics.cloud_stamp, cloud_.header.stamp);

  const std::int64_t reset = paused + 5 * kStep;
  ASSERT_TRUE(client_.reset().success);
  goTo(reset, 5);
  ASSERT_TRUE(waitUntil([&] { return statistics.step == 5; }));
  EXPECT_EQ(statistics.header.stamp, toTime(reset + 5 * kStep));

  const auto isThere = [&](const char* topic) {
    return !stamps[topic].empty() && stamps[topic].back() == statistics.header.stamp;
  };
  for (const char* topic : {"statistics", "tool_wrenches", "deformed_update", "simulation_points", "markers"}) {
    EXPECT_TRUE(waitUntil([&] { return isThere(topic); })) << topic;
    EXPECT_TRUE(std::is_sorted(stamps[topic].begin(), stamps[topic].end())) << topic;
  }
}

TEST_F(SimulatedTimeTest, SaysWhatItWaitsForAfterAJumpFarBackAndResetBeginsAtOnce) {
  tick(kStart);
  ASSERT_TRUE(client_.exchange(cloud_)) << process_.output();
  tick(kStart, kStart + 5 * kStep);
  ASSERT_TRUE(client_.waitForFrame(toTime(kStart + 5 * kStep)));
  tick(kStart / 2);
  EXPECT_TRUE(waitUntil([&] { return client_.diagnosticText("state") == "waiting for the clock to reach 100.0 s"; }))
      << client_.diagnosticText("state");
  // A jump ahead that ends before the time of the surface does not delay the surface.
  tick(kStart / 2 + 10'000'000'000);
  client_.stamps.clear();
  ASSERT_TRUE(client_.reset().success);
  const std::int64_t now = kStart / 2 + 10'000'000'000;
  tick(now, now + 5 * kStep);
  EXPECT_TRUE(client_.waitForFrame(toTime(now + 5 * kStep)));
  EXPECT_TRUE(waitUntil([&] { return client_.diagnosticText("state") == "running"; })) << client_.diagnosticText("state");
  client_.stamps.clear();
  tick(kStart / 2);
  tick(kStart / 2 + 10'000'000'000);
  tick(kStart);
  // Messages that arrive together with the jump would be skipped.
  ASSERT_TRUE(waitUntil([&] { return client_.diagnosticText("state") == "running" && client_.diagnostic("step") == 0; }));
  tick(kStart + kStep, kStart + 5 * kStep);
  EXPECT_TRUE(client_.waitForFrame(toTime(kStart + 5 * kStep)));
}

TEST_F(SimulatedTimeTest, StartsOverFromRestAfterAJumpBackWithoutANewCloud) {
  tick(kStart);
  ASSERT_TRUE(client_.exchange(cloud_)) << process_.output();
  tick(kStart, kStart + 50 * kStep);
  const auto first = client_.waitForFrame(toTime(kStart + 50 * kStep));
  ASSERT_TRUE(first);
  client_.stamps.clear();
  tick(kStart - 100 * kStep);
  ASSERT_TRUE(client_.waitForFrame(toTime(kStart - 100 * kStep)));
  tick(kStart - 100 * kStep, kStart + 50 * kStep);
  const auto second = client_.waitForFrame(toTime(kStart + 50 * kStep));
  ASSERT_TRUE(second);
  EXPECT_EQ(second->data, first->data);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "simulated_time_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
