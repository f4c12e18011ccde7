// Describes parameter structs once: a function visit(Fields&, XParams&) beside each struct names its fields. Reading,
// printing, checking and the page of parameters come from it.
#pragma once

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/types.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface {

/// The numbers that a field accepts. NaN is in no range.
struct Range {
  double low = 0.0, high = 0.0;
  bool open_low = false, open_high = false;  // the end itself is not accepted

  bool contains(double value) const {
    return (open_low ? value > low : value >= low) && (open_high ? value < high : value <= high);
  }
  /// "0 to 10", "above -1 and below 0.5", "any finite number".
  std::string describe() const;
};

constexpr Range between(double low, double high) { return {low, high, false, false}; }
constexpr Range strictlyBetween(double low, double high) { return {low, high, true, true}; }
constexpr Range anyFinite() { return {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max(), false, false}; }

/// The largest coordinate or length that scenes accept, m: beyond it squared distances lose the surface in rounding.
constexpr double kMaxLength = 1e6;

/// The largest count of points that scenes accept: their coordinates alone are then some gigabytes.
constexpr double kMaxPoints = 1e8;

/// A quantity with its bounds, as in the map `expect`.
struct NamedBounds {
  std::string name;
  double min = 0.0, max = 0.0;
};

/// What a visit function calls, one line per field. Each visitor (reader, printer, page) implements the handlers below.
class Fields {
 public:
  virtual ~Fields() = default;

  /// The next field has no default: it must be given.
  Fields& required() {
    required_ = true;
    return *this;
  }

  void number(const char* name, double& value, const char* unit, const Range& range, const char* meaning) {
    onNumber(take(name, meaning, unit, range), value);
  }
  void number(const char* name, OrAuto<double>& value, const char* unit, const Range& range, const char* meaning) {
    onNumberOrAuto(take(name, meaning, unit, range), value);
  }
  void integer(const char* name, Index& value, const char* unit, const Range& range, const char* meaning) {
    onInteger(take(name, meaning, unit, range), value);
  }
  void flag(const char* name, bool& value, const char* meaning) { onFlag(take(name, meaning), value); }
  void flag(const char* name, OrAuto<bool>& value, const char* meaning) { onFlagOrAuto(take(name, meaning), value); }
  void text(const char* name, std::string& value, const char* meaning) { onText(take(name, meaning), value); }
  void vector(const char* name, Vec2& value, const char* unit, const Range& range, const char* meaning) {
    onVector(take(name, meaning, unit, range), value.data(), 2);
  }
  void vector(const char* name, Vec3& value, const char* unit, const Range& range, const char* meaning) {
    onVector(take(name, meaning, unit, range), value.data(), 3);
  }
  void vector(const char* name, Vec4& value, const char* unit, const Range& range, const char* meaning) {
    onVector(take(name, meaning, unit, range), value.data(), 4);
  }
  /// A list of rows of three numbers, as the vertices of a mesh.
  void rows(const char* name, Points& value, const char* unit, const Range& range, const char* meaning) {
    onRows(take(name, meaning, unit, range), value);
  }
  /// One of several names.
  template <class Enum>
  void choice(const char* name, Enum& value, const std::vector<std::pair<const char*, Enum>>& names, const char* meaning) {
    std::vector<std::string> accepted;
    int chosen = -1;
    for (const auto& entry : names) {
      if (entry.second == value) chosen = static_cast<int>(accepted.size());
      accepted.emplace_back(entry.first);
    }
    onChoice(take(name, meaning), chosen, accepted, chosen < 0 ? toValue(value) : Value());
    // Where none was chosen, this has been told: the rules that follow need not know such values.
    value = names[std::max(chosen, 0)].second;
  }
  /// A map from quantities to [min, max]. known: the quantities there are.
  void bounds(const char* name, std::vector<NamedBounds>& value, const std::vector<std::string>& known, const char* meaning) {
    onBounds(take(name, meaning), value, known);
  }

  template <class Params>
  void section(const char* name, Params& params, const char* meaning) {
    if (!begin(name, true, meaning)) return;
    visit(*this, params);
    end();
  }
  /// A section whose fields follow until end(), if true is returned. present: the params have it (for printing).
  bool begin(const char* name, bool present, const char* meaning) { return onBegin(take(name, meaning), present); }
  void end() { onEnd(); }

  template <class Params>
  void list(const char* name, std::vector<Params>& items, const char* meaning) {
    items.resize(onBeginList(take(name, meaning), items.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (!onBeginItem(i)) continue;
      visit(*this, items[i]);
      onEnd();
    }
    onEndList();
  }

  /// A rule between fields. name: the field that breaks it ("" = the section itself); sentence: what was found and what is
  /// accepted.
  void require(bool holds, const std::string& name, const std::string& sentence) {
    if (!holds) onBroken(name, sentence);
  }

 protected:
  struct About {
    std::string name;
    const char* meaning;
    const char* unit;
    Range range;
    bool required;
  };

  virtual void onNumber(const About& about, double& value) = 0;
  virtual void onNumberOrAuto(const About& about, OrAuto<double>& value) = 0;
  virtual void onInteger(const About& about, Index& value) = 0;
  virtual void onFlag(const About& about, bool& value) = 0;
  virtual void onFlagOrAuto(const About& about, OrAuto<bool>& value) = 0;
  virtual void onText(const About& about, std::string& value) = 0;
  virtual void onVector(const About& about, double* value, int size) = 0;
  virtual void onRows(const About& about, Points& value) = 0;
  /// chosen: position among the accepted names, -1 = none of them, but the other value.
  virtual void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted, const Value& other) = 0;
  virtual void onBounds(const About& about, std::vector<NamedBounds>& value, const std::vector<std::string>& known) = 0;
  virtual bool onBegin(const About& about, bool present) = 0;
  virtual void onEnd() = 0;
  virtual std::size_t onBeginList(const About& about, std::size_t size) = 0;
  virtual bool onBeginItem(std::size_t i) = 0;
  virtual void onEndList() = 0;
  virtual void onBroken(const std::string& name, const std::string& sentence) = 0;

 private:
  static Value toValue(const std::string& name) { return name; }
  template <class Enum>
  static Value toValue(Enum value) {
    return static_cast<std::int64_t>(value);
  }
  About take(const char* name, const char* meaning, const char* unit = "", const Range& range = {}) {
    return {name, meaning, unit, range, std::exchange(required_, false)};
  }

  bool required_ = false;
};

namespace internal {
using Visit = std::function<void(Fields&)>;
void readFields(const Value& value, const std::vector<std::string>& all_keys, const Visit& visit_params,
                std::vector<std::string>& problems);
Value printFields(const Visit& visit_params);
std::vector<std::string> listKeys(const Visit& visit_defaults);
std::string tabulateFields(const Visit& visit_defaults);
std::string writeTemplate(const Visit& visit_params);
}  // namespace internal

/// Reads a map into params; fields that it does not name keep their values. Returns all problems, one sentence each: unknown keys
/// with the nearest known one, wrong types, values out of range, broken rules. After a problem, params are partly read.
template <class Params>
std::vector<std::string> readParams(const Value& value, Params& params) {
  Params defaults;
  std::vector<std::string> problems;
  internal::readFields(
      value, internal::listKeys([&](Fields& fields) { visit(fields, defaults); }), [&](Fields& fields) { visit(fields, params); },
      problems);
  return problems;
}

/// All values, defaults included, in the form that readParams() takes.
template <class Params>
Value printParams(Params params) {
  return internal::printFields([&](Fields& fields) { visit(fields, params); });
}

/// All problems of params that were filled by a program, as readParams() would report them.
template <class Params>
std::vector<std::string> checkParams(const Params& params) {
  Params copy = params;  // so that what was made of them, such as the faces of a mesh, is not made again
  std::vector<std::string> problems;
  // A printed map has no unknown keys, so no known ones are needed.
  internal::readFields(
      printParams(params), {}, [&](Fields& fields) { visit(fields, copy); }, problems);
  return problems;
}

/// The tables of a page of parameters (Markdown): key, default, unit, what is accepted, meaning.
template <class Params>
std::string tabulateParams() {
  Params defaults;
  return internal::tabulateFields([&](Fields& fields) { visit(fields, defaults); });
}

/// All values as YAML that readParams() takes, each with its meaning, unit and range in a comment above it. Lists are empty; an
/// item with every key stands above them as a comment.
template <class Params>
std::string writeTemplate(Params params) {
  return internal::writeTemplate([&](Fields& fields) { visit(fields, params); });
}

/// The least number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
int editDistance(const std::string& a, const std::string& b);

/// The candidate nearest to the word by edit distance, the first of equals; "" if there are no candidates.
std::string nearestWord(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace deformable_surface
