// Clouds that arrive while a surface runs. Steps continue while the clouds are decoded, built and prepared. Late clouds are
// counted.
#include "../bad_clouds.h"
#include "../node_client.h"

#include "deformable_surface/List.h"

#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::node::test {
namespace {

constexpr int kManyColumns = 400, kManyRows = 400;
constexpr std::uint32_t kFewPoints = 200;

PointCloud2 makeStamped(int columns, int rows, const ros::Time& stamp) {
  PointCloud2 cloud = makeSheet(columns, rows);
  cloud.header.stamp = stamp;
  return cloud;
}

TEST(Clouds, StepsGoOnWhileALargeOneIsBuiltWhichThenTakesTheCommandsSinceItsStamp) {
  NodeProcess process("/replaced", "{model: mass_spring, gravity: [0, 0, -0.1], sleep: {mode: never}, input: {policy: replace}}");
  NodeClient client("/replaced");
  std::uint64_t step = 0;
  std::uint32_t points = 0;
  const ros::Subscriber statistics = client.handle().subscribe<Statistics>("statistics", 1000, [&](const StatisticsConstPtr& m) {
    step = m->step;
    points = m->points;
  });
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  ASSERT_TRUE(waitUntil([&] { return step > 5 && points == kFewPoints; })) << process.output();

  client.publish(makeStamped(kManyColumns, kManyRows, ros::Time::now()));
  ASSERT_TRUE(waitUntil([&] { return client.diagnostic("clouds received") == 2.0; })) << process.output();
  client.publish(makeForce("pull", Vec3(0.1, 0.05, 0.0), Vec3(0.0, 0.0, 1e-3)));
  const std::uint64_t begin = step;
  std::uint64_t last = begin;
  const auto isReplaced = [&] {
    if (points == kFewPoints) last = std::max(last, step);
    return points == std::uint32_t{kManyColumns} * kManyRows;
  };
  ASSERT_TRUE(waitUntil(isReplaced, 120.0)) << process.output();
  // Building takes seconds. The work in progress of a build that is stopped is a step or two.
  EXPECT_GT(last, begin + 20);
  EXPECT_EQ(client.diagnosticText("last warning").find("refused"), std::string::npos) << process.output();
  List list;
  ASSERT_TRUE(ros::service::call("/replaced/list", list));
  EXPECT_EQ(list.response.forces, std::vector<std::string>{"pull"});
}

TEST(Clouds, OfManyThatComeWhileOneIsBuiltTheNewestIsBuiltAndTheOthersAreCounted) {
  NodeProcess process("/flooded", "{model: mass_spring, gravity: [0, 0, 0], input: {policy: replace}}");
  NodeClient client("/flooded");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  client.publish(makeStamped(kManyColumns, kManyRows, ros::Time::now()));
  for (int k = 2; k <= 8; ++k) {
    ASSERT_TRUE(client.waitForDiagnostic("clouds received", k)) << process.output();
    // One after the other, so that none is dropped.
    client.publish(makeStamped(20, 10 + k, ros::Time::now()));
  }
  ASSERT_TRUE(client.waitForDiagnostic("clouds received", 9.0)) << process.output();
  ASSERT_TRUE(waitUntil(
      [&] { return !client.frames.empty() && client.frames.back()->width * client.frames.back()->height == 20u * 18u; }, 120.0))
      << process.output();
  ASSERT_TRUE(waitUntil([&] {
    return client.diagnostic("clouds accepted") + client.diagnostic("clouds replaced before they were built") == 9.0;
  })) << process.output();
  // The number depends on how fast the large one is built.
  EXPECT_GE(client.diagnostic("clouds replaced before they were built"), 1.0);
}

TEST(Clouds, OneThatComesAgainBeginsItsSurfaceAnewWithoutBuildingIt) {
  NodeProcess process("/again", "{model: mass_spring, gravity: [0, 0, -1], sleep: {mode: never}, input: {policy: replace}}");
  NodeClient client("/again");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  const PointCloud2 at_rest = *client.frames.front();
  ASSERT_TRUE(waitUntil([&] { return client.diagnostic("step") > 20; })) << process.output();

  client.frames.clear();
  client.publish(makeStamped(20, 10, ros::Time::now()));
  ASSERT_TRUE(client.waitForDiagnostic("clouds that came again", 1.0)) << process.output();
  EXPECT_EQ(client.diagnostic("clouds accepted"), 2.0);
  const auto isAtRest = [&](const sensor_msgs::PointCloud2ConstPtr& frame) { return frame->data == at_rest.data; };
  EXPECT_TRUE(waitUntil([&] { return std::any_of(client.frames.begin(), client.frames.end(), isAtRest); })) << process.output();

  // A cloud that differs in one bit is another cloud.
  PointCloud2 other = makeStamped(20, 10, ros::Time::now());
  other.data[0] ^= 1;
  client.publish(other);
  ASSERT_TRUE(client.waitForDiagnostic("clouds accepted", 3.0)) << process.output();
  EXPECT_EQ(client.diagnostic("clouds that came again"), 1.0);
}

TEST(Clouds, FiltersTakePartsOfThemAwayAndTheSameCloudIsStillKnown) {
  NodeProcess process("/filtered",
                      "{model: mass_spring, gravity: [0, 0, 0], input: {policy: replace, filter: {crop: [{box: "
                      "{min: [-1, -1, -1], max: [0.105, 10, 1]}}]}}}");
  NodeClient client("/filtered");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  const PointCloud2 sent = makeStamped(20, 10, ros::Time::now());
  const sensor_msgs::PointCloud2ConstPtr shown = client.exchange(sent);
  ASSERT_TRUE(shown) << process.output();
  ASSERT_EQ(shown->width * shown->height, kFewPoints);
  int stay = 0;
  sensor_msgs::PointCloud2ConstIterator<float> before(sent, "x"), after(*shown, "x");
  for (std::uint32_t i = 0; i < kFewPoints; ++i, ++before, ++after) {
    EXPECT_EQ(std::isfinite(*after), *before < 0.105f) << i;
    stay += std::isfinite(*after);
  }
  EXPECT_GT(stay, 10);
  EXPECT_LT(stay, 190);
  EXPECT_NE(process.output().find("input.filter: taken away: crop " + std::to_string(200 - stay)), std::string::npos)
      << process.output();

  client.publish(makeStamped(20, 10, ros::Time::now()));
  EXPECT_TRUE(client.waitForDiagnostic("clouds that came again", 1.0)) << process.output();
  // Another cloud, with no usable point, is refused.
  PointCloud2 elsewhere = makeStamped(20, 10, ros::Time::now());
  for (sensor_msgs::PointCloud2Iterator<float> x(elsewhere, "x"); x != x.end(); ++x) *x += 100.0f;
  client.publish(elsewhere);
  EXPECT_TRUE(client.waitForDiagnostic("clouds refused", 1.0)) << process.output();
  EXPECT_NE(client.diagnosticText("last warning").find("of which 0 stay (taken away: crop 200)"), std::string::npos)
      << client.diagnosticText("last warning");
}

TEST(Clouds, OneToBeTrackedOfWhichTheFiltersLeaveNothingIsRefused) {
  NodeProcess process("/filtered_track",
                      "{model: mass_spring, gravity: [0, 0, 0], sleep: {mode: never}, "
                      "input: {policy: track, filter: {range: {max: 50.0}}}}");
  NodeClient client("/filtered_track");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  PointCloud2 elsewhere = makeStamped(20, 10, ros::Time::now());
  for (sensor_msgs::PointCloud2Iterator<float> x(elsewhere, "x"); x != x.end(); ++x) *x += 100.0f;
  client.publish(elsewhere);
  EXPECT_TRUE(client.waitForDiagnostic("clouds refused", 1.0)) << process.output();
  EXPECT_NE(client.diagnosticText("last warning").find("taken away: range 200"), std::string::npos) << process.output();
  client.publish(makeStamped(20, 10, ros::Time::now()));
  EXPECT_TRUE(client.waitForDiagnostic("clouds tracked", 1.0)) << process.output();
}

TEST(Clouds, ASignalEndsTheNodeWhileALargeOneIsBuilt) {
  NodeProcess process("/interrupted", "{model: mass_spring}");
  NodeClient client("/interrupted");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  client.publish(makeStamped(1500, 1000, ros::Time::now()));
  ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "building a surface"; })) << process.output();
  process.send(SIGINT);
  EXPECT_EQ(process.waitForExit(), std::optional<int>(0)) << process.output();
  EXPECT_EQ(process.output().find("surface built"), std::string::npos) << process.output();
}

