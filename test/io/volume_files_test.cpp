// MetaImage files: types of samples, places of samples, and files that are refused.
#include "deformable_surface/io/volume_files.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

namespace deformable_surface::io {
namespace {

namespace fs = std::filesystem;

class VolumeFilesTest : public testing::Test {
 protected:
  VolumeFilesTest() {
    std::string name = (fs::temp_directory_path() / "volume_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~VolumeFilesTest() override { fs::remove_all(folder_); }

  // Samples 0, 1, 2 .. of 2 x 3 x 4; replaced: a line of the header by another.
  template <class T>
  std::string write(const std::string& type, const std::string& line = "", const std::string& by = "", int count = 24) {
    std::string head =
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
        "CompressedData = False\nTransformMatrix = 0 1 0 1 0 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 0.5 1 2\n"
        "DimSize = 2 3 4\nElementType = " +
        type + "\nElementDataFile = LOCAL\n";
    if (const std::size_t at = head.find(line); !line.empty()) {
      EXPECT_NE(at, std::string::npos) << line;
      head.replace(at, head.find('\n', at) - at, by);
    }
    const std::string file = (folder_ / "grid.mha").string();
    std::ofstream out(file, std::ios::binary);
    out << head;
    for (int i = 0; i < count; ++i) {
      const T value = static_cast<T>(i);
      out.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
    return file;
  }
  std::string problemOf(const std::string& file) {
    try {
      readVolumeFile(file, 1.0);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(VolumeFilesTest, ReadsEveryTypeOfSamples) {
  std::vector<float> counted;
  for (int i = 0; i < 24; ++i) counted.push_back(static_cast<float>(i));
  const auto read = [&](const std::string& file) { return readVolumeFile(file, 1.0).values(); };
  EXPECT_EQ(read(write<std::uint8_t>("MET_UCHAR")), counted);
  EXPECT_EQ(read(write<std::int8_t>("MET_CHAR")), counted);
  EXPECT_EQ(read(write<std::uint16_t>("MET_USHORT")), counted);
  EXPECT_EQ(read(write<std::int16_t>("MET_SHORT")), counted);
  EXPECT_EQ(read(write<std::uint32_t>("MET_UINT")), counted);
  EXPECT_EQ(read(write<std::int32_t>("MET_INT")), counted);
  EXPECT_EQ(read(write<float>("MET_FLOAT")), counted);
  EXPECT_EQ(read(write<double>("MET_DOUBLE")), counted);
}

TEST_F(VolumeFilesTest, SamplesLieWhereTheHeaderPutsThem) {
  const geometry::Volume volume = readVolumeFile(write<float>("MET_FLOAT"), 0.001);
  EXPECT_EQ(volume.size(), (std::array<Index, 3>{2, 3, 4}));
  // The first axis leads along y, the second along x.
  EXPECT_NEAR((volume.place(1, 2, 3) - 0.001 * Vec3(1.0 + 2.0, 2.0 + 0.5, 3.0 + 6.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(volume.sample(volume.place(1, 2, 3)).value, 23.0, 1e-9);
}

TEST_F(VolumeFilesTest, RefusesWithWhatWasFoundAndWhatIsAccepted) {
  const auto refused = [&](const std::string& line, const std::string& by, const std::string& part) {
    const std::string problem = problemOf(write<float>("MET_FLOAT", line, by));
    EXPECT_TRUE(contains(problem, part) && contains(problem, "; accepted: ")) << by << ": " << problem;
  };
  refused("NDims", "NDims = 2", "NDims: found '2'");
  refused("CompressedData", "CompressedData = True", "CompressedData: found 'True'");
  refused("BinaryDataByteOrderMSB", "BinaryDataByteOrderMSB = True", "BinaryDataByteOrderMSB: found 'True'");
  refused("ElementType", "ElementType = MET_LONG", "ElementType: found 'MET_LONG'");
  refused("ElementDataFile", "ElementDataFile = grid.raw", "ElementDataFile: found 'grid.raw'");
  refused("DimSize", "DimSize = 2 3 5", "found 96 bytes");
  refused("DimSize", "DimSize = 2 3", "DimSize: found '2 3'");
  refused("DimSize", "DimSize = 2 3 4.5", "DimSize: found");
  refused("DimSize", "DimSize = 100000 100000 100000", "DimSize: found");
  refused("DimSize", "DimSize = -2 -3 4", "DimSize: found");
  refused("ElementSpacing", "ElementSpacing = 1 nan 1", "ElementSpacing: found '1 nan 1'");
  refused("ElementSpacing", "ElementSpacing = 1 0 1", "right angles");
  refused("TransformMatrix", "TransformMatrix = 1 1 0 0 1 0 0 0 1", "right angles");
  EXPECT_TRUE(contains(problemOf(write<float>("MET_FLOAT", "", "", 23)), "found 92 bytes"));
  EXPECT_TRUE(contains(problemOf((folder_ / "none.mha").string()), "no file"));
  EXPECT_TRUE(contains(problemOf((folder_ / "grid.nrrd").string()), "accepted: .mha"));
  const std::string file = (folder_ / "text.mha").string();
  std::ofstream(file) << "something else\n";
  EXPECT_TRUE(contains(problemOf(file), "no line"));
}

TEST_F(VolumeFilesTest, AnIsoValueMustLieBetweenTheValues) {
  model::GuideParams guide;
  readGuide(guide);
  EXPECT_FALSE(guide.grid);
  guide.volume = write<float>("MET_FLOAT");
  for (const double bad : {-1.0, 0.0, 23.0, 24.0}) {
    guide.iso_value = bad;
    EXPECT_THROW(readGuide(guide), InputError) << bad;
  }
  guide.iso_value = 11.5;
  readGuide(guide);
  EXPECT_TRUE(guide.grid);
}

}  // namespace
}  // namespace deformable_surface::io
