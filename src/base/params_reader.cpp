// The visitor that reads parameter structs and collects every problem. The other two visitors trust the values they see.
#include "deformable_surface/base/params.h"

#include "params_text.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace deformable_surface {

namespace {

std::string withUnit(const std::string& accepted, const char* unit) { return *unit ? accepted + " (" + unit + ")" : accepted; }

std::string trimQuotes(const std::string& quoted) { return quoted.substr(1, quoted.size() - 2); }

// The number in a value, even if it was written as text; false if there is none.
bool toNumber(const Value& value, double& number) {
  if (const std::int64_t* integer = value.asInteger()) {
    number = static_cast<double>(*integer);
    return true;
  }
  if (const double* real = value.asReal()) {
    number = *real;
    return true;
  }
  if (const std::string* text = value.asText()) {
    const Value parsed = parseNumber(*text);
    return !parsed.isNull() && toNumber(parsed, number);
  }
  return false;
}

// Two steps per edit, so that a key in another section can lose to an equally near one in the same section.
constexpr int kEditCost = 2;

// The key ("forces[].id") nearest to a name in a section, among all keys: by the last word, then by the section. Empty if
// more than half of the word would have to change, in another section a third: the nearest would only mislead.
std::string nearestKey(const std::string& section, const std::string& name, const std::vector<std::string>& all_keys) {
  std::string nearest;
  const int size = static_cast<int>(name.size());
  int least = std::numeric_limits<int>::max();
  for (const std::string& key : all_keys) {
    const std::size_t dot = key.rfind('.');
    const bool same_section = (dot == std::string::npos ? "" : key.substr(0, dot)) == section;
    const int edits = editDistance(name, dot == std::string::npos ? key : key.substr(dot + 1));
    if (edits > size / (same_section ? 2 : 3)) continue;  // any short word resembles some key elsewhere
    const int cost = kEditCost * edits + (same_section ? 0 : 1);
    if (cost < least) {
      least = cost;
      nearest = key;
    }
  }
  return nearest;
}

class Reader : public Fields {
 public:
  Reader(const Value& root, const std::vector<std::string>& all_keys, std::vector<std::string>& problems)
      : all_keys_(all_keys), problems_(problems) {
    stack_.push_back({&root, "", "", {}, false});
  }

  /// The unknown keys of the section on top.
  void finishSection() {
    const Frame& frame = stack_.back();
    for (const auto& [key, value] : *frame.map->asMap()) {
      if (frame.known.count(key)) continue;
      const std::string shown = trimQuotes(quote(key));
      const std::string nearest = nearestKey(frame.section, shown, all_keys_);
      const std::vector<std::string> known(frame.known.begin(), frame.known.end());
      problems_.push_back(joinPath(frame.path, shown) + ": unknown key; " +
                          (nearest.empty() ? "accepted: " + join(known, ", ") : "the nearest known one is " + nearest));
    }
    stack_.pop_back();
  }

 private:
  struct Frame {
    const Value* map;             // or the list whose items follow
    std::string path;             // "forces[0]", for sentences
    std::string section;          // "forces[]", as keys are listed
    std::set<std::string> known;  // names the visit function asked for
    bool failed;                  // a field could not be read: rules among fields would complain about its default
  };

  // The value of a field, or nullptr if it was not given. accepted: makes the words for what may be given, which are needed
  // for problems only, and take most of the time where there are none.
  template <class Words>
  const Value* get(const About& about, const Words& accepted) {
    Frame& frame = stack_.back();
    frame.known.insert(about.name);
    const Value* value = frame.map->find(about.name);
    if (!value && about.required) addProblem(about.name, "missing; accepted: " + std::string(accepted()));
    return value;
  }

  // Of the whole, which has no name, the sentence alone.
  void tell(const std::string& name, const std::string& sentence) {
    const std::string path = joinPath(stack_.back().path, name);
    problems_.push_back(path.empty() ? sentence : path + ": " + sentence);
  }

  void addProblem(const std::string& name, const std::string& sentence) {
    tell(name, sentence);
    stack_.back().failed = true;
  }

