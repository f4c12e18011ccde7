#include "deformable_surface/io/pending_file.h"

#include "deformable_surface/base/error.h"

#include <cstdio>
#include <filesystem>

namespace deformable_surface::io {
namespace {

namespace fs = std::filesystem;

// As many as Linux follows.
constexpr int kMaxLinks = 40;

}  // namespace

std::string followLinks(const std::string& file) {
  fs::path path = file;
  std::error_code error;
  for (int count = 0; fs::is_symlink(path, error); ++count) {
    if (count == kMaxLinks)
      throw InputError(file + ": found symbolic links that go round in a circle; accepted: links that end at a file");
    path = path.parent_path() / fs::read_symlink(path, error);
  }
  return path.string();
}

PendingFile::PendingFile(const std::string& file) : name_(file), file_(followLinks(file)), temporary_(file_ + ".partial") {
  std::error_code error;
  if (fs::exists(file_, error) && !fs::is_regular_file(file_, error))
    throw InputError(name_ + ": found something that is no file there; accepted: a new file, or one to be replaced");
}

PendingFile::~PendingFile() {
  if (!kept_) std::remove(temporary_.c_str());
}

void PendingFile::keep() {
  if (std::rename(temporary_.c_str(), file_.c_str()) != 0) {
    throw InputError(name_ +
                     ": the finished file cannot be put there; accepted: the name of a file in a folder that can be written");
  }
  kept_ = true;
}

}  // namespace deformable_surface::io
