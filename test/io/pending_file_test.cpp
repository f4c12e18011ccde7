// Files that get their final names when they are complete, also through symbolic links.
#include "deformable_surface/io/pending_file.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace deformable_surface::io {
namespace {

namespace fs = std::filesystem;

class PendingFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("pending_file_test_" + std::to_string(getpid()));
    fs::create_directories(folder_ / "shelf");
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string read(const std::string& name) const {
    std::ifstream stream(path(name));
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void write(const std::string& name, const std::string& text) const {
    PendingFile file(path(name));
    std::ofstream(file.temporary()) << text;
    file.keep();
  }

  fs::path folder_;
};

TEST_F(PendingFiles, HaveTheirNameOnlyWhenTheyAreKept) {
  write("a", "old");
  std::string temporary;
  {
    const PendingFile file(path("a"));
    temporary = file.temporary();
    std::ofstream(temporary) << "half";
    EXPECT_EQ(read("a"), "old");
  }
  EXPECT_EQ(read("a"), "old");
  EXPECT_FALSE(fs::exists(temporary));
  write("a", "new");
  EXPECT_EQ(read("a"), "new");
  EXPECT_FALSE(fs::exists(temporary));
}

TEST_F(PendingFiles, ReplaceWhatASymbolicLinkLeadsTo) {
  write("shelf/a", "old");
  fs::create_symlink("shelf/a", path("relative"));
  fs::create_symlink(path("relative"), path("absolute"));
  fs::create_symlink("shelf/b", path("to_be"));
  for (const char* link : {"relative", "absolute"}) {
    write(link, link);
    EXPECT_TRUE(fs::is_symlink(path(link)));
    EXPECT_EQ(read("shelf/a"), link);
  }
  write("to_be", "new");
  EXPECT_EQ(fs::read_symlink(path("to_be")), "shelf/b");
  EXPECT_EQ(read("shelf/b"), "new");
  EXPECT_EQ(followLinks(path("absolute")), path("shelf/a"));
  EXPECT_EQ(followLinks("no_link"), "no_link");
}

TEST_F(PendingFiles, AreRefusedWhereNoFileCanBe) {
  fs::create_symlink("round_2", path("round_1"));
  fs::create_symlink("round_1", path("round_2"));
  fs::create_symlink("shelf", path("folder"));
  for (const char* name : {"shelf", "folder", "round_1"}) EXPECT_THROW(PendingFile{path(name)}, InputError) << name;
  PendingFile nowhere(path("missing/a"));
  EXPECT_THROW(nowhere.keep(), InputError);
}

}  // namespace
}  // namespace deformable_surface::io
