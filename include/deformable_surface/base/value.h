// A small tree of values (null, bool, integer, real, text, list, map). Scene files and ROS parameters are converted to it, so
// that the reader of parameters knows neither YAML nor ROS.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace deformable_surface {

class Value {
 public:
  using List = std::vector<Value>;
  using Map = std::vector<std::pair<std::string, Value>>;  // in the order in which the keys came; keys are distinct

  Value() = default;                                     // null
  Value(bool value) : data_(value) {}                    // NOLINT: plain values stand for themselves
  Value(int value) : data_(std::int64_t{value}) {}       // NOLINT
  Value(std::int64_t value) : data_(value) {}            // NOLINT
  Value(double value) : data_(value) {}                  // NOLINT
  Value(const char* text) : data_(std::string(text)) {}  // NOLINT
  Value(std::string text) : data_(std::move(text)) {}    // NOLINT
  Value(List list) : data_(std::move(list)) {}           // NOLINT
  Value(Map map) : data_(std::move(map)) {}              // NOLINT

  bool isNull() const { return std::holds_alternative<std::monostate>(data_); }
  bool isMap() const { return std::holds_alternative<Map>(data_); }

  // The content, or nullptr if the value is of another kind.
  const bool* asBool() const { return std::get_if<bool>(&data_); }
  const std::int64_t* asInteger() const { return std::get_if<std::int64_t>(&data_); }
  const double* asReal() const { return std::get_if<double>(&data_); }
  const std::string* asText() const { return std::get_if<std::string>(&data_); }
  const List* asList() const { return std::get_if<List>(&data_); }
  List* asList() { return std::get_if<List>(&data_); }
  const Map* asMap() const { return std::get_if<Map>(&data_); }
  Map* asMap() { return std::get_if<Map>(&data_); }

  /// The member of a map, or nullptr if there is none or this is no map.
  const Value* find(const std::string& key) const;
  Value* find(const std::string& key) { return const_cast<Value*>(std::as_const(*this).find(key)); }
  /// Sets the member of a map, in place or at the end; a null value becomes a map first.
  Value& set(const std::string& key, Value value);

  /// The value in words, for a sentence: "-1", "the text 'abc'", "a list of 3", "nothing". Long or unprintable text is shortened.
  std::string describe() const;

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Map> data_;
};

/// A number written as text ("3", "1e5", ".inf"), whatever the locale: an integer or real Value; null if it is not a number.
/// Integers with leading zeros are not numbers, since some readers take them as octal.
Value parseNumber(const std::string& text);

/// The value of a plain (unquoted) YAML scalar: null, bool, integer, real or else text.
Value parseScalar(const std::string& text);

/// The shortest decimal form that reads back as the same double.
std::string formatReal(double value);

/// A measured number for a sentence: few digits.
std::string formatShort(double value);

/// Text in quotes for a sentence: control characters are replaced, and long text is cut.
std::string quote(const std::string& text);

/// The text with '?' in place of control characters (except line breaks) and of bytes that are not UTF-8.
std::string toPrintable(const std::string& text);

/// Joins lines with "; " for a log or an answer: as many whole lines as fit into a length that logs show, then the number of
/// lines left out. A first line that is too long is cut.
std::string toOneLine(const std::string& text);

/// The tree as YAML that reads back as the same tree.
std::string toYaml(const Value& value);

}  // namespace deformable_surface