TEST(Clouds, OneToBeTrackedThatComesAfterTheStepAtItsStampIsCounted) {
  NodeProcess process("/late", "{model: mass_spring, gravity: [0, 0, 0], sleep: {mode: never}, input: {policy: track}}");
  NodeClient client("/late");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  ASSERT_TRUE(waitUntil([&] { return client.diagnostic("step") > 100; })) << process.output();
  client.publish(makeStamped(20, 10, ros::Time::now() - ros::Duration(0.5)));
  ASSERT_TRUE(client.waitForDiagnostic("clouds tracked", 1.0)) << process.output();
  EXPECT_EQ(client.diagnostic("clouds late"), 1.0);
  // Far enough ahead for any machine.
  client.publish(makeStamped(20, 10, ros::Time::now() + ros::Duration(3.0)));
  ASSERT_TRUE(client.waitForDiagnostic("clouds tracked", 2.0)) << process.output();
  EXPECT_EQ(client.diagnostic("clouds late"), 1.0);
}

TEST(Clouds, OnesThatShowTheTrackedSurfaceNoLongerAreAWarningUntilOneShowsIt) {
  NodeProcess process("/lost", "{model: mass_spring, gravity: [0, 0, 0], sleep: {mode: never}, input: {policy: track}}");
  NodeClient client("/lost");
  std::string summary;
  const ros::Subscriber diagnostics = client.handle().subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 100, [&](const diagnostic_msgs::DiagnosticArrayConstPtr& message) {
        for (const auto& status : message->status)
          if (status.name == "lost: simulation") summary = (status.level == status.WARN ? "WARN " : "") + status.message;
      });
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  client.publish(makeStamped(20, 10, ros::Time::now()));
  ASSERT_TRUE(client.waitForDiagnostic("clouds tracked", 1.0)) << process.output();
  EXPECT_EQ(summary.find("lost"), std::string::npos) << summary;
  PointCloud2 elsewhere = makeStamped(20, 10, ros::Time::now());
  for (sensor_msgs::PointCloud2Iterator<float> z(elsewhere, "z"); z != z.end(); ++z) *z += 5.0f;
  client.publish(elsewhere);
  EXPECT_TRUE(waitUntil([&] { return summary.find("WARN lost: the tracked cloud shows 0 points of the surface") == 0; }))
      << summary;
  EXPECT_TRUE(waitUntil([&] { return client.diagnosticText("last warning").find("the tracked cloud shows 0 of ") == 0; }))
      << client.diagnosticText("last warning");
  client.publish(makeStamped(20, 10, ros::Time::now()));
  EXPECT_TRUE(waitUntil([&] { return summary == "running"; })) << summary;
}

TEST(Clouds, IgnoredOnesAreNotEvenDecoded) {
  NodeProcess process("/ignoring", "{model: mass_spring, gravity: [0, 0, 0], input: {policy: ignore}}");
  NodeClient client("/ignoring");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ASSERT_TRUE(client.exchange(makeStamped(20, 10, ros::Time::now()))) << process.output();
  PointCloud2 broken = makeStamped(20, 10, ros::Time::now());
  broken.data.resize(3);
  client.publish(broken);
  ASSERT_TRUE(client.waitForDiagnostic("clouds ignored by policy", 1.0)) << process.output();
  EXPECT_EQ(client.diagnostic("clouds refused"), 0.0);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "clouds_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
