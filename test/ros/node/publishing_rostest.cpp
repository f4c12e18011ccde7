// Messages without subscribers are not computed, which the statistics show. A subscriber in the same process gets the message
// itself.
#include "../bad_clouds.h"
#include "../node_client.h"

#include "deformable_surface/DeformedUpdate.h"
#include "deformable_surface/ros/node/surface_node.h"

#include <geometry_msgs/WrenchStamped.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace deformable_surface::node::test {
namespace {

PointCloud2 makeStampedSheet() {
  PointCloud2 cloud = makeSheet(20, 10);
  cloud.header.stamp = ros::Time::now();
  return cloud;
}

TEST(Publishing, MakesOnlyWhatSomebodyListensTo) {
  NodeProcess process("/surface", "{model: mass_spring, gravity: [0, 0, -1]}");
  ros::NodeHandle node("/surface");
  ros::Publisher cloud = node.advertise<PointCloud2>("cloud_in", 1);
  int with = 0, without = 0;
  const ros::Subscriber statistics = node.subscribe<Statistics>("statistics", 1000, [&](const StatisticsConstPtr& m) {
    const auto isSkipped = [&](const char* name) { return std::count(m->skipped.begin(), m->skipped.end(), name) > 0; };
    EXPECT_EQ(isSkipped("transfer"), isSkipped("normals"));
    ++(isSkipped("transfer") ? without : with);
  });
  ASSERT_TRUE(waitUntil([&] { return cloud.getNumSubscribers() > 0 && statistics.getNumPublishers() > 0; })) << process.output();
  cloud.publish(makeStampedSheet());
  ASSERT_TRUE(waitUntil([&] { return with + without > 20; })) << process.output();
  // The first message is computed for later subscribers, because it is latched.
  EXPECT_LE(with, 1);

  std::size_t frames = 0;
  ros::Subscriber deformed =
      node.subscribe<PointCloud2>("deformed", 10, [&](const sensor_msgs::PointCloud2ConstPtr&) { ++frames; });
  ASSERT_TRUE(waitUntil([&] { return frames > 2; }));
  with = without = 0;
  ASSERT_TRUE(waitUntil([&] { return with + without > 20; }));
  EXPECT_EQ(without, 0);

  deformed.shutdown();
  ASSERT_TRUE(waitUntil([&] { return without > 0; }));
  with = without = 0;
  ASSERT_TRUE(waitUntil([&] { return with + without > 20; }));
  EXPECT_EQ(with, 0);
}

// The first message that a new subscriber gets is the latched one.
sensor_msgs::PointCloud2ConstPtr takeLatched(ros::NodeHandle& node) {
  sensor_msgs::PointCloud2ConstPtr first;
  const ros::Subscriber deformed = node.subscribe<PointCloud2>("deformed", 10, [&](const sensor_msgs::PointCloud2ConstPtr& m) {
    if (!first) first = m;
  });
  const bool has_come = waitUntil([&] { return first != nullptr; });
  EXPECT_TRUE(has_come);
  return first;
}

TEST(Publishing, LatchesTheStateThatACallAnswered) {
  NodeProcess process("/waited", "{model: mass_spring, gravity: [0, 0, -1], output: {stamp: simulation}}");
  ros::NodeHandle node("/waited");
  ros::Publisher cloud = node.advertise<PointCloud2>("cloud_in", 1);
  const auto call = [&](const char* name, auto service) {
    EXPECT_TRUE(ros::service::call(node.resolveName(name), service)) << process.output();
    EXPECT_TRUE(service.response.success) << service.response.message;
    return service.response;
  };
  ASSERT_TRUE(waitUntil([&] { return cloud.getNumSubscribers() > 0; })) << process.output();
  ASSERT_TRUE(ros::service::waitForService(node.resolveName("pause"), ros::Duration(60)));
  std_srvs::SetBool pause;
  pause.request.data = true;
  call("pause", pause);
  const PointCloud2 sheet = makeStampedSheet();
  cloud.publish(sheet);
  ASSERT_TRUE(takeLatched(node)) << process.output();
  Step step;
  step.request.count = 5;
  for (int k = 0; k < 4; ++k) {
    // The steps before the last call are shown to nobody.
    call("step", step);
    const double time = call("step", step).simulation_time;
    const sensor_msgs::PointCloud2ConstPtr latched = takeLatched(node);
    ASSERT_TRUE(latched);
    EXPECT_NEAR((latched->header.stamp - sheet.header.stamp).toSec(), time, 1e-6);
  }
  call("reset", std_srvs::Trigger());
  sensor_msgs::PointCloud2ConstPtr latched = takeLatched(node);
  ASSERT_TRUE(latched);
  EXPECT_EQ(latched->header.stamp, sheet.header.stamp);

  pause.request.data = false;
  call("pause", pause);
  std::uint64_t steps = 0;
  {
    const ros::Subscriber statistics =
        node.subscribe<Statistics>("statistics", 100, [&](const StatisticsConstPtr& m) { steps = m->step; });
    ASSERT_TRUE(waitUntil([&] { return steps > 20; })) << process.output();
  }
  pause.request.data = true;
  call("pause", pause);
  latched = takeLatched(node);
  ASSERT_TRUE(latched);
  EXPECT_GT((latched->header.stamp - sheet.header.stamp).toSec(), 0.0);
}

TEST(Publishing, SendsEveryMessageOfMarkersWholeAndLatched) {
  NodeProcess process("/marked",
                      "{model: mass_spring, gravity: [0, 0, -1], sleep: {mode: never}, "
                      "pins: [{box: {min: [-0.01, -1, -1], max: [0.01, 1, 1]}}]}");
  NodeClient client("/marked");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStampedSheet())) << process.output();
  int count = 0;
  using Event = ros::MessageEvent<visualization_msgs::MarkerArray const>;
  const boost::function<void(const Event&)> take = [&](const Event& event) {
    // A bag player sends late subscribers the last message of a latched topic, and nothing else.
    EXPECT_EQ(event.getConnectionHeader().at("latching"), "1");
    std::set<std::string> names;
    for (const auto& marker : event.getConstMessage()->markers) names.insert(marker.ns);
    for (const char* name : {"surface", "pins", "statistics", "strain_legend"}) EXPECT_EQ(names.count(name), 1u) << name;
    ++count;
  };
  const ros::Subscriber markers = client.handle().subscribe<visualization_msgs::MarkerArray>("markers", 10, take);
  ASSERT_TRUE(waitUntil([&] { return count > 10; })) << process.output();
}

