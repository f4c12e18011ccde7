// Point files: every encoding is written and read, other fields are kept, and broken files are refused with their name.
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "support/comma_locale.h"
#include "support/shared_data.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

using namespace deformable_surface;
using namespace deformable_surface::io;
using cloud::ExtraField;
using cloud::PointCloud;
using cloud::ScalarType;

namespace {

constexpr Index kMany = 1000000;

/// A folder of its own for each test, removed at the end.
class PointFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "point_files_XXXXXX";
    ASSERT_NE(mkdtemp(&folder_[0]), nullptr);
  }
  void TearDown() override {
    for (const std::string& file : files_) std::remove(file.c_str());
    rmdir(folder_.c_str());
  }
  std::string path(const std::string& name) {
    files_.push_back(folder_ + "/" + name);
    return files_.back();
  }
  std::string write(const std::string& name, const std::string& content) {
    const std::string file = path(name);
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  /// The message of an attempt to read a file with this content.
  std::string problem(const std::string& name, const std::string& content, Index max_points = kMany) {
    const std::string file = write(name, content);
    try {
      readPointFile(file, 1.0, max_points);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).compare(0, file.size(), file), 0) << error.what();
      return error.what();
    }
    return "accepted";
  }

  std::string folder_;

 private:
  std::vector<std::string> files_;
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

template <class T>
ExtraField makeField(const std::string& name, ScalarType type, std::uint32_t count, const std::vector<T>& values) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(values.data());
  return {name, type, count, {bytes, bytes + values.size() * sizeof(T)}};
}

PointCloud makeCloud() {
  PointCloud cloud;
  cloud.positions = {Vec3(0, 0.5, 1), Vec3(NAN, NAN, NAN), Vec3(-1.5, 2, 3), Vec3(4, 5, 6)};
  cloud.normals = {Vec3(0, 0, 1), Vec3(NAN, NAN, NAN), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  cloud.extra_fields.push_back(makeField<float>("intensity", ScalarType::kFloat32, 1, {1, 2, 3, 4}));
  cloud.extra_fields.push_back(makeField<std::uint32_t>("rgba", ScalarType::kUint32, 1, {0xff010203, 0x80102030, 0, 0x01ffffff}));
  cloud.extra_fields.push_back(makeField<std::int16_t>("pair", ScalarType::kInt16, 2, {1, -1, 2, -2, 3, -3, 4, -4}));
  cloud.width = cloud.height = 2;
  return cloud;
}

const ExtraField* findField(const PointCloud& cloud, const std::string& name) {
  for (const ExtraField& field : cloud.extra_fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

bool isSame(const Points& a, const Points& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      if (!(a[i][c] == b[i][c] || (std::isnan(a[i][c]) && std::isnan(b[i][c])))) return false;
    }
  }
  return true;
}

std::string makePcd(const std::string& points, const std::string& data, const std::string& body,
                    const std::string& sizes = "4 4 4", const std::string& names = "x y z") {
  return "VERSION 0.7\nFIELDS " + names + "\nSIZE " + sizes + "\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + points +
         "\nHEIGHT 1\nVIEWPOINT 0 0 2 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n" + body;
}

std::string makePly(const std::string& points, const std::string& properties, const std::string& body,
                    const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\ncomment made by a test\nelement vertex " + points + "\n" + properties + "end_header\n" +
         body;
}

const char* const kXyz = "property float x\nproperty float y\nproperty float z\n";

}  // namespace

