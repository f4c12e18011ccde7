#include "deformable_surface/base/read_number.h"

#include <clocale>
#include <cstdlib>

namespace deformable_surface {

double readNumber(const char* text, const char** end) {
  static const locale_t classic = newlocale(LC_ALL_MASK, "C", nullptr);
  char* behind = nullptr;
  const double value = strtod_l(text, &behind, classic);
  *end = behind;
  return value;
}

}  // namespace deformable_surface
