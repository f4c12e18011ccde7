// Words of the sentences and of the page that are made from parameter structs.
#pragma once

#include "deformable_surface/base/value.h"

#include <string>
#include <vector>

namespace deformable_surface {

inline std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : separator) + word;
  return all;
}

inline std::string joinPath(const std::string& path, const std::string& name) {
  if (name.empty()) return path;
  return path.empty() ? name : path + "." + name;
}

// A number for a sentence: "1e9" instead of "1.0e+09".
inline std::string toShortText(double value) {
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

}  // namespace deformable_surface