TEST_F(PointFiles, PcdKeepsAllThatItIsGiven) {
  PointCloud cloud = makeCloud();
  cloud.viewpoint = Vec3(512345.67, 0.1, 2);  // in a map
  const std::string file = path("a.pcd");
  writePointFile(file, cloud, {0.0f, NAN, 0.25f, 0.5f});
  const PointCloud back = readPointFile(file, 1.0, kMany);
  EXPECT_TRUE(isSame(back.positions, cloud.positions));
  EXPECT_TRUE(isSame(back.normals, cloud.normals));
  EXPECT_EQ(back.width, 2u);
  EXPECT_EQ(back.height, 2u);
  ASSERT_TRUE(back.viewpoint);
  EXPECT_EQ(*back.viewpoint, *cloud.viewpoint);
  ASSERT_EQ(back.extra_fields.size(), 4u);
  EXPECT_EQ(back.extra_fields[0].name, "displacement");
  for (std::size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(back.extra_fields[f + 1].name, cloud.extra_fields[f].name);
    EXPECT_EQ(back.extra_fields[f + 1].type, cloud.extra_fields[f].type);
    EXPECT_EQ(back.extra_fields[f + 1].count, cloud.extra_fields[f].count);
    EXPECT_EQ(back.extra_fields[f + 1].bytes, cloud.extra_fields[f].bytes);
  }
}

TEST_F(PointFiles, PlyKeepsPointsNormalsAndColours) {
  const PointCloud cloud = makeCloud();
  const std::string file = path("a.ply");
  writePointFile(file, cloud, {0.0f, NAN, 0.25f, 0.5f});
  const PointCloud back = readPointFile(file, 1.0, kMany);
  EXPECT_TRUE(isSame(back.positions, cloud.positions));
  EXPECT_TRUE(isSame(back.normals, cloud.normals));
  ASSERT_TRUE(findField(back, "rgba"));
  EXPECT_EQ(findField(back, "rgba")->bytes, cloud.extra_fields[1].bytes);
  ASSERT_TRUE(findField(back, "pair_1"));
  EXPECT_EQ(findField(back, "pair_1")->bytes, makeField<std::int16_t>("", ScalarType::kInt16, 1, {-1, -2, -3, -4}).bytes);
  ASSERT_TRUE(findField(back, "displacement"));
  float displacement = 0.0f;
  std::memcpy(&displacement, &findField(back, "displacement")->bytes[2 * sizeof(float)], sizeof(float));
  EXPECT_EQ(displacement, 0.25f);
}

TEST_F(PointFiles, WritingReplacesTheOldDisplacementAndLeavesNoPartialFile) {
  PointCloud cloud = makeCloud();
  cloud.extra_fields.push_back(makeField<float>("displacement", ScalarType::kFloat32, 1, {9, 9, 9, 9}));
  const std::string file = path("a.pcd");
  writePointFile(file, cloud, {1, 2, 3, 4});
  const PointCloud back = readPointFile(file, 1.0, kMany);
  EXPECT_EQ(findField(back, "displacement")->bytes, makeField<float>("", ScalarType::kFloat32, 1, {1, 2, 3, 4}).bytes);
  EXPECT_FALSE(std::ifstream(file + ".partial").good());
}

TEST_F(PointFiles, FieldNamesCannotBreakAHeader) {
  PointCloud cloud = makeCloud();
  cloud.extra_fields[0].name = "a b\nelement face 9";
  cloud.extra_fields[2].name = "x";
  for (const char* name : {"a.pcd", "a.ply"}) {
    const std::string file = path(name);
    writePointFile(file, cloud);
    const PointCloud back = readPointFile(file, 1.0, kMany);
    EXPECT_TRUE(isSame(back.positions, cloud.positions));
    EXPECT_TRUE(findField(back, "a_b_element_face_9")) << name;
  }
}

TEST_F(PointFiles, RefusesToWriteColumnsOfAnotherLength) {
  const auto problemOf = [&](const PointCloud& cloud, const std::vector<float>& displacement) -> std::string {
    const std::string file = path("a.ply");
    try {
      writePointFile(file, cloud, displacement);
    } catch (const InputError& error) {
      EXPECT_FALSE(std::ifstream(file).good());
      return std::string(error.what()).substr(file.size());
    }
    return "written";
  };
  PointCloud cloud = makeCloud();
  EXPECT_EQ(problemOf(cloud, {1, 2, 3}), ": found 3 displacements for 4 points; accepted: 4");
  cloud.normals.pop_back();
  EXPECT_EQ(problemOf(cloud, {}), ": found 3 normals for 4 points; accepted: 4");
  cloud.normals.clear();
  cloud.extra_fields[2].bytes.pop_back();
  EXPECT_EQ(problemOf(cloud, {}), ": found 15 bytes of the field 'pair' for 4 points; accepted: 16");
  cloud.extra_fields[2].type = static_cast<ScalarType>(0);
  EXPECT_EQ(problemOf(cloud, {}), ": found the type 0 of the field 'pair'; accepted: 1 to 8");
  cloud.extra_fields.clear();
  EXPECT_EQ(problemOf(cloud, {}), "written");
}

