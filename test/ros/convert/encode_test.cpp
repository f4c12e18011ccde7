// The published clouds: layout, shape and values. Fields of the input other than the positions are unchanged.
#include "deformable_surface/ros/convert/encode.h"
#include "deformable_surface/ros/convert/cloud_decoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace deformable_surface::node {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

cloud::ExtraField makeExtra(const std::string& name, cloud::ScalarType type, std::uint32_t count, Index num_points) {
  cloud::ExtraField field{name, type, count, {}};
  const std::size_t size = cloud::sizeOf(type) * count * num_points;
  for (std::size_t b = 0; b < size; ++b) field.bytes.push_back(static_cast<std::uint8_t>(b));
  return field;
}

/// Two rows of three points with a colour and a field of four shorts.
cloud::PointCloud makeInput() {
  cloud::PointCloud input;
  for (int i = 0; i < 6; ++i) input.positions.emplace_back(0.1 * (i % 3), 0.1 * (i / 3), 0.0);
  input.width = 3;
  input.height = 2;
  input.extra_fields = {makeExtra("rgb", cloud::ScalarType::kFloat32, 1, 6),
                        makeExtra("shorts", cloud::ScalarType::kInt16, 4, 6)};
  return input;
}

/// The input moved by half a metre along z.
simulation::Surface makeSurface(const cloud::PointCloud& input) {
  simulation::Surface surface;
  surface.positions = input.positions;
  for (Vec3& p : surface.positions) p.z() += 0.5;
  surface.normals.assign(input.size(), Eigen::Vector3f::UnitY());
  surface.displacement.assign(input.size(), 0.5f);
  surface.num_input = input.size();
  return surface;
}

float readFloat(const sensor_msgs::PointCloud2& message, Index point, std::size_t offset) {
  float value;
  std::memcpy(&value, message.data.data() + point * message.point_step + offset, sizeof value);
  return value;
}

std::vector<std::string> fieldNames(const sensor_msgs::PointCloud2& message) {
  std::vector<std::string> names;
  for (const auto& field : message.fields) names.push_back(field.name);
  return names;
}

/// Fields without gaps, points and rows without gaps, as much data as points.
void expectPacked(const sensor_msgs::PointCloud2& message) {
  std::uint32_t end = 0;
  for (const auto& field : message.fields) {
    EXPECT_EQ(field.offset, end) << field.name;
    end += cloud::sizeOf(static_cast<cloud::ScalarType>(field.datatype)) * field.count;
  }
  EXPECT_EQ(message.point_step, end);
  EXPECT_EQ(message.row_step, message.width * message.point_step);
  EXPECT_EQ(message.data.size(), std::size_t{message.row_step} * message.height);
  EXPECT_FALSE(message.is_bigendian);
}

TEST(SurfaceEncoder, WritesComputedFieldsThenTheInputsOwn) {
  const cloud::PointCloud input = makeInput();
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, true, false).encode(makeSurface(input), message);
  EXPECT_EQ(fieldNames(message),
            (std::vector<std::string>{"x", "y", "z", "normal_x", "normal_y", "normal_z", "displacement", "rgb", "shorts"}));
  expectPacked(message);
  EXPECT_EQ(message.width, 3u);
  EXPECT_EQ(message.height, 2u);
  EXPECT_TRUE(message.is_dense);
  EXPECT_EQ(readFloat(message, 4, 0), 0.1f);
  EXPECT_EQ(readFloat(message, 4, 8), 0.5f);
  EXPECT_EQ(readFloat(message, 4, 16), 1.0f);
  EXPECT_EQ(readFloat(message, 4, 24), 0.5f);
  EXPECT_EQ(std::memcmp(message.data.data() + 5 * message.point_step + 28, input.extra_fields[0].bytes.data() + 5 * 4, 4), 0);
  EXPECT_EQ(std::memcmp(message.data.data() + 5 * message.point_step + 32, input.extra_fields[1].bytes.data() + 5 * 8, 8), 0);
}