  void refuse(const About& about, const Value& found, const std::string& accepted) {
    addProblem(about.name, "found " + found.describe() + "; accepted: " + accepted);
  }

  void onNumber(const About& about, double& value) override {
    const auto accepted = [&] { return withUnit(about.range.describe(), about.unit); };
    const Value* given = get(about, accepted);
    double number = 0.0;
    if (!given) return;
    if (toNumber(*given, number) && about.range.contains(number)) {
      value = number;
    } else {
      refuse(about, *given, accepted());
    }
  }

  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    const auto accepted = [&] { return "auto, or " + withUnit(about.range.describe(), about.unit); };
    const Value* given = get(about, accepted);
    double number = 0.0;
    if (!given) return;
    if (given->asText() && *given->asText() == "auto") {
      value = {};
    } else if (toNumber(*given, number) && about.range.contains(number)) {
      value = number;
    } else {
      refuse(about, *given, accepted());
    }
  }

  void onInteger(const About& about, Index& value) override {
    const auto accepted = [&] { return "an integer, " + withUnit(about.range.describe(), about.unit); };
    const Value* given = get(about, accepted);
    double number = 0.0;
    if (!given) return;
    if (toNumber(*given, number) && about.range.contains(number) && number == std::floor(number)) {
      value = static_cast<Index>(number);
    } else {
      refuse(about, *given, accepted());
    }
  }

  void onFlag(const About& about, bool& value) override {
    const auto accepted = [] { return "true or false"; };
    const Value* given = get(about, accepted);
    if (!given) return;
    if (given->asBool()) {
      value = *given->asBool();
    } else {
      refuse(about, *given, accepted());
    }
  }

  void onFlagOrAuto(const About& about, OrAuto<bool>& value) override {
    const auto accepted = [] { return "auto, true or false"; };
    const Value* given = get(about, accepted);
    if (!given) return;
    if (given->asText() && *given->asText() == "auto") {
      value = {};
    } else if (given->asBool()) {
      value = *given->asBool();
    } else {
      refuse(about, *given, accepted());
    }
  }

  void onText(const About& about, std::string& value) override {
    const Value* given = get(about, [] { return "text"; });
    if (!given) return;
    if (given->asText()) {
      value = *given->asText();
    } else {
      refuse(about, *given, "text (in quotes if it looks like something else)");
    }
  }

  void onVector(const About& about, double* value, int size) override {
    if (const Value* given = get(about, [&] { return describeRow(about, size); }))
      readRow(about, about.name, *given, value, size);
  }

  void onRows(const About& about, Points& value) override {
    const auto accepted = [&] { return "a list of lists, each " + describeRow(about, 3); };
    const Value* given = get(about, accepted);
    if (!given) return;
    const Value::List* list = given->asList();
    if (!list) return refuse(about, *given, accepted());
    value.assign(list->size(), Vec3::Zero());
    for (std::size_t i = 0; i < list->size(); ++i)
      readRow(about, about.name + "[" + std::to_string(i) + "]", (*list)[i], value[i].data(), 3);
  }

  static std::string describeRow(const About& about, int size) {
    return "a list of " + std::to_string(size) + " numbers, each " + withUnit(about.range.describe(), about.unit);
  }

