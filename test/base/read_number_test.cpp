#include "deformable_surface/base/read_number.h"
#include "support/comma_locale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace deformable_surface::test {
namespace {

TEST(ReadNumber, TakesTheNumberAtTheBeginning) {
  const char* end = nullptr;
  EXPECT_EQ(readNumber(" -1.5e3 2", &end), -1500.0);
  EXPECT_STREQ(end, " 2");
  EXPECT_EQ(readNumber("0x1.8p+1", &end), 3.0);
  EXPECT_TRUE(std::isnan(readNumber("nan", &end)));
  EXPECT_EQ(readNumber("0,5", &end), 0.0);
  EXPECT_STREQ(end, ",5");
}

TEST(ReadNumber, StaysWhereItIsWithoutANumber) {
  const char *const text = "one", *end = nullptr;
  EXPECT_EQ(readNumber(text, &end), 0.0);
  EXPECT_EQ(end, text);
}

TEST(ReadNumber, HasAPointInEveryLocale) {
  const CommaLocale locale;
  if (!locale.isThere()) GTEST_SKIP() << CommaLocale::kNone;
  const char* end = nullptr;
  EXPECT_EQ(readNumber("0.5", &end), 0.5);
  EXPECT_STREQ(end, "");
}

}  // namespace
}  // namespace deformable_surface::test
