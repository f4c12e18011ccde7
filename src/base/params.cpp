// The visitors of parameter structs: a reader that collects every problem, a printer, and the writer of the page of parameters.
#include "deformable_surface/base/params.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace deformable_surface {

namespace {

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : separator) + word;
  return all;
}

std::string joinPath(const std::string& path, const std::string& name) {
  if (name.empty()) return path;
  return path.empty() ? name : path + "." + name;
}

// A number for a sentence: "1e9" instead of "1.0e+09".
std::string toShortText(double value) {
  std::string text = formatReal(value);
  const std::size_t point = text.find(".0");
  if (point != std::string::npos && (point + 2 == text.size() || text[point + 2] == 'e')) text.erase(point, 2);
  std::size_t digit = text.find('e');
  if (digit == std::string::npos) return text;
  ++digit;
  if (text[digit] == '+') {
    text.erase(digit, 1);
  } else {
    ++digit;
  }
  while (text[digit] == '0' && digit + 1 < text.size()) text.erase(digit, 1);
  return text;
}

std::string withUnit(const std::string& accepted, const char* unit) { return *unit ? accepted + " (" + unit + ")" : accepted; }

// The number in a value, also if it was written as text; false if there is none.
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

// Of all keys ("forces[].id"), the one that is nearest to a name in a section: by the last word, then by the section.
std::string nearestKey(const std::string& section, const std::string& name, const std::vector<std::string>& all_keys) {
  std::string nearest;
  int least = std::numeric_limits<int>::max();
  for (const std::string& key : all_keys) {
    const std::size_t dot = key.rfind('.');
    const bool same_section = (dot == std::string::npos ? "" : key.substr(0, dot)) == section;
    const int cost =
        kEditCost * editDistance(name, dot == std::string::npos ? key : key.substr(dot + 1)) + (same_section ? 0 : 1);
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
      std::string shown = quote(key);
      shown = shown.substr(1, shown.size() - 2);
      problems_.push_back(joinPath(frame.path, shown) + ": unknown key; the nearest known one is " +
                          nearestKey(frame.section, shown, all_keys_));
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

  // The value of a field, or nullptr if it was not given.
  const Value* get(const About& about, const std::string& accepted) {
    Frame& frame = stack_.back();
    frame.known.insert(about.name);
    const Value* value = frame.map->find(about.name);
    if (!value && about.required) addProblem(about.name, "missing; accepted: " + accepted);
    return value;
  }

  void addProblem(const std::string& name, const std::string& sentence) {
    problems_.push_back(joinPath(stack_.back().path, name) + ": " + sentence);
    stack_.back().failed = true;
  }

  void refuse(const About& about, const Value& found, const std::string& accepted) {
    addProblem(about.name, "found " + found.describe() + "; accepted: " + accepted);
  }

  void onNumber(const About& about, double& value) override {
    const std::string accepted = withUnit(about.range.describe(), about.unit);
    const Value* given = get(about, accepted);
    double number = 0.0;
    if (!given) return;
    if (toNumber(*given, number) && about.range.contains(number)) {
      value = number;
    } else {
      refuse(about, *given, accepted);
    }
  }

  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    const std::string accepted = "auto, or " + withUnit(about.range.describe(), about.unit);
    const Value* given = get(about, accepted);
    double number = 0.0;
    if (!given) return;
    if (given->asText() && *given->asText() == "auto") {
      value = {};
    } else if (toNumber(*given, number) && about.range.contains(number)) {
      value = number;
    } else {
      refuse(about, *given, accepted);
    }
  }

  void onInteger(const About& about, Index& value) override {
    const std::string accepted = "an integer, " + withUnit(about.range.describe(), about.unit);
    const Value* given = get(about, accepted);
    double number = 0.0;
    if (!given) return;
    if (toNumber(*given, number) && about.range.contains(number) && number == std::floor(number)) {
      value = static_cast<Index>(number);
    } else {
      refuse(about, *given, accepted);
    }
  }

  void onFlag(const About& about, bool& value) override {
    const Value* given = get(about, "true or false");
    if (!given) return;
    if (given->asBool()) {
      value = *given->asBool();
    } else {
      refuse(about, *given, "true or false");
    }
  }

  void onText(const About& about, std::string& value) override {
    const Value* given = get(about, "text");
    if (!given) return;
    if (given->asText()) {
      value = *given->asText();
    } else {
      refuse(about, *given, "text (in quotes if it looks like something else)");
    }
  }

  void onVector(const About& about, double* value, int size) override {
    const std::string accepted =
        "a list of " + std::to_string(size) + " numbers, each " + withUnit(about.range.describe(), about.unit);
    const Value* given = get(about, accepted);
    if (!given) return;
    const Value::List* list = given->asList();
    if (!list || static_cast<int>(list->size()) != size) return refuse(about, *given, accepted);
    for (int i = 0; i < size; ++i) {
      double number = 0.0;
      if (toNumber((*list)[i], number) && about.range.contains(number)) {
        value[i] = number;
      } else {
        addProblem(about.name + "[" + std::to_string(i) + "]",
                   "found " + (*list)[i].describe() + "; accepted: " + withUnit(about.range.describe(), about.unit));
      }
    }
  }

  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted,
                const std::vector<std::string>& planned) override {
    const std::string names = join(accepted, ", ");
    const Value* given = get(about, names);
    if (!given) return;
    const std::string* text = given->asText();
    if (text && std::count(planned.begin(), planned.end(), *text)) {
      return addProblem(about.name, "found " + given->describe() + ", which is not built yet; accepted: " + names);
    }
    const auto found = text ? std::find(accepted.begin(), accepted.end(), *text) : accepted.end();
    if (found == accepted.end()) return refuse(about, *given, names);
    chosen = static_cast<int>(found - accepted.begin());
  }

  void onBounds(const About& about, std::vector<NamedBounds>& value, const std::vector<std::string>& known) override {
    const std::string accepted = "a map from quantities to [min, max]";
    const Value* given = get(about, accepted);
    if (!given) return;
    value.clear();
    if (given->isNull()) return;
    if (!given->isMap()) return refuse(about, *given, accepted);
    for (const auto& [name, item] : *given->asMap()) {
      const std::string key = about.name + "." + name;
      if (!std::count(known.begin(), known.end(), name)) {
        addProblem(key, "unknown quantity; the nearest known one is " + nearestWord(name, known));
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
    const Value* given = get(about, "a map");
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
    const Value* given = get(about, "a list of maps");
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

  void onNotBuilt(const About& about) override {
    const Value* given = get(about, "nothing");
    if (!given || given->isNull()) return;
    if ((given->isMap() && given->asMap()->empty()) || (given->asList() && given->asList()->empty())) return;
    addProblem(about.name,
               "found " + given->describe() + "; this part is not built yet; accepted: nothing, or leave the key out");
  }

  void onBroken(const std::string& name, const std::string& sentence) override {
    if (!stack_.back().failed) problems_.push_back(joinPath(stack_.back().path, name) + ": " + sentence);
  }

  const std::vector<std::string>& all_keys_;
  std::vector<std::string>& problems_;
  std::vector<Frame> stack_;
};

class Printer : public Fields {
 public:
  Value takeRoot() { return std::move(stack_.front().value); }

 private:
  struct Frame {
    std::string name;
    Value value;
    bool is_item;
  };

  void put(const About& about, Value value) { stack_.back().value.set(about.name, std::move(value)); }

  void onNumber(const About& about, double& value) override { put(about, value); }
  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    put(about, value.is_auto ? Value("auto") : Value(value.value));
  }
  void onInteger(const About& about, Index& value) override { put(about, value); }
  void onFlag(const About& about, bool& value) override { put(about, value); }
  void onText(const About& about, std::string& value) override { put(about, value); }
  void onVector(const About& about, double* value, int size) override { put(about, Value::List(value, value + size)); }
  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted,
                const std::vector<std::string>&) override {
    put(about, chosen < 0 ? "a value without a name" : accepted[chosen]);
  }
  void onBounds(const About& about, std::vector<NamedBounds>& value, const std::vector<std::string>&) override {
    Value::Map map;
    for (const NamedBounds& named : value) map.emplace_back(named.name, Value::List{named.min, named.max});
    put(about, std::move(map));
  }
  bool onBegin(const About& about, bool present) override {
    if (present) stack_.push_back({about.name, Value::Map{}, false});
    return present;
  }
  void onEnd() override {
    Frame frame = std::move(stack_.back());
    stack_.pop_back();
    if (frame.is_item) {
      stack_.back().value.asList()->push_back(std::move(frame.value));
    } else {
      stack_.back().value.set(frame.name, std::move(frame.value));
    }
  }
  std::size_t onBeginList(const About& about, std::size_t size) override {
    stack_.push_back({about.name, Value::List{}, false});
    return size;
  }
  bool onBeginItem(std::size_t) override {
    stack_.push_back({"", Value::Map{}, true});
    return true;
  }
  void onEndList() override { onEnd(); }
  void onNotBuilt(const About&) override {}
  void onBroken(const std::string&, const std::string&) override {}

  std::vector<Frame> stack_{{"", Value::Map{}, false}};
};