TEST(SurfaceEncoder, WritesWhatTheDecoderReadsBack) {
  const cloud::PointCloud input = makeInput();
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, true, false).encode(makeSurface(input), message);
  const DecodedCloud decoded = decodeCloud(message, DecodeLimits());
  ASSERT_TRUE(decoded.ok()) << decoded.problem;
  EXPECT_EQ(decoded.cloud.normals, Points(6, Vec3::UnitY()));
  ASSERT_EQ(decoded.cloud.extra_fields.size(), 3u);
  EXPECT_EQ(decoded.cloud.extra_fields[0].name, "displacement");
  EXPECT_EQ(decoded.cloud.extra_fields[1].bytes, input.extra_fields[0].bytes);
  EXPECT_EQ(decoded.cloud.extra_fields[2].bytes, input.extra_fields[1].bytes);
}

TEST(SurfaceEncoder, LeavesOutNormalsThatNobodyComputes) {
  const cloud::PointCloud input = makeInput();
  simulation::Surface surface = makeSurface(input);
  surface.normals.clear();
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, false, false).encode(surface, message);
  EXPECT_EQ(fieldNames(message), (std::vector<std::string>{"x", "y", "z", "displacement", "rgb", "shorts"}));
  expectPacked(message);
  EXPECT_EQ(readFloat(message, 2, 12), 0.5f);
}

TEST(SurfaceEncoder, WritesErrorsInPlaceOfTheInputsFieldOfThatName) {
  cloud::PointCloud input = makeInput();
  input.extra_fields.push_back(makeExtra("error", cloud::ScalarType::kFloat32, 1, 6));
  simulation::Surface surface = makeSurface(input);
  surface.error.assign(6, 0.25f);
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, true, true).encode(surface, message);
  EXPECT_EQ(fieldNames(message), (std::vector<std::string>{"x", "y", "z", "normal_x", "normal_y", "normal_z", "displacement",
                                                           "error", "rgb", "shorts"}));
  expectPacked(message);
  EXPECT_EQ(readFloat(message, 3, 24), 0.5f);
  EXPECT_EQ(readFloat(message, 3, 28), 0.25f);
  EXPECT_EQ(std::memcmp(message.data.data() + 5 * message.point_step + 32, input.extra_fields[0].bytes.data() + 5 * 4, 4), 0);
}

TEST(SurfaceEncoder, ReplacesFieldsOfTheInputThatItComputes) {
  cloud::PointCloud input = makeInput();
  input.extra_fields = {makeExtra("displacement", cloud::ScalarType::kFloat32, 1, 6),
                        makeExtra("normal_x", cloud::ScalarType::kFloat32, 1, 6)};
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, true, false).encode(makeSurface(input), message);
  EXPECT_EQ(message.fields.size(), 7u);
  expectPacked(message);
}

TEST(SurfaceEncoder, KeepsHolesInPlaceAndSaysSo) {
  const cloud::PointCloud input = makeInput();
  simulation::Surface surface = makeSurface(input);
  surface.positions[3].setConstant(kNan);
  surface.displacement[3] = kNan;
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, true, false).encode(surface, message);
  EXPECT_FALSE(message.is_dense);
  EXPECT_EQ(message.width * message.height, 6u);
  EXPECT_TRUE(std::isnan(readFloat(message, 3, 0)) && std::isnan(readFloat(message, 3, 24)));
  EXPECT_FALSE(std::isnan(readFloat(message, 2, 0)) || std::isnan(readFloat(message, 4, 0)));
}

TEST(SurfaceEncoder, AppendsInsertedPointsWithTheFieldsOfTheirSource) {
  const cloud::PointCloud input = makeInput();
  simulation::Surface surface = makeSurface(input);
  surface.positions.emplace_back(1.0, 2.0, 3.0);
  surface.normals.push_back(Eigen::Vector3f::UnitX());
  surface.displacement.push_back(0.25f);
  surface.source = {4};
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(input, true, false).encode(surface, message);
  expectPacked(message);
  EXPECT_EQ(message.width, 7u);
  EXPECT_EQ(message.height, 1u);
  EXPECT_EQ(readFloat(message, 6, 4), 2.0f);
  EXPECT_EQ(readFloat(message, 6, 24), 0.25f);
  EXPECT_EQ(std::memcmp(message.data.data() + 6 * message.point_step + 32, input.extra_fields[1].bytes.data() + 4 * 8, 8), 0);
}

