// The decoder of PointCloud2: what it reads from good clouds, and that it refuses bad ones with a sentence, as messages and as
// bytes. Also built with the address and undefined-behaviour sanitizers.
#include "deformable_surface/ros/convert/cloud_decoder.h"

#include "../bad_clouds.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cstring>

namespace deformable_surface::node {
namespace {

using test::BadCloud;
using test::BadClouds;
using test::makeField;
using test::makeSheet;
using test::Verdict;
using test::write;

std::vector<std::uint8_t> serialize(const sensor_msgs::PointCloud2& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), bytes.size());
  ros::serialization::serialize(stream, message);
  return bytes;
}

DecodedCloud decodeBytes(const std::vector<std::uint8_t>& bytes, const DecodeLimits& limits = {}) {
  // A copy in a block of its own size, so that a sanitizer sees a read behind the end.
  const std::vector<std::uint8_t> exact(bytes);
  return decodeCloud(exact.data(), exact.size(), limits);
}

DecodedCloud decodeMessage(const sensor_msgs::PointCloud2& message) { return decodeCloud(message, DecodeLimits()); }

bool haveEqualBits(const Points& a, const Points& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0);
}

/// A readable sentence without control characters, whatever the message contains.
bool isSentence(const std::string& text) {
  return text.size() > 20 && text.size() < 400 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

TEST(CloudDecoder, GivesEveryCloudOfTheCorpusItsVerdictAsMessageAndAsBytes) {
  const std::vector<BadCloud> clouds = BadClouds::makeAll();
  ASSERT_EQ(clouds.size(), 115u);
  for (const BadCloud& bad : clouds) {
    SCOPED_TRACE(bad.id + ": " + bad.what);
    const DecodedCloud from_message = decodeMessage(bad.message), from_bytes = decodeBytes(serialize(bad.message));
    EXPECT_EQ(from_message.problem, from_bytes.problem);
    EXPECT_TRUE(haveEqualBits(from_message.cloud.positions, from_bytes.cloud.positions));
    if (bad.verdict != Verdict::kEither) {
      EXPECT_EQ(from_bytes.ok(), bad.verdict == Verdict::kAccept) << from_bytes.problem;
    }
    if (from_bytes.ok()) {
      EXPECT_EQ(from_bytes.cloud.size(), static_cast<Index>(bad.message.width * bad.message.height));
    } else {
      EXPECT_TRUE(isSentence(from_bytes.problem)) << from_bytes.problem;
      EXPECT_EQ(from_bytes.cloud.size(), 0);
    }
  }
}

TEST(CloudDecoder, RefusesEveryTruncationOfAMessage) {
  auto message = makeSheet(3, 2, 20);
  message.fields.push_back(makeField("intensity", 12));
  const std::vector<std::uint8_t> bytes = serialize(message);
  ASSERT_TRUE(decodeBytes(bytes).ok());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decodeBytes({bytes.begin(), bytes.begin() + size}).ok()) << size;
}

TEST(CloudDecoder, SurvivesEveryFlippedBitOfAMessage) {
  auto message = makeSheet(3, 2, 20);
  message.fields.push_back(makeField("rgb", 12, sensor_msgs::PointField::UINT16, 2));
  const std::vector<std::uint8_t> bytes = serialize(message);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::uint8_t> flipped = bytes;
      flipped[i] ^= 1u << bit;
      const DecodedCloud decoded = decodeBytes(flipped);
      const std::int64_t num_points = std::int64_t{decoded.cloud.width} * decoded.cloud.height;
      EXPECT_TRUE(decoded.ok() ? decoded.cloud.size() == num_points : isSentence(decoded.problem)) << i << ' ' << decoded.problem;
    }
}

TEST(CloudDecoder, RefusesBytesBehindTheMessage) {
  std::vector<std::uint8_t> bytes = serialize(makeSheet());
  bytes.push_back(0);
  EXPECT_NE(decodeBytes(bytes).problem.find("goes on for 1 byte after"), std::string::npos);
}

TEST(CloudDecoder, RefusesLengthsThatTheBytesDoNotHold) {
  // The length of the frame, the number of fields and the length of the data, each as large as possible.
  const std::vector<std::uint8_t> bytes = serialize(makeSheet());
  const std::size_t frame_length = 12, num_fields = frame_length + 4 + 3 + 8, data_length = num_fields + 4 + 3 * 14 + 9;
  for (std::size_t at : {frame_length, num_fields, data_length}) {
    std::vector<std::uint8_t> lying = bytes;
    std::fill_n(lying.begin() + at, 4, 0xff);
    EXPECT_NE(decodeBytes(lying).problem.find("4294967295"), std::string::npos) << decodeBytes(lying).problem;
  }
}

