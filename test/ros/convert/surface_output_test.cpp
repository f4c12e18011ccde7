// Statistics as a message, and the surface as a cloud for files.
#include "deformable_surface/ros/convert/surface_output.h"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>
#include <string>
#include <type_traits>

namespace deformable_surface::node {
namespace {

TEST(MakeOutputCloud, HasErrorsInPlaceOfTheInputsFieldOfThatName) {
  cloud::PointCloud input;
  input.positions = Points(2, Vec3::Zero());
  input.width = 2;
  for (const char* name : {"error", "rgb"})
    input.extra_fields.push_back({name, cloud::ScalarType::kFloat32, 1, {0, 1, 2, 3, 4, 5, 6, 7}});
  simulation::Surface surface;
  surface.positions = input.positions;
  EXPECT_EQ(makeOutputCloud(surface, input).extra_fields.front().bytes, input.extra_fields.front().bytes);
  surface.error = {0.5f, 0.25f};
  const cloud::PointCloud output = makeOutputCloud(surface, input);
  ASSERT_EQ(output.extra_fields.size(), 2u);
  EXPECT_EQ(output.extra_fields[0].name, "error");
  EXPECT_EQ(std::memcmp(output.extra_fields[0].bytes.data(), surface.error.data(), 8), 0);
  EXPECT_EQ(output.extra_fields[1].name, "rgb");
}

TEST(EncodeStatistics, FillsOldNamesAsTheNewOnes) {
  simulation::Statistics statistics;
  statistics.links = 7;
  statistics.error_bounded = true;
  statistics.error_stiffness = 0.5;
  statistics.tracking_residual = 0.25;
  statistics.tracked_points = 3;
  Statistics message;
  encodeStatistics(statistics, {}, message);
  EXPECT_EQ(message.links, 7u);
  EXPECT_TRUE(message.error_bounded);
  EXPECT_EQ(message.springs, 7u);
  EXPECT_EQ(message.error_stiffness, 0.5);
  EXPECT_EQ(message.error_softening, 0.5);
  EXPECT_EQ(message.tracking_residual, 0.25);
  EXPECT_EQ(message.track_residual, 0.25);
  EXPECT_EQ(message.tracked_points, 3u);
  EXPECT_EQ(message.track_points, 3u);
}

// The fields of the core and those of the message have the same names, so that a text of the message shows each value behind
// its name.
TEST(EncodeStatistics, CopiesEveryField) {
  simulation::Statistics statistics;
  double next = 1.0;
  visitFields(statistics, [&](const std::string&, const auto& value) {
    using Field = std::decay_t<decltype(value)>;
    auto& field = const_cast<Field&>(value);
    if constexpr (std::is_arithmetic<Field>::value)
      field = static_cast<Field>(next++);  // of a flag: true
    else
      field = {"a stage"};
  });
  Statistics message;
  encodeStatistics(statistics, {}, message);
  std::ostringstream text;
  text << message;
  visitFields(statistics, [&](const std::string& name, const auto& value) {
    using Field = std::decay_t<decltype(value)>;
    std::ostringstream line;
    if constexpr (std::is_same<Field, bool>::value)
      line << "\n" << name << ": " << static_cast<int>(value) << "\n";
    else if constexpr (std::is_arithmetic<Field>::value)
      line << "\n" << name << ": " << value << "\n";
    else
      line << "\n" << name << "[]\n  " << name << "[0]: " << value.at(0) << "\n";
    EXPECT_NE(text.str().find(line.str()), std::string::npos) << line.str();
  });
}

}  // namespace
}  // namespace deformable_surface::node