// One row per key; rows of a section at the top stand together, whatever order they were visited in.
class Page : public Fields {
 public:
  std::vector<std::string> keys;

  std::string text() const {
    std::string all;
    for (const Section& section : sections_) {
      if (section.rows.empty()) continue;
      all += "\n## " + section.title + "\n\n" + section.meaning +
             "\n\n| key | default | unit | accepted | meaning |\n|---|---|---|---|---|\n";
      all += section.rows;
    }
    return all;
  }

 private:
  struct Section {
    std::string title, meaning, rows;
  };

  void addRow(const About& about, const std::string& standard, const std::string& accepted) {
    const std::string key = joinPath(path_.back(), about.name);
    keys.push_back(key);
    sections_[path_.size() == 1 ? 0 : sections_.size() - 1].rows +=
        "| `" + key + "` | " + (about.required ? "must be given" : "`" + standard + "`") + " | " + about.unit + " | " + accepted +
        " | " + about.meaning + " |\n";
  }

  void onNumber(const About& about, double& value) override { addRow(about, toShortText(value), about.range.describe()); }
  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    addRow(about, value.is_auto ? "auto" : toShortText(value.value), "`auto`, or " + about.range.describe());
  }
  void onInteger(const About& about, Index& value) override {
    addRow(about, std::to_string(value), "an integer, " + about.range.describe());
  }
  void onFlag(const About& about, bool& value) override { addRow(about, value ? "true" : "false", "`true`, `false`"); }
  void onText(const About& about, std::string& value) override { addRow(about, "\"" + value + "\"", "text"); }
  void onVector(const About& about, double* value, int size) override {
    std::vector<std::string> numbers;
    for (int i = 0; i < size; ++i) numbers.push_back(toShortText(value[i]));
    addRow(about, "[" + join(numbers, ", ") + "]", std::to_string(size) + " numbers, each " + about.range.describe());
  }
  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted,
                const std::vector<std::string>& planned) override {
    std::string names = "`" + join(accepted, "`, `") + "`";
    if (!planned.empty()) names += " (not built yet: `" + join(planned, "`, `") + "`)";
    addRow(about, accepted[chosen], names);
  }
  void onBounds(const About& about, std::vector<NamedBounds>&, const std::vector<std::string>& known) override {
    addRow(about, "{}",
           "a map from quantities to [min, max], `.inf` and `-.inf` for one side; the quantities: `" + join(known, "`, `") + "`");
  }
  bool onBegin(const About& about, bool) override {
    enter(about, joinPath(path_.back(), about.name));
    return true;
  }
  void onEnd() override { path_.pop_back(); }
  std::size_t onBeginList(const About& about, std::size_t) override {
    enter(about, joinPath(path_.back(), about.name) + "[]");
    return 1;
  }
  bool onBeginItem(std::size_t) override {
    path_.push_back(path_.back());
    return true;
  }
  void onEndList() override { onEnd(); }
  void onNotBuilt(const About& about) override { addRow(about, "empty", "nothing: not built yet"); }
  void onBroken(const std::string&, const std::string&) override {}

  void enter(const About& about, const std::string& path) {
    keys.push_back(joinPath(path_.back(), about.name));
    if (path_.size() == 1) sections_.push_back({about.name, about.meaning, ""});
    path_.push_back(path);
  }

  std::vector<std::string> path_{""};
  std::vector<Section> sections_{{"Top level", "Keys outside any section.", ""}};
};

}  // namespace

