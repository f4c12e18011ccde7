#include "deformable_surface/io/scene_old_names.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/simulation/scene_params.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::io {
namespace {

// The version that does not know the names below.
constexpr char kLastVersion[] = "0.3";

struct Renamed {
  const char *old_name, *name;
};

constexpr Renamed kKeys[] = {{"activity.quiet_time", "sleep.quiet_time"},
                             {"activity.sleep", "sleep.mode"},
                             {"activity.tolerance", "sleep.tolerance"},
                             {"input.keep_parts", "input.largest_parts"},
                             {"input.track_distance", "input.tracking_distance"},
                             {"input.track_gain", "input.tracking_gain"},
                             {"input.unheld", "input.unconstrained_parts"},
                             {"neighbors.geodesicness", "neighbors.geodesic_exponent"},
                             {"oriented_particles.fit", "oriented_particles.grow_surface"},
                             {"oriented_particles.hold_below", "oriented_particles.freeze_below"},
                             {"oriented_particles.spin", "oriented_particles.axis_alignment_rate"}};

constexpr Renamed kQuantities[] = {
    {"born", "added"},    {"error_softening", "error_stiffness"}, {"gone", "removed"},
    {"springs", "links"}, {"track_points", "tracked_points"},     {"track_residual", "tracking_residual"}};

struct Path {
  std::string section, key;
};

Path split(const std::string& path) {
  const std::size_t point = path.find('.');
  return {path.substr(0, point), path.substr(point + 1)};
}

const Value* find(const Value& scene, const Path& path) {
  const Value* section = scene.find(path.section);
  return section ? section->find(path.key) : nullptr;
}

void erase(const std::string& key, Value::Map& map) {
  map.erase(std::remove_if(map.begin(), map.end(), [&](const auto& member) { return member.first == key; }), map.end());
}

// A section of which nothing is left goes, too.
void erase(const Path& path, Value& scene) {
  Value::Map& section = *scene.find(path.section)->asMap();
  erase(path.key, section);
  if (section.empty()) erase(path.section, *scene.asMap());
}

bool isDefault(const Path& path, const Value& value) {
  static const Value defaults = printParams(simulation::SceneParams());
  const Value* by_default = find(defaults, path);
  return by_default && toYaml(Value::Map{{path.key, *by_default}}) == toYaml(Value::Map{{path.key, value}});
}

}  // namespace

std::string describeNewName(const std::string& old_name, const std::string& name) {
  return old_name + " is now called " + name + "; the old name goes with version " + kLastVersion;
}

std::vector<std::string> renameOldKeys(Value& scene) {
  std::vector<std::string> notices, problems;
  const auto rename = [&](const std::string& old_name, const std::string& name) {
    const Path before = split(old_name), now = split(name);
    const Value* old_value = find(scene, before);
    const Value* section = scene.find(now.section);
    if (!old_value || (section && !section->isMap() && !section->isNull())) return;  // the reader refuses what is no section
    const Value* value = find(scene, now);
    if (value && !isDefault(now, *value)) {
      problems.push_back(old_name + ": found beside " + name + ", which is its new name; accepted: the new one alone");
      return;
    }
    Value moved = *old_value;
    erase(before, scene);
    if (!scene.find(now.section)) scene.set(now.section, Value::Map{});
    scene.find(now.section)->set(now.key, std::move(moved));
    notices.push_back(describeNewName(old_name, name));
  };
  for (const Renamed& key : kKeys) rename(key.old_name, key.name);
  for (const Renamed& quantity : kQuantities)
    rename(std::string("expect.") + quantity.old_name, std::string("expect.") + quantity.name);
  if (!problems.empty()) throw InputError(std::move(problems));
  return notices;
}

std::string findNewQuantity(const std::string& name) {
  for (const Renamed& quantity : kQuantities)
    if (name == quantity.old_name) return quantity.name;
  return name;
}

}  // namespace deformable_surface::io
