// Meshes as files for other programs.
#include "deformable_surface/io/mesh_output.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <locale>
#include <sstream>
#include <string>

namespace deformable_surface::io {
namespace {

// As in German: 1.000,5.
struct GermanNumbers : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// Of the program that uses this library.
TEST(WriteMeshFile, DoesNotFollowTheLocale) {
  const std::string file = testing::TempDir() + "mesh_output_" + std::to_string(getpid()) + ".obj";
  const Points positions(1000, Vec3(1234.5, 0.0, 0.0)), normals(1000, Vec3::UnitZ());
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new GermanNumbers));
  writeMeshFile(file, positions, normals, {{0, 1, 999}});
  std::locale::global(before);
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  EXPECT_EQ(text.str().substr(0, 11), "v 1234.5 0 ");
  EXPECT_NE(text.str().find("f 1//1 2//2 1000//1000\n"), std::string::npos);
  std::remove(file.c_str());
}

}  // namespace
}  // namespace deformable_surface::io
