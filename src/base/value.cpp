// The value tree: finding members, describing values in sentences, numbers as text and back, printing as YAML.
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <locale>
#include <sstream>

namespace deformable_surface {

namespace {

// Sentences stay readable on a line of a terminal.
constexpr std::size_t kMaxQuoted = 60;
// A line of a log that is still read: two or three sentences.
constexpr std::size_t kMaxLine = 400;

/// Number of bytes of the character that begins there; 0: a control character, or invalid UTF-8.
std::size_t measurePrintable(const std::string& text, std::size_t begin) {
  const auto byteAt = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byteAt(begin);
  if (first < 0x80) return first >= 0x20 && first != 0x7f;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byteAt(begin + k) & 0xc0) != 0x80) return 0;
  // Refuses overlong forms, surrogates, values beyond Unicode, and the second block of control characters.
  const unsigned second = byteAt(begin + 1);
  const bool is_wrong = (first == 0xc2 && second < 0xa0) || (first == 0xe0 && second < 0xa0) ||
                        (first == 0xed && second > 0x9f) || (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return is_wrong ? 0 : length;
}

/// The text up to about a length, in whole characters. kept: unprintable characters that stay.
std::string makePrintable(const std::string& text, std::size_t length, const char* kept) {
  std::string shown;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t taken = measurePrintable(text, i);
    if (i + std::max<std::size_t>(taken, 1) > length) break;
    const bool stays = taken > 0 || (text[i] != '\0' && std::strchr(kept, text[i]));
    shown += stays ? text.substr(i, std::max<std::size_t>(taken, 1)) : "?";
    i += std::max<std::size_t>(taken, 1);
  }
  return shown;
}

bool isOneOf(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) {
    if (text == word) return true;
  }
  return false;
}

// [sign] digits [. digits] [e [sign] digits], with a digit somewhere before the exponent.
bool isDecimal(const std::string& text, bool& is_integer) {
  std::size_t i = 0, digits = 0;
  const auto skipDigits = [&] {
    const std::size_t start = i;
    while (i < text.size() && std::isdigit(static_cast<unsigned char>(text[i]))) ++i;
    return i - start;
  };
  const auto skipSign = [&] {
    if (i < text.size() && (text[i] == '+' || text[i] == '-')) ++i;
  };
  skipSign();
  const std::size_t first = i;
  digits = skipDigits();
  const bool leading_zero = digits > 1 && text[first] == '0';
  is_integer = true;
  if (i < text.size() && text[i] == '.') {
    is_integer = false;
    ++i;
    digits += skipDigits();
  }
  if (digits == 0) return false;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    is_integer = false;
    ++i;
    skipSign();
    if (skipDigits() == 0) return false;
  }
  return i == text.size() && !(is_integer && leading_zero);
}

// Text that readers of either YAML version take as the same text without quotes.
bool isPlainText(const std::string& text) {
  if (text.empty() || !std::isalpha(static_cast<unsigned char>(text[0]))) return false;
  for (const char c : text) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '.' && c != '/' && c != '-') return false;
  }
  std::string lower;
  for (const char c : text) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return !isOneOf(lower, {"null", "true", "false", "yes", "no", "on", "off", "y", "n"});
}

std::string toQuoted(const std::string& text) {
  static const char kHex[] = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += "\\x";
      quoted += kHex[byte >> 4];
      quoted += kHex[byte & 15];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string textToYaml(const std::string& text) { return isPlainText(text) ? text : toQuoted(text); }

bool isScalar(const Value& value) { return !value.asList() && !value.isMap(); }

std::string scalarToYaml(const Value& value) {
  if (const bool* flag = value.asBool()) return *flag ? "true" : "false";
  if (const std::int64_t* integer = value.asInteger()) return std::to_string(*integer);
  if (const double* real = value.asReal()) return formatReal(*real);
  if (const std::string* text = value.asText()) return textToYaml(*text);
  return "null";
}

// On one line: scalars, and lists of scalars.
bool fitsLine(const Value& value) {
  if (const Value::List* list = value.asList()) {
    for (const Value& item : *list) {
      if (!isScalar(item)) return false;
    }
    return true;
  }
  return !value.isMap() || value.asMap()->empty();
}

std::string lineToYaml(const Value& value) {
  if (value.isMap()) return "{}";
  const Value::List* list = value.asList();
  if (!list) return scalarToYaml(value);
  std::string line;
  for (const Value& item : *list) line += (line.empty() ? "" : ", ") + scalarToYaml(item);
  return "[" + line + "]";
}

// The lines of a non-empty map or list, each after the indent; the first without it if it follows a "- ".
void appendBlock(const Value& value, const std::string& indent, bool continues_line, std::string& out) {
  const auto beginLine = [&] {
    if (!continues_line) out += indent;
    continues_line = false;
  };
  if (const Value::Map* map = value.asMap()) {
    for (const auto& [key, member] : *map) {
      beginLine();
      out += textToYaml(key) + ":";
      if (fitsLine(member)) {
        out += " " + lineToYaml(member) + "\n";
      } else {
        out += "\n";
        appendBlock(member, indent + "  ", false, out);
      }
    }
    return;
  }
  for (const Value& item : *value.asList()) {
    beginLine();
    out += "- ";
    if (fitsLine(item)) {
      out += lineToYaml(item) + "\n";
    } else {
      appendBlock(item, indent + "  ", true, out);
    }
  }
}

}  // namespace

