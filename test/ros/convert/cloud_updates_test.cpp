#include "deformable_surface/ros/convert/cloud_updates.h"

#include "../bad_clouds.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

#include <cmath>
#include <limits>

namespace deformable_surface::node::test {
namespace {

// More rows than a block has.
constexpr int kColumns = 200, kRows = 150;

PointCloud2 makeCloud() { return makeSheet(kColumns, kRows); }

// As a subscriber does.
void follow(const DeformedUpdate& update, PointCloud2& cloud) {
  if (update.is_full) {
    cloud = update.points;
    return;
  }
  for (std::size_t k = 0; k < update.indices.size(); ++k)
    std::copy_n(update.points.data.begin() + k * cloud.point_step, cloud.point_step,
                cloud.data.begin() + std::size_t{update.indices[k]} * cloud.point_step);
}

class CloudUpdatesTest : public testing::Test {
 protected:
  bool make(const PointCloud2& cloud, bool whole = false) {
    const bool has_changed = updates_.make(boost::make_shared<const PointCloud2>(cloud), whole, message_);
    EXPECT_EQ(message_.whole, message_.is_full);  // its old name
    return has_changed;
  }

  CloudUpdates updates_;
  DeformedUpdate message_;
};

TEST_F(CloudUpdatesTest, TheFirstIsWhole) {
  const PointCloud2 cloud = makeCloud();
  ASSERT_TRUE(make(cloud));
  EXPECT_TRUE(message_.is_full);
  EXPECT_TRUE(message_.indices.empty());
  EXPECT_EQ(message_.points.data, cloud.data);
  EXPECT_EQ(message_.points.width, cloud.width);
  EXPECT_EQ(message_.sequence, 0u);
}

TEST_F(CloudUpdatesTest, ThenOnlyRowsThatDifferInABitAreSentAndGiveTheCloud) {
  PointCloud2 cloud = makeCloud();
  ASSERT_TRUE(make(cloud));
  PointCloud2 seen;
  follow(message_, seen);
  const std::vector<std::uint32_t> changed{0, 7, 16383, 16384, kColumns * kRows - 1};
  for (int round = 0; round < 3; ++round) {
    for (const std::uint32_t row : changed) cloud.data[row * cloud.point_step + 5] ^= 1;
    cloud.header.stamp.sec += 1;
    ASSERT_TRUE(make(cloud));
    EXPECT_FALSE(message_.is_full);
    EXPECT_EQ(message_.indices, changed);
    EXPECT_EQ(message_.points.data.size(), changed.size() * cloud.point_step);
    EXPECT_EQ(message_.sequence, static_cast<std::uint32_t>(round + 1));
    EXPECT_EQ(message_.header.stamp, cloud.header.stamp);
    follow(message_, seen);
    EXPECT_EQ(seen.data, cloud.data);
  }
}

// Removed points are NaN and stay NaN.
TEST_F(CloudUpdatesTest, NothingIsSentOfACloudThatIsTheSame) {
  PointCloud2 cloud = makeCloud();
  write(cloud, 0, std::numeric_limits<float>::quiet_NaN());
  ASSERT_TRUE(make(cloud));
  EXPECT_FALSE(make(cloud));
  EXPECT_FALSE(make(cloud));
  cloud.data[0] ^= 1;
  ASSERT_TRUE(make(cloud));
  EXPECT_EQ(message_.sequence, 1u);  // an update that was not sent leaves no gap
}

TEST_F(CloudUpdatesTest, ACloudOfAnotherLayoutIsWholeAndSoIsOneThatIsAskedFor) {
  PointCloud2 cloud = makeCloud();
  ASSERT_TRUE(make(cloud));
  ASSERT_TRUE(make(cloud, true));
  EXPECT_TRUE(message_.is_full);
  cloud = makeSheet(kColumns, kRows + 1);
  ASSERT_TRUE(make(cloud));
  EXPECT_TRUE(message_.is_full);
  updates_.forget();
  ASSERT_TRUE(make(cloud));
  EXPECT_TRUE(message_.is_full);
  EXPECT_EQ(message_.sequence, 3u);
}

}  // namespace
}  // namespace deformable_surface::node::test
