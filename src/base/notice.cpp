#include "deformable_surface/base/notice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace deformable_surface {

std::string formatPlace(const Vec3& p) {
  constexpr int kLeast = 3, kMost = 15, kDecimals = 4;  // tenths of a millimetre
  std::string text;
  for (const double x : {p.x(), p.y(), p.z()}) {
    const int whole = std::isfinite(x) && x != 0.0 ? static_cast<int>(std::floor(std::log10(std::abs(x)))) + 1 : 0;
    char number[32];
    std::snprintf(number, sizeof number, "%.*g", std::min(kMost, std::max(kLeast, whole + kDecimals)), x);
    text += (text.empty() ? "(" : ", ") + std::string(number);
  }
  return text + ")";
}

std::string withoutNumbers(const std::string& sentence) {
  std::string result;
  bool is_quoted = false;
  for (const char c : sentence) {
    if (c == '\'') is_quoted = !is_quoted;
    if (is_quoted || std::strchr("0123456789.+-e", c) == nullptr) result += c;
  }
  return result;
}

}  // namespace deformable_surface
