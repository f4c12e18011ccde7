#include "reconfigure.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/scene.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace deformable_surface::node {
namespace {

using dynamic_reconfigure::Config;
using simulation::SceneParams;

struct Entry {
  std::string name;               // the key, with .x, .y or .z
  std::vector<std::string> path;  // of the value in the tree of a scene
  int component = -1;             // of a vector
  bool is_flag = false;
  Range range;
  std::string meaning;
};

// Finds the run-time keys among all fields of a scene.
class Finder : public Fields {
 public:
  std::vector<Entry> entries;

 private:
  void add(const About& about, bool is_flag, int size) {
    std::vector<std::string> path = path_;
    path.push_back(about.name);
    std::string key;
    for (const std::string& part : path) key += (key.empty() ? "" : ".") + part;
    const std::vector<std::string>& keys = simulation::runTimeKeys();
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) return;
    const std::string unit = about.unit;
    const std::string meaning = about.meaning + (unit.empty() ? "" : " (" + unit + ")");
    if (size == 0) entries.push_back({key, path, -1, is_flag, about.range, meaning});
    for (int c = 0; c < size; ++c) entries.push_back({key + "." + "xyz"[c], path, c, is_flag, about.range, meaning});
  }

  void onNumber(const About& about, double&) override { add(about, false, 0); }
  void onNumberOrAuto(const About&, OrAuto<double>&) override {}
  void onInteger(const About&, Index&) override {}
  void onFlag(const About& about, bool&) override { add(about, true, 0); }
  void onFlagOrAuto(const About&, OrAuto<bool>&) override {}
  void onText(const About&, std::string&) override {}
  void onVector(const About& about, double*, int size) override { add(about, false, size); }
  void onRows(const About&, Points&) override {}
  void onChoice(const About&, int&, const std::vector<std::string>&, const Value&) override {}
  void onBounds(const About&, std::vector<NamedBounds>&, const std::vector<std::string>&) override {}
  bool onBegin(const About& about, bool) override {
    path_.push_back(about.name);
    return true;
  }
  void onEnd() override { path_.pop_back(); }
  std::size_t onBeginList(const About&, std::size_t) override { return 0; }
  bool onBeginItem(std::size_t) override { return false; }
  void onEndList() override {}
  void onBroken(const std::string&, const std::string&) override {}

  std::vector<std::string> path_;
};

const std::vector<Entry>& listEntries() {
  static const std::vector<Entry> entries = [] {
    Finder finder;
    SceneParams params;
    visit(finder, params);
    return std::move(finder.entries);
  }();
  return entries;
}

// The place of an entry's value in the tree of a scene.
Value& findValue(const Entry& entry, Value& tree) {
  Value* value = &tree;
  for (const std::string& part : entry.path) value = value->find(part);
  return entry.component < 0 ? *value : (*value->asList())[entry.component];
}

double toReal(const Value& value) { return value.asInteger() ? static_cast<double>(*value.asInteger()) : *value.asReal(); }

void add(const std::string& name, double value, Config& config) {
  config.doubles.emplace_back();
  config.doubles.back().name = name;
  config.doubles.back().value = value;
}

void add(const std::string& name, bool value, Config& config) {
  config.bools.emplace_back();
  config.bools.back().name = name;
  config.bools.back().value = value;
}

// The group that clients expect.
void addGroup(Config& config) {
  config.groups.resize(1);
  config.groups[0].name = "Default";
  config.groups[0].state = true;
}

template <class Parameter>
void take(const Parameter& given, bool is_flag, Value& tree) {
  const std::vector<Entry>& entries = listEntries();
  const auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.name == given.name; });
  if (entry == entries.end() || entry->is_flag != is_flag) {
    std::string names;
    for (const Entry& e : entries) names += (names.empty() ? "" : ", ") + e.name;
    throw InputError("found a parameter " + quote(given.name.substr(0, 64)) + (is_flag ? " as a flag" : " as a number") +
                     "; accepted while the node runs: " + names);
  }
  findValue(*entry, tree) = is_flag ? Value(given.value != 0) : Value(static_cast<double>(given.value));
}

}  // namespace