  void readRow(const About& about, const std::string& name, const Value& given, double* value, int size) {
    const Value::List* list = given.asList();
    if (!list || static_cast<int>(list->size()) != size)
      return addProblem(name, "found " + given.describe() + "; accepted: " + describeRow(about, size));
    for (int i = 0; i < size; ++i) {
      double number = 0.0;
      if (toNumber((*list)[i], number) && about.range.contains(number)) {
        value[i] = number;
      } else {
        addProblem(name + "[" + std::to_string(i) + "]",
                   "found " + (*list)[i].describe() + "; accepted: " + withUnit(about.range.describe(), about.unit));
      }
    }
  }

  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted, const Value&) override {
    const auto names = [&] { return join(accepted, ", "); };
    const Value* given = get(about, names);
    if (!given) return;
    const std::string* text = given->asText();
    const auto found = text ? std::find(accepted.begin(), accepted.end(), *text) : accepted.end();
    if (found == accepted.end()) return refuse(about, *given, names());
    chosen = static_cast<int>(found - accepted.begin());
  }

  void onBounds(const About& about, std::vector<NamedBounds>& value, const std::vector<std::string>& known) override {
    const auto accepted = [] { return "a map from quantities to [min, max]"; };
    const Value* given = get(about, accepted);
    if (!given) return;
    value.clear();
    if (given->isNull()) return;
    if (!given->isMap()) return refuse(about, *given, accepted());
    for (const auto& [name, item] : *given->asMap()) {
      const std::string shown = trimQuotes(quote(name)), key = about.name + "." + shown;
      if (!std::count(known.begin(), known.end(), name)) {
        addProblem(key, "unknown quantity; the nearest known one is " + nearestWord(shown, known));
        continue;
      }
      // Infinite bounds are one-sided ones.
      NamedBounds named{name, 0.0, 0.0};
      const Value::List* pair = item.asList();
      if (pair && pair->size() == 2 && toNumber((*pair)[0], named.min) && toNumber((*pair)[1], named.max) &&
          named.min <= named.max) {
        value.push_back(named);
      } else {
        addProblem(key, "found " + (pair ? toYaml(item).substr(0, toYaml(item).find('\n')) : item.describe()) +
                            "; accepted: [min, max], two numbers in this order");
      }
    }
  }

  bool onBegin(const About& about, bool) override {
    const Value* given = get(about, [] { return "a map"; });
    if (!given || given->isNull()) return false;
    if (!given->isMap()) {
      refuse(about, *given, "a map");
      return false;
    }
    const Frame& frame = stack_.back();
    stack_.push_back({given, joinPath(frame.path, about.name), joinPath(frame.section, about.name), {}, false});
    return true;
  }

  void onEnd() override { finishSection(); }

  std::size_t onBeginList(const About& about, std::size_t size) override {
    static const Value kEmptyList{Value::List{}};
    const Value* given = get(about, [] { return "a list of maps"; });
    std::size_t new_size = size;
    const Value* list = nullptr;  // nothing to read: the items stay
    if (given && given->isNull()) {
      new_size = 0;
    } else if (given && given->asList()) {
      list = given;
      new_size = given->asList()->size();
    } else if (given) {
      refuse(about, *given, "a list of maps");
    }
    const Frame& frame = stack_.back();
    stack_.push_back(
        {list ? list : &kEmptyList, joinPath(frame.path, about.name), joinPath(frame.section, about.name), {}, false});
    return new_size;
  }

  bool onBeginItem(std::size_t i) override {
    const Frame& frame = stack_.back();
    const Value::List& list = *frame.map->asList();
    if (i >= list.size()) return false;
    const std::string path = frame.path + "[" + std::to_string(i) + "]";
    if (!list[i].isMap()) {
      problems_.push_back(path + ": found " + list[i].describe() + "; accepted: a map");
      return false;
    }
    stack_.push_back({&list[i], path, frame.section + "[]", {}, false});
    return true;
  }

  void onEndList() override { stack_.pop_back(); }

  void onBroken(const std::string& name, const std::string& sentence) override {
    if (!stack_.back().failed) tell(name, sentence);
  }

  const std::vector<std::string>& all_keys_;
  std::vector<std::string>& problems_;
  std::vector<Frame> stack_;
};

}  // namespace

void internal::readFields(const Value& value, const std::vector<std::string>& all_keys, const Visit& visit_params,
                          std::vector<std::string>& problems) {
  static const Value kEmptyMap{Value::Map{}};
  if (!value.isMap() && !value.isNull()) {
    problems.push_back("found " + value.describe() + "; accepted: a map from keys to values");
    return;
  }
  Reader reader(value.isNull() ? kEmptyMap : value, all_keys, problems);
  visit_params(reader);
  reader.finishSection();
}

}  // namespace deformable_surface