TEST_F(PointFiles, ReadsAsciiPcdWithHolesScaleAndViewpoint) {
  const std::string file = write("a.pcd", makePcd("2", "ascii", "1 2 3\nnan nan nan\n"));
  const PointCloud cloud = readPointFile(file, 0.001, kMany);
  EXPECT_TRUE(cloud.positions[0].isApprox(Vec3(0.001, 0.002, 0.003)));
  EXPECT_TRUE(std::isnan(cloud.positions[1].x()));
  ASSERT_TRUE(cloud.viewpoint);
  EXPECT_EQ(*cloud.viewpoint, Vec3(0, 0, 0.002));
}

TEST_F(PointFiles, ReadsNumbersWithAPointInEveryLocale) {
  const test::CommaLocale locale;
  if (!locale.isThere()) GTEST_SKIP() << test::CommaLocale::kNone;
  const std::string rows = "0.5 1.5 2.5\n3.5 4.5 5.5\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS "
      "2\nDATA "
      "ascii\n";
  for (const std::string& file : {write("a.xyz", rows), write("a.ply", ply + rows), write("a.pcd", pcd + rows)})
    EXPECT_TRUE(isSame(readPointFile(file, 1.0, kMany).positions, {Vec3(0.5, 1.5, 2.5), Vec3(3.5, 4.5, 5.5)})) << file;
}

TEST_F(PointFiles, ReadsDoublesInFull) {
  const double values[3] = {0.1, 1e6 + 1e-7, -1e-300};
  const std::string body(reinterpret_cast<const char*>(values), sizeof(values));
  const Vec3 expected(values[0], values[1], values[2]);
  EXPECT_EQ(readPointFile(write("a.pcd", makePcd("1", "binary", body, "8 8 8")), 1.0, kMany).positions[0], expected);
  const std::string properties = "property double x\nproperty double y\nproperty double z\n";
  EXPECT_EQ(readPointFile(write("a.ply", makePly("1", properties, body, "binary_little_endian")), 1.0, kMany).positions[0],
            expected);
}

TEST_F(PointFiles, LeavesOutTheFacesOfAMesh) {
  const std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n" + std::string(kXyz) +
                           "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  EXPECT_EQ(readPointFile(write("a.ply", text), 1.0, kMany).size(), 3);
}

TEST_F(PointFiles, ReadsPlainTextWithAndWithoutNormals) {
  const PointCloud plain = readPointFile(write("a.xyz", "# a comment\n1 2 3\n\n 4\t5 6\r\n"), 2.0, kMany);
  ASSERT_EQ(plain.size(), 2);
  EXPECT_EQ(plain.positions[1], Vec3(8, 10, 12));
  EXPECT_TRUE(plain.normals.empty());
  const PointCloud oriented = readPointFile(write("b.XYZ", "1 2 3 0 0 1 7.5"), 2.0, kMany);
  EXPECT_EQ(oriented.normals[0], Vec3(0, 0, 1));
  ASSERT_TRUE(findField(oriented, "column_7"));
  EXPECT_EQ(findField(oriented, "column_7")->bytes, makeField<double>("", ScalarType::kFloat64, 1, {7.5}).bytes);
  EXPECT_TRUE(readPointFile(write("c.xyz", "1 2 3 0 0 0\n"), 1.0, kMany).normals.empty());
}

