#include "simulate_files.h"

#include "simulate_outputs.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/pending_file.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/ros/convert/find_package.h"

#include <unistd.h>

#include <filesystem>
#include <utility>
#include <vector>

namespace deformable_surface::node {
namespace {

namespace fs = std::filesystem;

fs::path folderOf(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

// The path of cloud.file; empty if it is unknown, which readPointFile() refuses with its own sentence.
std::string findCloudFile(const std::string& file) {
  try {
    return io::findPointFile(file, findPackage);
  } catch (const InputError&) {
    return "";
  }
}

// Whether both are one file on the disk, also through links, or one name of a file that does not exist yet.
bool areSame(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) || (a.filename() == b.filename() && fs::equivalent(folderOf(a), folderOf(b), error));
}

}  // namespace

void checkPointFile(const std::string& option, const std::string& file) {
  io::checkPointFileName(file);
  requireWritable(option, file);
}

void requireWritable(const std::string& option, const std::string& file) {
  const fs::path target = io::followLinks(file);
  std::error_code error;
  if (access(folderOf(target).c_str(), W_OK) != 0 || fs::is_directory(target, error)) {
    throw InputError(option + ": found " + quote(file) +
                     ", which cannot be written; accepted: a file in a folder that can be written");
  }
}

void checkFilesDiffer(const SimulateOptions& options, const simulation::SceneParams& params) {
  std::vector<std::pair<std::string, std::string>> others{
      {"the scene", options.scene}, {"--bag_in", options.bag_in}, {"cloud.file", findCloudFile(params.cloud.file)}};
  std::vector<std::string> problems;
  const std::pair<const char*, std::string> outputs[] = {
      {"--final", options.final_file}, {"--filtered", options.filtered_file}, {"--statistics", options.statistics_file},
      {"--bag_out", options.bag_out},  {"--wrenches", options.wrenches_file}, {"--mesh", options.mesh_file}};
  for (const auto& [option, output] : outputs) {
    if (output.empty()) continue;
    const auto refuse = [&, name = option, found = output](const std::string& why) {
      problems.push_back(std::string(name) + ": found " + quote(found) + ", which " + why + "; accepted: another file");
    };
    const std::string file = io::followLinks(output);
    for (const auto& [name, other] : others) {
      // It is written under the name of a partial file first.
      if (!other.empty() && (areSame(file, other) || areSame(file + ".partial", other)))
        refuse("would overwrite " + name + ", " + quote(other));
    }
    const fs::path frame = fs::path(options.frames_directory) / fs::path(file).filename();
    if (!options.frames_directory.empty() && isFrameName(frame.filename().string()) && areSame(frame, file))
      refuse("has the name of a frame in " + quote(options.frames_directory));
    others.emplace_back(option, file);
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace deformable_surface::node