TEST(CloudDecoder, ReadsHeaderShapeAndPositions) {
  auto message = makeSheet(4, 3);
  message.header.seq = 7;
  message.header.stamp.nsec = 5;
  const DecodedCloud decoded = decodeBytes(serialize(message));
  ASSERT_TRUE(decoded.ok()) << decoded.problem;
  EXPECT_EQ(decoded.header.seq, 7u);
  EXPECT_EQ(decoded.header.stamp, ros::Time(100, 5));
  EXPECT_EQ(decoded.header.frame_id, "map");
  EXPECT_EQ(decoded.cloud.width, 4u);
  EXPECT_EQ(decoded.cloud.height, 3u);
  EXPECT_EQ(decoded.cloud.positions[4 * 2 + 3], Vec3(0.01f * 3, 0.01f * 2, (0.01f * 3) * (0.01f * 2)));
  EXPECT_TRUE(decoded.cloud.normals.empty());
  EXPECT_TRUE(decoded.cloud.extra_fields.empty());
  EXPECT_EQ(decoded.num_not_finite, 0);
}

TEST(CloudDecoder, ReadsEveryLayoutOfTheSameSheetAlike) {
  Points expected = decodeMessage(makeSheet()).cloud.positions;
  for (const BadCloud& bad : BadClouds::makeAll())
    if (bad.id == "L04" || bad.id == "L05" || bad.id == "L07" || bad.id == "L11" || bad.id == "F11")
      EXPECT_TRUE(haveEqualBits(decodeMessage(bad.message).cloud.positions, expected)) << bad.id;
    else if (bad.id == "L08")
      for (Index i = 0; i < 100; ++i) {
        const Vec3 q = decodeMessage(bad.message).cloud.positions[i];
        EXPECT_EQ(Vec3(q.y(), q.z(), q.x()), expected[i]);
      }
}

TEST(CloudDecoder, KeepsTheDigitsOfFloat64) {
  auto message = makeSheet(3, 1, 24);
  message.fields = {makeField("x", 0, 8), makeField("y", 8, 8), makeField("z", 16, 8)};
  for (int i = 0; i < 9; ++i) write(message, 8 * i, 1.0 / (3.0 + i));
  const DecodedCloud decoded = decodeMessage(message);
  ASSERT_TRUE(decoded.ok()) << decoded.problem;
  EXPECT_EQ(decoded.cloud.positions[1], Vec3(1.0 / 6.0, 1.0 / 7.0, 1.0 / 8.0));
}

TEST(CloudDecoder, ReadsFloat32BesideFloat64) {
  auto message = makeSheet(3, 1, 20);
  message.fields = {makeField("x", 0), makeField("y", 4, 8), makeField("z", 12)};
  for (int i = 0; i < 3; ++i) {
    write(message, 20 * i, 0.5f * i);
    write(message, 20 * i + 4, 0.1 * i);
    write(message, 20 * i + 12, 2.0f);
  }
  EXPECT_EQ(decodeMessage(message).cloud.positions[2], Vec3(1.0, 0.2, 2.0));
}

TEST(CloudDecoder, MarksHolesInPlaceAndCountsThem) {
  auto message = makeSheet();
  write(message, 16 * 5 + 4, std::numeric_limits<float>::quiet_NaN());
  write(message, 16 * 9 + 8, -std::numeric_limits<float>::infinity());
  write(message, 16 * 11, 1.1e6f);
  const DecodedCloud decoded = decodeMessage(message);
  ASSERT_TRUE(decoded.ok()) << decoded.problem;
  EXPECT_EQ(decoded.cloud.size(), 100);
  EXPECT_EQ(decoded.num_not_finite, 3);
  for (Index i = 0; i < 100; ++i) EXPECT_EQ(decoded.cloud.positions[i].array().isNaN().all(), i == 5 || i == 9 || i == 11) << i;
}