TEST_F(PointFiles, TakesColumnsThatAreNotOfUnitLengthForNoNormals) {
  const PointCloud colours = readPointFile(write("a.xyz", "1 2 3 255 0 10 7\n4 5 6 0 0 1 8\n"), 1.0, kMany);
  EXPECT_TRUE(colours.normals.empty());
  ASSERT_EQ(colours.extra_fields.size(), 4u);
  EXPECT_EQ(colours.extra_fields[3].name, "column_7");
  ASSERT_TRUE(findField(colours, "column_4"));
  EXPECT_EQ(findField(colours, "column_4")->bytes, makeField<double>("", ScalarType::kFloat64, 1, {255, 0}).bytes);
  EXPECT_EQ(findField(colours, "column_6")->bytes, makeField<double>("", ScalarType::kFloat64, 1, {10, 1}).bytes);
  std::string rounded, missing;
  for (int i = 0; i < 20; ++i) {
    rounded += i < 19 ? "1 2 3 0.67 0.67 0.33\n" : "1 2 3 1 1 1\n";
    missing += i < 10 ? "1 2 3 0 0 0\n" : "1 2 3 0 1 0\n";
  }
  EXPECT_EQ(readPointFile(write("b.xyz", rounded), 1.0, kMany).normals.size(), 20u);
  EXPECT_EQ(readPointFile(write("c.xyz", missing), 1.0, kMany).normals.size(), 20u);
}

TEST_F(PointFiles, NamesTheLineOfAPlyThatIsNotAsItsHeaderSays) {
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", kXyz, "1 2 3\n4 5 6\n")),
                       "line 10: found '4 5 6'; accepted: as many lines as the header says, 1"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("2", kXyz, "1 2 3\na b c\n")),
                       "line 10: found 'a b c'; accepted: a number for each of the 3 properties"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("2", kXyz, "1 2 3\n4.25 5.25\n")), "line 10: found '4.25 5.25'"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("2", kXyz, "1 2 3\n4 5 6 7\n")),
                       "line 10: found '4 5 6 7'; accepted: a number for each"));
  EXPECT_TRUE(
      contains(problem("a.ply", makePly("3", kXyz, "1.25 2.25 3.25\n4.25 5.25 6.25\n")), "found 2 lines behind the header"));
  EXPECT_EQ(readPointFile(write("a.ply", makePly("2", kXyz, "1 2 3\r\nnan nan nan\r\n\n \n")), 1.0, kMany).size(), 2);
}

TEST_F(PointFiles, RefusesNumbersThatTheTypeOfAPlyCannotHold) {
  const auto found = [&](const std::string& type, const std::string& number) {
    return problem("a.ply", makePly("2", kXyz + ("property " + type + " a\n"), "1 2 3 4\n4 5 6 " + number + "\n"));
  };
  EXPECT_TRUE(contains(found("uchar", "300"), "line 11: found '4 5 6 300'; accepted: whole numbers from 0 to 255 for 'a'"));
  EXPECT_TRUE(contains(found("int16", "-32769"), "from -32768 to 32767"));
  EXPECT_TRUE(contains(found("uint", "1.5"), "from 0 to 4294967295"));
  for (const char* type : {"uchar", "uint8", "int16", "uint", "int"}) EXPECT_EQ(found(type, "255"), "accepted") << type;
  for (const char* type : {"float", "double"}) EXPECT_EQ(found(type, "300.5"), "accepted") << type;
}

TEST_F(PointFiles, SkipsTheByteOrderMarkOfPlainText) {
  EXPECT_EQ(readPointFile(write("a.xyz",
                                "\xEF\xBB\xBF"
                                "1 2 3\n4 5 6\n"),
                          1.0, kMany)
                .positions[0],
            Vec3(1, 2, 3));
  EXPECT_EQ(readPointFile(write("a.obj", "\xEF\xBB\xBFv 1 2 3\n"), 1.0, kMany).positions[0], Vec3(1, 2, 3));
  EXPECT_NE(problem("a.xyz",
                    "1 2 3\n\xEF\xBB\xBF"
                    "4 5 6\n"),
            "accepted");
}

