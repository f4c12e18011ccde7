// Which cloud is used when transforms come later than clouds, and that the number of waiting clouds is limited.
#include "../../../src/ros/node/waiting_clouds.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>

namespace deformable_surface::node {
namespace {

using Answer = WaitingClouds::Answer;

IncomingCloud makeCloud(std::int64_t arrival) {
  IncomingCloud cloud;
  cloud.arrival = arrival;
  return cloud;
}

TEST(WaitingClouds, TheNewestOneWhoseTransformIsKnownIsTakenAndThoseBeforeItAreDropped) {
  WaitingClouds clouds;
  for (int k = 1; k <= 5; ++k) clouds.put(makeCloud(k));
  // Transforms come two clouds late.
  const auto isKnown = [](IncomingCloud& cloud, bool) { return cloud.arrival <= 3 ? Answer::kTake : Answer::kWait; };
  const std::optional<IncomingCloud> taken = clouds.take(isKnown);
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->arrival, 3);
  EXPECT_EQ(clouds.size(), 2u);
  EXPECT_EQ(clouds.numDropped(), 2);
  EXPECT_FALSE(clouds.take(isKnown));
  EXPECT_EQ(clouds.size(), 2u);
}

TEST(WaitingClouds, OneThatIsRefusedIsNotAskedAboutAgain) {
  WaitingClouds clouds;
  for (int k = 1; k <= 3; ++k) clouds.put(makeCloud(k));
  std::vector<std::int64_t> asked;
  const auto refuse = [&](IncomingCloud& cloud, bool is_patient) {
    EXPECT_TRUE(is_patient);
    asked.push_back(cloud.arrival);
    return cloud.arrival == 2 ? Answer::kRefuse : Answer::kWait;
  };
  EXPECT_FALSE(clouds.take(refuse));
  EXPECT_FALSE(clouds.take(refuse));
  EXPECT_EQ(asked, (std::vector<std::int64_t>{3, 2, 1, 3, 1}));
}

TEST(WaitingClouds, AreFewHoweverManyCome) {
  WaitingClouds clouds;
  for (int k = 1; k <= 1000; ++k) clouds.put(makeCloud(k));
  EXPECT_LE(clouds.size(), 64u);
  EXPECT_EQ(static_cast<int>(clouds.size()) + clouds.numDropped(), 1000);
  const std::optional<IncomingCloud> taken = clouds.take([](IncomingCloud&, bool) { return Answer::kTake; });
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->arrival, 1000);
}

TEST(WaitingClouds, AreFewerWhereTheyAreLargeAndOneInAnyCase) {
  WaitingClouds clouds;
  for (int k = 1; k <= 4; ++k) {
    IncomingCloud cloud = makeCloud(k);
    cloud.decoded.cloud.positions.resize(1'500'000);
    clouds.put(std::move(cloud));
  }
  EXPECT_EQ(clouds.size(), 2u);
  EXPECT_EQ(clouds.numDropped(), 2);
  IncomingCloud huge = makeCloud(5);
  huge.decoded.cloud.positions.resize(5'000'000);
  clouds.put(std::move(huge));
  EXPECT_EQ(clouds.size(), 1u);
}

}  // namespace
}  // namespace deformable_surface::node
