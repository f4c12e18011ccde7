// Visitors of parameter structs other than reader and page: the printer, ranges in words, and the nearest
// word.
#include "deformable_surface/base/params.h"

#include "params_text.h"

#include <algorithm>
#include <numeric>

namespace deformable_surface {

namespace {

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
  void onFlagOrAuto(const About& about, OrAuto<bool>& value) override {
    put(about, value.is_auto ? Value("auto") : Value(value.value));
  }
  void onText(const About& about, std::string& value) override { put(about, value); }
  void onVector(const About& about, double* value, int size) override { put(about, Value::List(value, value + size)); }
  void onRows(const About& about, Points& value) override {
    Value::List rows;
    for (const Vec3& row : value) rows.push_back(Value::List(row.data(), row.data() + 3));
    put(about, std::move(rows));
  }
  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted, const Value& other) override {
    put(about, chosen < 0 ? other : Value(accepted[chosen]));
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
  void onBroken(const std::string&, const std::string&) override {}

  std::vector<Frame> stack_{{"", Value::Map{}, false}};
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

Value internal::printFields(const Visit& visit_params) {
  Printer printer;
  visit_params(printer);
  return printer.takeRoot();
}

}  // namespace deformable_surface