const Value* Value::find(const std::string& key) const {
  if (const Map* map = asMap()) {
    for (const auto& [name, value] : *map) {
      if (name == key) return &value;
    }
  }
  return nullptr;
}

Value& Value::set(const std::string& key, Value value) {
  if (isNull()) data_ = Map{};
  Map& map = std::get<Map>(data_);
  for (auto& [name, member] : map) {
    if (name == key) return member = std::move(value);
  }
  map.emplace_back(key, std::move(value));
  return map.back().second;
}

std::string Value::describe() const {
  if (isNull()) return "nothing";
  if (const std::string* text = asText()) return "the text " + quote(*text);
  if (const List* list = asList()) return "a list of " + std::to_string(list->size());
  if (const Map* map = asMap()) return map->empty() ? "an empty map" : "a map with the key " + quote(map->front().first);
  return scalarToYaml(*this);
}

Value parseNumber(const std::string& text) {
  bool is_integer = false;
  if (isDecimal(text, is_integer)) {
    std::istringstream stream(text[0] == '+' ? text.substr(1) : text);
    stream.imbue(std::locale::classic());
    if (is_integer) {
      std::int64_t integer = 0;
      if (stream >> integer) return integer;
      stream.clear();
      stream.seekg(0);
    }
    double real = 0.0;
    stream >> real;
    // Out of the range of a double: too large becomes infinite and is refused where infinity is not accepted; too small is not
    // accepted as a number.
    if (!stream.fail()) return real;
    return std::abs(real) > 1.0 ? Value(std::copysign(std::numeric_limits<double>::infinity(), real)) : Value();
  }
  if (isOneOf(text, {".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF", "inf"})) return std::numeric_limits<double>::infinity();
  if (isOneOf(text, {"-.inf", "-.Inf", "-.INF", "-inf"})) return -std::numeric_limits<double>::infinity();
  if (isOneOf(text, {".nan", ".NaN", ".NAN", "nan"})) return std::numeric_limits<double>::quiet_NaN();
  return {};
}

Value parseScalar(const std::string& text) {
  if (isOneOf(text, {"", "~", "null", "Null", "NULL"})) return {};
  if (isOneOf(text, {"true", "True", "TRUE"})) return true;
  if (isOneOf(text, {"false", "False", "FALSE"})) return false;
  // These are names in YAML; they count as numbers only where a number is expected.
  if (isOneOf(text, {"inf", "-inf", "nan"})) return text;
  Value number = parseNumber(text);
  return number.isNull() ? Value(text) : number;
}

std::string formatReal(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  std::string text;
  // max_digits10 digits always read back; a stream's default of six often does, and keeps powers of ten short.
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(digits);
    out << value;
    text = out.str();
    const Value back = parseNumber(text);
    if (back.asReal() ? *back.asReal() == value : back.asInteger() && static_cast<double>(*back.asInteger()) == value) break;
  }
  // A real stays a real: readers of YAML 1.1 need the point.
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

std::string formatShort(double value) {
  if (std::isnan(value)) return "nan";  // its sign has no meaning
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string quote(const std::string& text) {
  return "'" + makePrintable(text, kMaxQuoted, "") + (text.size() > kMaxQuoted ? "...'" : "'");
}

std::string toPrintable(const std::string& text) { return makePrintable(text, text.size(), "\n"); }

// At the end of a clause, or at least of a word, if there is one in the second half.
std::string cutLine(const std::string& line) {
  const std::string cut = makePrintable(line, kMaxLine, "");
  std::size_t at = cut.rfind("; ");
  if (at == std::string::npos || at < kMaxLine / 2) at = cut.rfind(' ');
  return (at == std::string::npos || at < kMaxLine / 2 ? cut : cut.substr(0, at)) + "...";
}

std::string toOneLine(const std::string& text) {
  std::string shown;
  std::size_t left_out = 0, begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = toPrintable(text.substr(begin, end - begin));
    begin = end + 1;
    if (line.empty()) continue;
    if (shown.empty()) {
      shown = line.size() <= kMaxLine ? line : cutLine(line);
    } else if (left_out == 0 && shown.size() + line.size() <= kMaxLine) {
      shown += "; " + line;
    } else {
      ++left_out;
    }
  }
  return left_out == 0 ? shown : shown + "; and " + std::to_string(left_out) + " more";
}

std::string toYaml(const Value& value) {
  if (fitsLine(value)) return lineToYaml(value) + "\n";
  std::string out;
  appendBlock(value, "", false, out);
  return out;
}

}  // namespace deformable_surface