TEST_F(PointFiles, RefusesBrokenPlainText) {
  EXPECT_TRUE(contains(problem("a.xyz", "1 2\n"), "line 1: found 2 numbers"));
  EXPECT_TRUE(contains(problem("a.xyz", "1 2 3\n1 2 3 4 5 6\n"), "line 2: found 6 numbers; accepted: 3"));
  EXPECT_TRUE(contains(problem("a.xyz", "1 2 3\n1 2 x\n"), "line 2: found 'x"));
  EXPECT_TRUE(contains(problem("a.xyz", "# nothing\n"), "no points"));
  EXPECT_TRUE(contains(problem("a.xyz", "1 2 3\n1 2 3\n1 2 3\n", 2), "at most 2"));
}

TEST_F(PointFiles, TakesTheVerticesOfAnObject) {
  const std::string text =
      "# a triangle\no shirt\nv 0 0 0\n  v 1 0 0 1.0 # with a weight\nv\t0 1 0 0.5 0.5 0.5\r\n"
      "vn 0 0 1\nvt 0 0\nf 1//1 2//1 3//1\n";
  const PointCloud cloud = readPointFile(write("a.obj", text), 2.0, kMany);
  ASSERT_EQ(cloud.size(), 3);
  EXPECT_EQ(cloud.positions[1], Vec3(2, 0, 0));
  EXPECT_EQ(cloud.positions[2], Vec3(0, 2, 0));
  EXPECT_TRUE(cloud.normals.empty());
}

TEST_F(PointFiles, RefusesBrokenObjects) {
  EXPECT_TRUE(contains(problem("a.obj", "v 1 2 3\nv 1 2\n"), "line 2: found a vertex of 2 numbers"));
  EXPECT_TRUE(contains(problem("a.obj", "v\n"), "line 1: found a vertex of 0 numbers"));
  EXPECT_TRUE(contains(problem("a.obj", "v 1 2 x\n"), "line 1: found 'x'"));
  EXPECT_TRUE(contains(problem("a.obj", "vn 0 0 1\nf 1 2 3\n"), "no points"));
  EXPECT_TRUE(contains(problem("a.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\n", 2), "at most 2"));
}

TEST_F(PointFiles, TakesTheVerticesOfAnOffFile) {
  const std::string rows = "0 0 0\n 1 0 0 0.5 0.5 0.5 1 # a colour\n\n0 1 0\r\n3 0 1 2\n";
  for (const char* head : {"OFF\n3 1 0\n", "# a triangle\nOFF 3 1 0\n", "COFF # colours\n# counts\n3 1 0\r\n", "NOFF\n3\n"}) {
    const PointCloud cloud = readPointFile(write("a.off", head + rows), 2.0, kMany);
    ASSERT_EQ(cloud.size(), 3) << head;
    EXPECT_EQ(cloud.positions[1], Vec3(2, 0, 0));
    EXPECT_EQ(cloud.positions[2], Vec3(0, 2, 0));
    EXPECT_TRUE(cloud.normals.empty());
  }
}

TEST_F(PointFiles, RefusesBrokenOffFiles) {
  EXPECT_TRUE(contains(problem("a.off", ""), "begins with ''"));
  EXPECT_TRUE(contains(problem("a.off", "3 1 0\n0 0 0\n"), "begins with '3'; accepted: OFF"));
  EXPECT_TRUE(contains(problem("a.off", "4OFF\n1 0 0\n0 0 0 1\n"), "begins with '4OFF'"));
  EXPECT_TRUE(contains(problem("a.off", "OFF BINARY\n1 0 0\n"), "line 1: found 'BINARY'"));
  for (const char* count : {"0", "-1", "1.5", "nan", "inf"})
    EXPECT_NE(problem("a.off", std::string("OFF\n") + count + " 0 0\n0 0 0\n"), "accepted") << count;
  EXPECT_TRUE(contains(problem("a.off", "OFF\n"), "no number of vertices"));
  EXPECT_TRUE(contains(problem("a.off", "OFF\n4000000000 0 0\n0 0 0\n"), "found 1 vertices; accepted: as many"));
  EXPECT_TRUE(contains(problem("a.off", "OFF\n2 0 0\n0 0 0\n0 0\n"), "line 4: found a vertex of 2 numbers"));
  EXPECT_TRUE(contains(problem("a.off", "OFF\n3 0 0\n1 2 3\n1 2 3\n1 2 3\n", 2), "at most 2"));
}

