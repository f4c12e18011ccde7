// Reading of scene files. The only file that names yaml-cpp: its events are turned into Values directly, so that aliases, depth
// and repeated keys are refused before anything grows.
#include "deformable_surface/io/scene.h"

#include "deformable_surface/io/scene_old_names.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace deformable_surface::io {

namespace {

// Scenes nest five deep; deeper text is no scene, and a bound keeps recursion small.
constexpr std::size_t kMaxDepth = 32;

// Long lists of forces take some hundred kilobytes; what is much larger is another kind of file.
constexpr std::size_t kMaxBytes = std::size_t{16} << 20;

/// Where and why building stopped; yaml-cpp's own errors are another type.
struct Problem {
  YAML::Mark mark;
  std::string sentence;
};

class ValueBuilder : public YAML::EventHandler {
 public:
  Value takeRoot() { return std::move(root_); }

 private:
  struct Frame {
    Value value;
    YAML::Mark mark;
    bool has_key = false;
    std::string key;
  };

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add(mark, {}, nullptr); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Problem{mark, "found an alias (*name); accepted: the value written out (PyYAML: Dumper.ignore_aliases)"};
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& text) override {
    // yaml-cpp marks plain scalars by "?" and quoted ones by "!".
    checkTag(mark, tag);
    add(mark, tag == "!" ? Value(text) : parseScalar(text), &text);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override {
    checkTag(mark, tag);
    open(mark, Value::List{});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override {
    checkTag(mark, tag);
    open(mark, Value::Map{});
  }
  void OnMapEnd() override {
    std::vector<std::string> keys;
    for (const auto& member : *stack_.back().value.asMap()) keys.push_back(member.first);
    std::sort(keys.begin(), keys.end());
    const auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice != keys.end()) {
      throw Problem{stack_.back().mark, "found the key " + quote(*twice) + " twice in the map that begins here; accepted: once"};
    }
    close();
  }

  static void checkTag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    throw Problem{mark, "found the tag " + quote(tag) + "; accepted: values without tags"};
  }

  void open(const YAML::Mark& mark, Value value) {
    if (!stack_.empty() && stack_.back().value.isMap() && !stack_.back().has_key) refuseKey(mark);
    if (stack_.size() == kMaxDepth) {
      throw Problem{mark, "found more than " + std::to_string(kMaxDepth) + " levels of nesting; accepted: fewer"};
    }
    stack_.push_back({std::move(value), mark, false, ""});
  }

  void close() {
    Value value = std::move(stack_.back().value);
    const YAML::Mark mark = stack_.back().mark;
    stack_.pop_back();
    add(mark, std::move(value), nullptr);
  }

  // Puts a finished value where it belongs. text: what a scalar looks like, so that any scalar can be a key.
  void add(const YAML::Mark& mark, Value value, const std::string* text) {
    if (stack_.empty()) {
      root_ = std::move(value);
      return;
    }
    Frame& frame = stack_.back();
    if (Value::List* list = frame.value.asList()) {
      list->push_back(std::move(value));
    } else if (frame.has_key) {
      frame.value.asMap()->emplace_back(std::move(frame.key), std::move(value));
      frame.has_key = false;
    } else if (text) {
      frame.key = *text;
      frame.has_key = true;
    } else {
      refuseKey(mark);
    }
  }

  [[noreturn]] static void refuseKey(const YAML::Mark& mark) {
    throw Problem{mark, "found a key that is not a word; accepted: words as keys"};
  }

  Value root_;
  std::vector<Frame> stack_;
};

[[noreturn]] void refuse(const std::string& name, const YAML::Mark& mark, const std::string& sentence) {
  throw InputError(name + ", line " + std::to_string(mark.line + 1) + ", column " + std::to_string(mark.column + 1) + ": " +
                   sentence);
}

// One YAML value of any kind.
Value parseAny(const std::string& text, const std::string& name) {
  std::istringstream stream(text);
  try {
    YAML::Parser parser(stream);
    ValueBuilder builder;
    if (!parser.HandleNextDocument(builder)) return {};
    ValueBuilder rest;
    if (parser.HandleNextDocument(rest)) throw InputError(name + ": found several YAML documents; accepted: one");
    return builder.takeRoot();
  } catch (const Problem& problem) {
    refuse(name, problem.mark, problem.sentence);
  } catch (const YAML::Exception& error) {
    refuse(name, error.mark, "not YAML: " + error.msg);
  }
}

// "tools[0].friction", as messages name it, as "tools.0.friction".
std::string toDots(const std::string& path) {
  static const std::regex kItem("\\[([^\\[\\].]*)\\](?=[.\\[]|$)");
  return std::regex_replace(path, kItem, ".$1");
}

// Sections that are left out have their defaults; the shape of a tool has none.
void requireShapes(const Value& scene, std::vector<std::string>& problems) {
  const Value* const tools = scene.isMap() ? scene.find("tools") : nullptr;
  const Value::List* const list = tools ? tools->asList() : nullptr;
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    if (!(*list)[i].isMap()) continue;
    const Value* const shape = (*list)[i].find("shape");
    if (!shape || shape->isNull())
      problems.push_back("tools[" + std::to_string(i) +
                         "].shape: missing; accepted: one of sphere, box, cylinder, cone, plane, mesh");
  }
}

}  // namespace