TEST(SurfaceEncoder, FillsAMessageThatWasUsedBefore) {
  const cloud::PointCloud input = makeInput();
  const SurfaceEncoder encoder(input, true, false);
  sensor_msgs::PointCloud2 fresh, used;
  simulation::Surface surface = makeSurface(input);
  encoder.encode(surface, fresh);
  surface.positions.emplace_back(kNan, 2.0, 3.0);
  surface.normals.push_back(Eigen::Vector3f::UnitX());
  surface.displacement.push_back(kNan);
  surface.source = {0};
  encoder.encode(surface, used);
  encoder.encode(makeSurface(input), used);
  EXPECT_EQ(fresh.data, used.data);
  EXPECT_EQ(fresh.width, used.width);
  EXPECT_EQ(fresh.is_dense, used.is_dense);
}

TEST(SimulationPoints, BringPositionNormalMassStrainAndFlags) {
  const Points positions{{1, 2, 3}, {4, 5, 6}}, normals(2, Vec3::UnitZ());
  sensor_msgs::PointCloud2 message;
  encodeSimulationPoints({positions, normals, {0.1, 0.2}, {0.01, 0.02}, {1, 0}, {0, 1}, {}, {}}, message);
  EXPECT_EQ(fieldNames(message),
            (std::vector<std::string>{"x", "y", "z", "normal_x", "normal_y", "normal_z", "mass", "strain", "awake", "pinned"}));
  expectPacked(message);
  EXPECT_EQ(message.width, 2u);
  EXPECT_EQ(readFloat(message, 1, 8), 6.0f);
  EXPECT_EQ(readFloat(message, 1, 20), 1.0f);
  EXPECT_EQ(readFloat(message, 1, 24), 0.2f);
  EXPECT_EQ(readFloat(message, 1, 28), 0.02f);
  EXPECT_EQ(message.data[32], 1);
  EXPECT_EQ(message.data[33], 0);
  EXPECT_EQ(message.data[message.point_step + 32], 0);
  EXPECT_EQ(message.data[message.point_step + 33], 1);
}

TEST(SimulationPoints, OfParticlesBringTheirTemperatureAndId) {
  const Points positions{{1, 2, 3}, {4, 5, 6}}, normals(2, Vec3::UnitZ());
  std::vector<model::ParticleTraits> traits(2);
  traits[1].temperature = 300.5;
  traits[1].id = 77;
  sensor_msgs::PointCloud2 message;
  encodeSimulationPoints({positions, normals, {0.1, 0.2}, {0.01, 0.02}, {1, 0}, {0, 1}, traits, {}}, message);
  const std::vector<std::string> names = fieldNames(message);
  ASSERT_EQ(names.size(), 12u);
  EXPECT_EQ(names[10], "temperature");
  EXPECT_EQ(names[11], "id");
  expectPacked(message);
  EXPECT_EQ(readFloat(message, 1, 34), 300.5f);
  std::uint32_t id = 0;
  std::memcpy(&id, message.data.data() + message.point_step + 38, sizeof id);
  EXPECT_EQ(id, 77u);
}

TEST(SimulationPoints, OfSolidsBringTheirStress) {
  const Points positions{{1, 2, 3}, {4, 5, 6}}, normals(2, Vec3::UnitZ());
  sensor_msgs::PointCloud2 message;
  encodeSimulationPoints({positions, normals, {0.1, 0.2}, {0.01, 0.02}, {1, 0}, {0, 1}, {}, {1000.0, 2500.0}}, message);
  ASSERT_EQ(fieldNames(message).size(), 11u);
  EXPECT_EQ(fieldNames(message)[10], "stress");
  expectPacked(message);
  EXPECT_EQ(readFloat(message, 0, 34), 1000.0f);
  EXPECT_EQ(readFloat(message, 1, 34), 2500.0f);
}

}  // namespace
}  // namespace deformable_surface::node