TEST_F(PointFiles, RefusesHeadersThatPromiseMoreThanTheFileHolds) {
  for (const char* count : {"4000000000", "1000000000000", "99999999999999999999", "-1", "1e3", "x"}) {
    for (const char* data : {"ascii", "binary", "binary_compressed"}) {
      EXPECT_NE(problem("a.pcd", makePcd(count, data, "1 2 3\n")), "accepted") << count << " " << data;
    }
    EXPECT_NE(problem("a.ply", makePly(count, kXyz, "1 2 3\n")), "accepted") << count;
  }
  // A number of points that is accepted, but that the file does not contain.
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("900000", "ascii", "1 2 3\n")), "need at least"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("2", "binary", std::string(23, 'a'))), "need at least 24"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("2", kXyz, std::string(23, 'a'), "binary_little_endian")), "need at least 24"));
  EXPECT_TRUE(
      contains(problem("a.pcd", makePcd("2", "binary_compressed", std::string("\x05\0\0\0\x18\0\0\0abc", 11))), "compressed"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("2", "binary_compressed", "abc")), "compressed"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("3", "ascii", "1 2 3\n1 2 3\n1 2 3\n"), 2), "at most 2"));
}

TEST_F(PointFiles, RefusesMoreRowsThanAPcdSays) {
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("2", "ascii", "1 2 3\n4 5 6\n7 8 9\n")),
                       "row 2 behind the header: found '7 8 9'; accepted: as many rows as the header says, 2"));
  EXPECT_EQ(readPointFile(write("a.pcd", makePcd("2", "ascii", "1 2 3\r\n4 5 6\r\n\n \n")), 1.0, kMany).size(), 2);
}

TEST_F(PointFiles, RefusesShortAsciiBodies) {
  EXPECT_NE(problem("a.pcd", makePcd("3", "ascii", "1.25 2.25 3.25\n1.25 2.25 3.25\n")), "accepted");
  EXPECT_NE(problem("a.ply", makePly("3", kXyz, "1.25 2.25 3.25\n1.25 2.25 3.25\n")), "accepted");
}

TEST_F(PointFiles, RefusesFilesWithoutUsablePositions) {
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("1", "ascii", "1 2 3\n", "4 4 4", "x y intensity")), "no x, y, z"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", "property float x\nproperty float y\n", "1 2\n")), "no x, y, z"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("0", "ascii", "")), "no points"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("1", "ascii", "1 2 3\n", "4 4")), "different lengths"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("1", "ascii", "1 2 3\n", "4 4 3")), "'F3'"));
  EXPECT_TRUE(contains(problem("a.pcd", makePcd("1", "zip", "1 2 3\n")), "'zip'"));
  EXPECT_TRUE(contains(problem("a.pcd", "hello\n"), "'DATA'"));
  EXPECT_TRUE(contains(problem("a.pcd", ""), "no bytes"));
  EXPECT_TRUE(contains(problem("a.stl", "v 1 2 3"), "'.stl'; accepted: .pcd, .ply, .obj, .off, .xyz"));
}

