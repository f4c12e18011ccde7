#include "kept_surfaces.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/cloud_filters.h"
#include "deformable_surface/io/load_scene.h"
#include "deformable_surface/ros/convert/find_package.h"

#include <sys/stat.h>

#include <algorithm>
#include <utility>

namespace deformable_surface::node {
namespace {

using simulation::SceneParams;

// Of a plan that goes through clouds: the runs of one follow one another, and workers are a few runs apart.
constexpr std::size_t kMostKept = 4;
constexpr std::size_t kMostPoints = 1000000;  // of all of them, some hundred bytes each

// Everything that the cloud and its prepared surface depend on; empty if they cannot be shared.
std::string makeKey(const SceneParams& params) {
  if (!simulation::canShare(params)) return "";
  SceneParams kept = simulation::keepWhatPrepares(params);
  kept.cloud = params.cloud;
  kept.input.filter = params.input.filter;
  kept.input.max_points = params.input.max_points;
  std::string key = toYaml(printParams(kept)) + std::to_string(simulation::findCoarsest(params));
  if (params.cloud.file.empty()) return key;
  // A file that was written anew is another one.
  struct stat file;
  const std::string path = io::findPointFile(params.cloud.file, findPackage);
  if (stat(path.c_str(), &file) != 0) return "";
  for (const auto part : {static_cast<long>(file.st_dev), static_cast<long>(file.st_ino), static_cast<long>(file.st_size),
                          static_cast<long>(file.st_mtim.tv_sec), static_cast<long>(file.st_mtim.tv_nsec)})
    key += ' ' + std::to_string(part);
  return key;
}

}  // namespace

std::list<KeptSurface>::iterator KeptSurfaces::find(const std::string& key) {
  return std::find_if(kept_.begin(), kept_.end(), [&](const KeptSurface& kept) { return kept.key == key; });
}

void KeptSurfaces::make(const SceneParams& params) {
  KeptSurface made;
  made.key = makeKey(params);
  if (made.key.empty()) return;
  if (const auto found = find(made.key); found != kept_.end()) return kept_.splice(kept_.begin(), kept_, found);
  made.cloud = io::loadCloud(params, findPackage);
  io::FilterReport report = io::filterCloud(params.input.filter, made.cloud);
  if (!report.problem.empty()) throw InputError(report.problem);
  made.notices = std::move(report.notices);
  made.prepared =
      simulation::prepareSurface(params, made.cloud, simulation::findCoarsest(params), simulation::hasTarget(params.accuracy));
  kept_.push_front(std::move(made));
  std::size_t points = 0;
  for (auto kept = kept_.begin(); kept != kept_.end(); ++kept) {
    points += kept->cloud.positions.size();
    if (kept == kept_.begin() || (points <= kMostPoints && std::distance(kept_.begin(), kept) < static_cast<long>(kMostKept)))
      continue;
    kept_.erase(kept, kept_.end());
    break;
  }
}

std::optional<KeptSurface> KeptSurfaces::take(const SceneParams& params) {
  const std::string key = makeKey(params);
  const auto found = key.empty() ? kept_.end() : find(key);
  if (found == kept_.end()) return std::nullopt;
  std::optional<KeptSurface> taken(std::move(*found));
  kept_.erase(found);
  return taken;
}

}  // namespace deformable_surface::node