TEST(Publishing, SendsACloudThatHasNotChangedToWhoIsNewOnly) {
  NodeProcess process("/resting", "{model: mass_spring, gravity: [0, 0, 0]}");
  NodeClient client("/resting");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  std::uint64_t step = 0;
  const ros::Subscriber statistics =
      client.handle().subscribe<Statistics>("statistics", 100, [&](const StatisticsConstPtr& m) { step = m->step; });
  ASSERT_TRUE(client.exchange(makeStampedSheet())) << process.output();
  // All requests of connections have arrived by then.
  ASSERT_TRUE(waitUntil([&] { return step > 20; }));
  const std::size_t before = client.frames.size();
  const std::uint64_t begin = step;
  ASSERT_TRUE(waitUntil([&] { return step > begin + 100; })) << process.output();
  EXPECT_EQ(client.frames.size(), before);

  // The latched message, and the present surface.
  NodeClient late("/resting");
  ASSERT_TRUE(waitUntil([&] {
    return !late.frames.empty() && late.frames.back()->header.stamp > client.frames.front()->header.stamp;
  })) << process.output();

  const std::size_t at_rest = client.frames.size();
  client.publish(makeForce("pull", Vec3(0.1, 0.05, 0.0), Vec3(0.0, 0.0, 1e-3)));
  ASSERT_TRUE(waitUntil([&] { return client.frames.size() > at_rest + 5; })) << process.output();
}