TEST_F(PointFiles, RefusesPlyHeadersThatPclWouldTrust) {
  const std::string xyz = kXyz;
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", xyz + "property list uchar int a\n", "1 2 3 1 1\n")), "a list"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", "property uchar blue\n" + xyz, "1 1 2 3\n")), "out of its place"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", "property uchar alpha\n" + xyz, "1 1 2 3\n")), "out of its place"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", "property uchar red\n" + xyz, "1 1 2 3\n")), "incomplete colour"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", xyz + xyz, "1 2 3 1 2 3\n")), "twice"));
  EXPECT_TRUE(contains(problem("a.ply", "ply\nformat ascii 1.0\nobj_info num_cols 1\nelement vertex 9\n" + xyz + "end_header\n"),
                       "range grid"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", xyz + "element vertex 2\n" + xyz, "1 2 3\n")), "'vertex'"));
  EXPECT_TRUE(contains(problem("a.ply", makePly("1", xyz + "element face 999999\nproperty list uchar int a\n", "1 2 3\n")),
                       "than bytes"));
  EXPECT_TRUE(contains(problem("a.ply", "plz\nend_header\n"), "first line"));
}

TEST_F(PointFiles, EveryCutOfAFileIsRefusedOrWhole) {
  const PointCloud cloud = makeCloud();
  for (const char* name : {"a.pcd", "a.ply"}) {
    const std::string file = path(name);
    writePointFile(file, cloud);
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    for (std::size_t size = 0; size < text.str().size(); size += 3) {
      EXPECT_NE(problem(std::string("cut_") + name, text.str().substr(0, size)), "accepted") << size;
    }
  }
}

TEST_F(PointFiles, ResolvesPackages) {
  write("a.xyz", "1 2 3\n");
  const FindPackage find = [&](const std::string& package) {
    if (package != "here") throw InputError("no package " + package);
    return folder_;
  };
  EXPECT_EQ(readPointFile("package://here/a.xyz", 1.0, kMany, find).size(), 1);
  EXPECT_THROW(readPointFile("package://there/a.xyz", 1.0, kMany, find), InputError);
  EXPECT_THROW(readPointFile("package://here/a.xyz", 1.0, kMany), InputError);
  EXPECT_THROW(readPointFile("package://here", 1.0, kMany, find), InputError);
  EXPECT_THROW(readPointFile(folder_ + "/missing.pcd", 1.0, kMany), InputError);
  EXPECT_THROW(readPointFile(folder_ + "/missing.xyz", 1.0, kMany), InputError);
}

TEST_F(PointFiles, RefusesPlacesThatCannotBeWritten) {
  EXPECT_THROW(writePointFile(folder_ + "/a.xyz", makeCloud()), InputError);
  EXPECT_THROW(writePointFile(folder_ + "/none/a.ply", makeCloud()), InputError);
  EXPECT_THROW(checkPointFileName("a.stl"), InputError);
  EXPECT_NO_THROW(checkPointFileName("a.PLY"));
}

TEST(PointFilesOfTheWorld, ReadsRealScans) {
  const std::string folder = test::sharedFolder();
  if (!std::ifstream(folder + "/INDEX.md")) GTEST_SKIP() << "no real data: set DEFORMABLE_SURFACE_DATA to its folder";
  struct Scan {
    const char* file;
    Index points;
    bool has_normals;
    const char* extra;
  };
  for (const Scan& scan :
       {Scan{"pcl_scans/bun0.pcd", 397, true, "curvature"}, Scan{"pcl_scans/five_people.pcd", 307200, false, "rgba"},
        Scan{"ros_package_scans/maze.ply", 25809, true, "scalar_curvature"},
        Scan{"ros_package_scans/part_scan.ply", 3627, false, "rgba"},
        Scan{"ros_package_scans/wavy_mesh_with_hole.ply", 757, true, "rgba"}, Scan{"cgal_points/kitten.xyz", 5210, true, ""}}) {
    const PointCloud cloud = readPointFile(folder + "/" + scan.file, 1.0, kMany);
    EXPECT_EQ(cloud.size(), scan.points) << scan.file;
    EXPECT_EQ(!cloud.normals.empty(), scan.has_normals) << scan.file;
    EXPECT_TRUE(!*scan.extra || findField(cloud, scan.extra)) << scan.file;
    EXPECT_EQ(std::uint64_t{cloud.width} * cloud.height, static_cast<std::uint64_t>(cloud.size())) << scan.file;
  }
}
