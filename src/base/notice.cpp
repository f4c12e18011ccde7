#include "deformable_surface/base/notice.h"

#include <cstring>

namespace deformable_surface {

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