TEST(Publishing, UpdatesPutTogetherAreTheSurface) {
  NodeProcess process("/followed", "{model: mass_spring, gravity: [0, 0, -1]}");
  NodeClient client("/followed");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.pause(true).success);
  ASSERT_TRUE(client.exchange(makeStampedSheet())) << process.output();
  std::map<ros::Time, std::vector<std::uint8_t>> surfaces;
  PointCloud2 surface;
  std::vector<std::uint32_t> sequence;
  const ros::Subscriber updates =
      client.handle().subscribe<DeformedUpdate>("deformed_update", 100, [&](const DeformedUpdateConstPtr& m) {
        sequence.push_back(m->sequence);
        if (m->whole) surface = m->points;
        for (std::size_t k = 0; k < m->indices.size(); ++k)
          std::copy_n(m->points.data.begin() + k * surface.point_step, surface.point_step,
                      surface.data.begin() + std::size_t{m->indices[k]} * surface.point_step);
        surfaces[m->header.stamp] = surface.data;
      });
  ASSERT_TRUE(waitUntil([&] { return !surfaces.empty(); })) << process.output();  // complete, though nothing moves
  ASSERT_TRUE(client.pause(false).success);
  ASSERT_TRUE(waitUntil([&] { return surfaces.size() > 20; })) << process.output();
  ASSERT_TRUE(client.pause(true).success);
  std::size_t compared = 0;
  const auto isComplete = [&] {
    compared = 0;
    for (const sensor_msgs::PointCloud2ConstPtr& frame : client.frames) compared += surfaces.count(frame->header.stamp);
    return compared >= 20 && surfaces.count(client.frames.back()->header.stamp) > 0;
  };
  ASSERT_TRUE(waitUntil(isComplete)) << process.output();
  for (const sensor_msgs::PointCloud2ConstPtr& frame : client.frames) {
    const auto same = surfaces.find(frame->header.stamp);
    if (same != surfaces.end()) EXPECT_EQ(same->second, frame->data);
  }
  for (std::size_t k = 1; k < sequence.size(); ++k) EXPECT_EQ(sequence[k], sequence[k - 1] + 1);
}

TEST(Publishing, TellsWhatAToolFeelsAfterEveryStep) {
  NodeProcess process("/felt", R"({model: mass_spring, gravity: [0, 0, -1], output: {publish_rate: 1.0, stamp: simulation},
    tools: [{id: globe, mode: solid, shape: {sphere: {radius: 1.0}}, path: [{time: 0.0, position: [0, 0, -1.01]}]}]})");
  NodeClient client("/felt");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  std::vector<ros::Time> stamps;
  const ros::Subscriber wrench = client.handle().subscribe<geometry_msgs::WrenchStamped>(
      "tools/globe/wrench", 100, [&](const geometry_msgs::WrenchStampedConstPtr& m) { stamps.push_back(m->header.stamp); });
  ASSERT_TRUE(client.pause(true).success);
  const PointCloud2 cloud = makeStampedSheet();
  ASSERT_TRUE(client.exchange(cloud)) << process.output();
  ASSERT_TRUE(waitUntil([&] { return wrench.getNumPublishers() > 0; }));
  ASSERT_TRUE(client.step(1).success);
  ASSERT_TRUE(waitUntil([&] { return client.step(1).success && !stamps.empty(); })) << process.output();
  stamps.clear();
  const StepResponse stepped = client.step(30);
  ASSERT_TRUE(stepped.success) << stepped.message;
  const ros::Time last = cloud.header.stamp + ros::Duration(stepped.simulation_time);
  ASSERT_TRUE(waitUntil([&] { return !stamps.empty() && std::abs((stamps.back() - last).toSec()) < 1e-6; }));
  EXPECT_GE(std::set<ros::Time>(stamps.begin(), stamps.end()).size(), 30u);
}

TEST(Publishing, GivesTheMessageItselfToThoseInTheSameProcess) {
  ros::NodeHandle node, inside("/inside");
  ros::Publisher cloud = inside.advertise<PointCloud2>("cloud_in", 1);
  std::set<const PointCloud2*> first, second;
  // Kept, so that no address is used again.
  std::vector<sensor_msgs::PointCloud2ConstPtr> kept;
  const auto collect = [&](std::set<const PointCloud2*>& addresses) {
    return [&](const sensor_msgs::PointCloud2ConstPtr& m) {
      kept.push_back(m);
      addresses.insert(m.get());
    };
  };
  const ros::Subscriber one = inside.subscribe<PointCloud2>("deformed", 100, collect(first));
  const ros::Subscriber two = inside.subscribe<PointCloud2>("deformed", 100, collect(second));
  const SurfaceNode surface(node, inside, simulation::SceneParams());
  ASSERT_TRUE(waitUntil([&] { return cloud.getNumSubscribers() > 0 && one.getNumPublishers() > 0; }));
  cloud.publish(makeStampedSheet());
  ASSERT_TRUE(waitUntil([&] { return first.size() > 5 && first == second; }));
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "publishing_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