std::string Range::describe() const {
  const bool has_low = low > std::numeric_limits<double>::lowest();
  const bool has_high = high < std::numeric_limits<double>::max();
  if (!has_low && !has_high) return "any finite number";
  if (!open_low && !open_high && has_low && has_high) return toShortText(low) + " to " + toShortText(high);
  std::vector<std::string> sides;
  if (has_low) sides.push_back((open_low ? "above " : "at least ") + toShortText(low));
  if (has_high) sides.push_back((open_high ? "below " : "at most ") + toShortText(high));
  return join(sides, " and ");
}

int editDistance(const std::string& a, const std::string& b) {
  const int rows = static_cast<int>(a.size()), columns = static_cast<int>(b.size());
  // Rows i - 2, i - 1 and i of the table of distances between prefixes.
  std::vector<int> before(columns + 1), last(columns + 1), row(columns + 1);
  std::iota(row.begin(), row.end(), 0);
  for (int i = 1; i <= rows; ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i;
    for (int j = 1; j <= columns; ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[columns];
}

std::string nearestWord(const std::string& word, const std::vector<std::string>& candidates) {
  std::string nearest;
  int least = std::numeric_limits<int>::max();
  for (const std::string& candidate : candidates) {
    const int distance = editDistance(word, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

namespace internal {

void readFields(const Value& value, const std::vector<std::string>& all_keys, const Visit& visit_params,
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

Value printFields(const Visit& visit_params) {
  Printer printer;
  visit_params(printer);
  return printer.takeRoot();
}

std::vector<std::string> listKeys(const Visit& visit_defaults) {
  Page page;
  visit_defaults(page);
  return page.keys;
}

std::string tabulateFields(const Visit& visit_defaults) {
  Page page;
  visit_defaults(page);
  return page.text();
}

}  // namespace internal

}  // namespace deformable_surface
