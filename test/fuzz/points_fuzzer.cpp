// libFuzzer on the readers of point files: the first byte chooses the kind, the rest is the file.
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/point_files.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

/// A temporary file, in memory where possible, removed at the end.
struct TemporaryFile {
  explicit TemporaryFile(const char* extension)
      : name("/dev/shm/deformable_surface_fuzz_" + std::to_string(getpid()) + extension) {}
  ~TemporaryFile() { std::remove(name.c_str()); }
  const std::string name;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace deformable_surface;
  static const char* const kExtensions[] = {".pcd", ".ply", ".obj", ".xyz"};
  constexpr Index kMost = 10000;
  if (size == 0) return 0;
  const TemporaryFile file(kExtensions[bytes[0] % 4]);
  std::FILE* const stream = std::fopen(file.name.c_str(), "wb");
  if (!stream || std::fwrite(bytes + 1, 1, size - 1, stream) != size - 1 || std::fclose(stream) != 0) std::abort();
  try {
    const cloud::PointCloud cloud = io::readPointFile(file.name, 1.0, kMost);
    if (cloud.positions.empty() || static_cast<Index>(cloud.positions.size()) > kMost) std::abort();
    if (!cloud.normals.empty() && cloud.normals.size() != cloud.positions.size()) std::abort();
  } catch (const InputError&) {}
  return 0;
}