dynamic_reconfigure::ConfigDescription describeRunTimeParams() {
  dynamic_reconfigure::ConfigDescription description;
  description.groups.resize(1);
  description.groups[0].name = "Default";
  for (const Entry& entry : listEntries()) {
    dynamic_reconfigure::ParamDescription param;
    param.name = entry.name;
    param.type = entry.is_flag ? "bool" : "double";
    param.description = entry.meaning;
    description.groups[0].parameters.push_back(param);
    if (entry.is_flag) {
      add(entry.name, false, description.min);
      add(entry.name, true, description.max);
    } else {
      add(entry.name, entry.range.low, description.min);
      add(entry.name, entry.range.high, description.max);
    }
  }
  addGroup(description.min);
  addGroup(description.max);
  description.dflt = printRunTimeParams(SceneParams());
  return description;
}

Config printRunTimeParams(const SceneParams& params) {
  Config config;
  Value tree = printParams(params);
  for (const Entry& entry : listEntries()) {
    const Value& value = findValue(entry, tree);
    if (entry.is_flag) {
      add(entry.name, *value.asBool(), config);
    } else {
      add(entry.name, toReal(value), config);
    }
  }
  addGroup(config);
  return config;
}

SceneParams readRunTimeParams(const Config& config, const SceneParams& params) {
  Value tree = printParams(params);
  for (const auto& given : config.bools) take(given, true, tree);
  for (const auto& given : config.doubles) take(given, false, tree);
  for (const auto& given : config.ints) take(given, false, tree);
  if (!config.strs.empty())
    throw InputError("found the text parameter " + quote(config.strs[0].name.substr(0, 64)) + "; accepted: numbers and flags");
  // Values that were not asked for are not converted to text and back.
  return simulation::withRunTimeValues(params, io::readScene(tree));
}

Reconfigure::Reconfigure(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, WarningLog& warnings)
    : node_(std::move(node)), inbox_(inbox), stepper_(stepper), warnings_(warnings) {
  descriptions_ = node_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
  updates_ = node_.advertise<Config>("parameter_updates", 1, true);
  descriptions_.publish(describeRunTimeParams());
  publish();
  stored_ = listValues();
  using Request = dynamic_reconfigure::ReconfigureRequest;
  using Response = dynamic_reconfigure::ReconfigureResponse;
  server_ = node_.advertiseService<Request, Response>(
      "set_parameters",
      boost::function<bool(Request&, Response&)>([this](Request& q, Response& r) { return set(q.config, r.config); }));
}

void Reconfigure::publish() {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_ = printRunTimeParams(stepper_.params());
  updates_.publish(last_);
}

std::map<std::string, double> Reconfigure::listValues() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::map<std::string, double> values;
  for (const auto& flag : last_.bools) values[flag.name] = flag.value;
  for (const auto& number : last_.doubles) values[number.name] = number.value;
  return values;
}

// Each value costs a call of the master.
void Reconfigure::store() {
  const std::map<std::string, double> now = listValues();
  if (now == stored_) return;
  for (const Entry& entry : listEntries()) {
    if (entry.component > 0) continue;  // set with the first
    std::string key;
    for (const std::string& part : entry.path) key += (key.empty() ? "" : "/") + part;
    std::vector<std::string> names = {entry.name};
    if (entry.component == 0)
      for (const char axis : {'y', 'z'}) names.push_back(entry.name.substr(0, entry.name.size() - 1) + axis);
    if (std::all_of(names.begin(), names.end(), [&](const std::string& name) { return now.at(name) == stored_.at(name); }))
      continue;
    if (entry.component == 0) {
      node_.setParam(key, std::vector<double>{now.at(names[0]), now.at(names[1]), now.at(names[2])});
    } else if (entry.is_flag) {
      node_.setParam(key, now.at(entry.name) != 0.0);
    } else {
      node_.setParam(key, now.at(entry.name));
    }
  }
  stored_ = now;
  if (on_store_) on_store_();
}

bool Reconfigure::set(const Config& wanted, Config& now) {
  std::string problem;
  const auto work = [&] {
    try {
      stepper_.setParams(readRunTimeParams(wanted, stepper_.params()));
    } catch (const std::exception& error) {
      problem = toOneLine(error.what());
    }
    now = printRunTimeParams(stepper_.params());
    // Even without a change: clients show what they asked for until they get an answer.
    publish();
  };
  try {
    inbox_.perform(work);
  } catch (const std::exception&) {
    return false;
  }
  if (!problem.empty()) {
    warnings_.report(Warning::kCommandRefused, "parameters refused, the previous values stay: " + problem);
    return true;
  }
  store();
  return true;
}

}  // namespace deformable_surface::node
