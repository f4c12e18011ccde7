// A host's locale in which numbers have a comma, for tests of what reads and writes numbers. Few computers have one.
#pragma once

#include <clocale>
#include <string>

namespace deformable_surface::test {

/// While this object lives, the program's locale of numbers is such a one, if the computer has it.
class CommaLocale {
 public:
  CommaLocale() : before_(std::setlocale(LC_NUMERIC, nullptr)) {
    for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "es_ES.UTF-8", "it_IT.UTF-8", "pt_BR.UTF-8", "ru_RU.UTF-8"})
      if (std::setlocale(LC_NUMERIC, name) && *std::localeconv()->decimal_point == ',') return;
  }
  ~CommaLocale() { std::setlocale(LC_NUMERIC, before_.c_str()); }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

  bool isThere() const { return *std::localeconv()->decimal_point == ','; }
  static constexpr const char* kNone = "no locale with a decimal comma is installed";

 private:
  std::string before_;
};

}  // namespace deformable_surface::test