TEST(CloudDecoder, RefusesFewerThanThreeFinitePoints) {
  auto message = makeSheet(4, 1);
  write(message, 0, std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(decodeMessage(message).ok());
  write(message, 16, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(decodeMessage(message).problem.find("of 4 points 2 have finite coordinates"), 0u) << decodeMessage(message).problem;
  EXPECT_EQ(decodeMessage(message).problem.find("subtract an offset"), std::string::npos);
  EXPECT_FALSE(decodeMessage(makeSheet(2, 1)).ok());
  for (int i = 0; i < 4; ++i) write(message, 16 * i, 4.6e6f);
  EXPECT_NE(decodeMessage(message).problem.find("within 1.0e+06 m; a surface needs at least 3; others are farther, as in "
                                                "coordinates of maps: subtract an offset from them"),
            std::string::npos)
      << decodeMessage(message).problem;
}

TEST(CloudDecoder, HoldsTheLimitOfPoints) {
  DecodeLimits limits;
  limits.max_points = 100;
  EXPECT_TRUE(decodeCloud(makeSheet(10, 10), limits).ok());
  EXPECT_EQ(decodeCloud(makeSheet(101, 1), limits).problem,
            "the cloud declares 101 x 1 points; accepted are at most 100 (input.max_points)");
}

TEST(CloudDecoder, ReadsNormalsOnlyIfAllThreeAreFloats) {
  auto message = makeSheet(3, 1, 32);
  for (int i = 0; i < 3; ++i) write(message, 32 * i + 24, 1.0f);
  message.fields.push_back(makeField("normal_x", 16));
  message.fields.push_back(makeField("normal_y", 20));
  EXPECT_TRUE(decodeMessage(message).cloud.normals.empty());
  EXPECT_EQ(decodeMessage(message).cloud.extra_fields.size(), 2u);
  message.fields.push_back(makeField("normal_z", 24));
  const DecodedCloud decoded = decodeMessage(message);
  EXPECT_EQ(decoded.cloud.normals, Points(3, Vec3::UnitZ()));
  EXPECT_TRUE(decoded.cloud.extra_fields.empty());
}

TEST(CloudDecoder, CarriesExtraFieldsInHostOrderWithoutPadding) {
  for (const bool is_bigendian : {false, true}) {
    auto message = makeSheet(3, 1, 30);
    message.is_bigendian = is_bigendian;
    message.fields.push_back(makeField("ring", 13, sensor_msgs::PointField::UINT16, 2));
    message.fields.push_back(makeField("time", 20, sensor_msgs::PointField::FLOAT64));
    for (std::uint16_t i = 0; i < 3; ++i) {
      write(message, 30 * i + 13, static_cast<std::uint16_t>(100 + i));
      write(message, 30 * i + 15, static_cast<std::uint16_t>(2000 + i));
      write(message, 30 * i + 20, 0.1 * i);
      const auto reverse = [&](int at, int size) {
        std::reverse(message.data.begin() + 30 * i + at, message.data.begin() + 30 * i + at + size);
      };
      if (is_bigendian) reverse(0, 4), reverse(4, 4), reverse(8, 4), reverse(13, 2), reverse(15, 2), reverse(20, 8);
    }
    const DecodedCloud decoded = decodeMessage(message);
    ASSERT_TRUE(decoded.ok()) << decoded.problem;
    ASSERT_EQ(decoded.cloud.extra_fields.size(), 2u);
    const cloud::ExtraField &ring = decoded.cloud.extra_fields[0], &time = decoded.cloud.extra_fields[1];
    EXPECT_EQ(ring.name, "ring");
    EXPECT_EQ(ring.type, cloud::ScalarType::kUint16);
    EXPECT_EQ(ring.count, 2u);
    ASSERT_EQ(ring.bytes.size(), 12u);
    ASSERT_EQ(time.bytes.size(), 24u);
    std::array<std::uint16_t, 6> rings;
    std::array<double, 3> times;
    std::memcpy(rings.data(), ring.bytes.data(), 12);
    std::memcpy(times.data(), time.bytes.data(), 24);
    EXPECT_EQ(rings, (std::array<std::uint16_t, 6>{100, 2000, 101, 2001, 102, 2002}));
    EXPECT_EQ(times, (std::array<double, 3>{0.0, 0.1, 0.2}));
  }
}

TEST(CloudDecoder, TakesOneLeadingSlashOffTheFrame) {
  auto message = makeSheet();
  message.header.frame_id = "/camera/depth";
  EXPECT_EQ(decodeMessage(message).header.frame_id, "camera/depth");
}

TEST(CloudDecoder, NamesWhatItFoundAndWhatItAccepts) {
  auto message = makeSheet();
  message.row_step = 80;
  EXPECT_EQ(decodeMessage(message).problem, "row_step is 80, but a row of 10 points of 16 bytes takes 160");
  message = makeSheet();
  message.fields[2].name = "depth";
  EXPECT_EQ(decodeMessage(message).problem,
            "the cloud has no field 'z' but 'x', 'y', 'depth'; needed are x, y and z as float32 or float64");
  message = makeSheet();
  message.fields[1].datatype = sensor_msgs::PointField::INT32;
  EXPECT_EQ(decodeMessage(message).problem,
            "field 'y' has datatype 5 and count 1; accepted is one float32 (7) or float64 (8) per point");
}

TEST(BoundedCloud, PassesForAPointCloud2AndKeepsItsBytes) {
  EXPECT_STREQ(ros::message_traits::md5sum<BoundedCloud>(), ros::message_traits::md5sum<sensor_msgs::PointCloud2>());
  EXPECT_STREQ(ros::message_traits::datatype<BoundedCloud>(), ros::message_traits::datatype<sensor_msgs::PointCloud2>());
  std::vector<std::uint8_t> bytes = serialize(makeSheet());
  ros::serialization::IStream stream(bytes.data(), bytes.size());
  BoundedCloud received;
  ros::serialization::deserialize(stream, received);
  EXPECT_EQ(received.bytes, bytes);
  EXPECT_EQ(stream.getLength(), 0u);
}

}  // namespace
}  // namespace deformable_surface::node