Value parseYaml(const std::string& text, const std::string& name) {
  if (text.size() > kMaxBytes) {
    throw InputError(name + ": found more than " + std::to_string(kMaxBytes) +
                     " bytes; accepted: a scene file, which is smaller");
  }
  if (text.find('\0') != std::string::npos) throw InputError(name + ": found a zero byte; accepted: YAML text");
  Value root = parseAny(text, name);
  if (!root.isMap()) throw InputError(name + ": found " + root.describe() + "; accepted: a map from keys to values");
  return root;
}

Value loadYamlFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::vector<char> block(1 << 16);
  // One block more than is accepted is enough to refuse.
  while (file && text.size() <= kMaxBytes) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.eof() && text.size() <= kMaxBytes) throw InputError(path + ": cannot be read; accepted: a readable scene file");
  return parseYaml(text, path);
}

void setByPath(Value& root, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const auto refuseAssignment = [&](const std::string& sentence) {
    throw InputError("--set " + quote(assignment) + ": " + sentence);
  };
  if (equals == std::string::npos || equals == 0) refuseAssignment("accepted: KEY=VALUE");

  const std::string text = assignment.substr(equals + 1);
  Value value = text.empty() ? Value("") : parseAny(text, "--set " + quote(assignment));

  // Down the path, making maps where there is nothing yet.
  Value* place = &root;
  std::istringstream path(toDots(assignment.substr(0, equals)));
  std::string key;
  std::size_t depth = 0;
  while (std::getline(path, key, '.')) {
    if (key.empty() || ++depth > kMaxDepth)
      refuseAssignment("found an empty or endless path; accepted: keys with points between them");
    if (Value::List* list = place->asList()) {
      const Value number = parseNumber(key);
      const std::int64_t* item = number.asInteger();
      if (!item || *item < 0 || *item >= static_cast<std::int64_t>(list->size())) {
        refuseAssignment("found " + quote(key) + " as the place in a list of " + std::to_string(list->size()) +
                         "; accepted: " + (list->empty() ? "none" : "0 to " + std::to_string(list->size() - 1)));
      }
      place = &(*list)[static_cast<std::size_t>(*item)];
    } else if (place->isNull() && parseNumber(key).asInteger()) {
      refuseAssignment("found " + quote(key) + " as the place in a list that the scene does not have; accepted: a whole list");
    } else if (place->isMap() || place->isNull()) {
      Value* member = place->find(key);
      place = member ? member : &place->set(key, {});
    } else {
      refuseAssignment("found " + quote(key) + " below " + place->describe() + "; accepted: keys of a map or list");
    }
  }
  *place = std::move(value);
}

simulation::SceneParams readScene(const Value& value) {
  Value scene = value;
  simulation::SceneParams params;
  params.notices = renameOldKeys(scene);
  std::vector<std::string> problems = readParams(scene, params);
  requireShapes(scene, problems);
  if (!problems.empty()) throw InputError(std::move(problems));
  return params;
}

void checkForSimulate(const simulation::SceneParams& params, bool needs_cloud) {
  // What the decimal rounding of two doubles may leave of an exact multiple.
  constexpr double kMultipleTolerance = 1e-9;
  std::vector<std::string> problems;
  if (needs_cloud && params.cloud.file.empty() && params.cloud.shape == simulation::CloudParams::Shape::kNone) {
    problems.emplace_back("cloud: found neither a file nor a shape; accepted: cloud.file or cloud.shape");
  }
  const double steps = params.duration / params.integrator.time_step;
  if (!(std::round(steps) >= 1.0 && std::abs(steps - std::round(steps)) <= kMultipleTolerance * steps)) {
    problems.push_back("duration: found " + formatReal(params.duration) + "; accepted: a multiple of integrator.time_step, " +
                       formatReal(params.integrator.time_step) + " (s)");
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

std::string printScene(const simulation::SceneParams& params) { return toYaml(printParams(params)); }

std::string parametersPage() {
  return "# Parameters\n\n"
         "These are the keys of a scene file for `simulate`, and the private parameters of the node.\n\n"
         "- A dotted key is a key in a map. `[]` stands for the items of a list.\n"
         "- Unknown keys, wrong types and values out of range are errors. The message says what is accepted.\n"
         "- Numbers may be written as text.\n"
         "- [scenes/default.yaml](../scenes/default.yaml) is a scene with all keys at their defaults.\n\n"
         "This page is generated by `parameters_page`; a test compares the two.\n" +
         tabulateParams<simulation::SceneParams>();
}

std::string defaultScene() {
  simulation::SceneParams params;
  params.cloud.shape = simulation::CloudParams::Shape::kSheet;
  params.cloud.points = 1600;
  params.duration = 0.5;
  // Free fall, exact with velocity Verlet: g t^2 / 2, but for rounding.
  const double fallen = 0.5 * params.gravity.z() * params.duration * params.duration, rounding = 1e-5;
  params.expect = {{"min_z", fallen - rounding, fallen + rounding}, {"max_z", fallen - rounding, fallen + rounding}};
  return "# All keys of a scene with their defaults, to copy from. Four keys are not at their defaults, so that the scene runs:\n"
         "# cloud.shape, cloud.points, duration and expect. Nothing holds the surface, so it falls.\n"
         "# launch/deformable_surface.launch starts with this scene.\n"
         "# Printed by `parameters_page --scene`; a test compares the two.\n\n" +
         writeTemplate(params);
}

}  // namespace deformable_surface::io
