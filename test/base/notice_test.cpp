#include "deformable_surface/base/notice.h"

#include <gtest/gtest.h>

namespace deformable_surface {
namespace {

TEST(Notice, SentencesAreJoinedBySemicolons) {
  std::string notice;
  appendNotice(notice, "");
  EXPECT_EQ(notice, "");
  appendNotice(notice, "one");
  appendNotice(notice, "");
  appendNotice(notice, "two");
  EXPECT_EQ(notice, "one; two");
}

TEST(Notice, PlacesHaveThreeDigitsAndFarAwayTenthsOfAMillimetre) {
  EXPECT_EQ(formatPlace(Vec3(0.12345, 0.0, -2.0)), "(0.1235, 0, -2)");
  EXPECT_EQ(formatPlace(Vec3(-0.00012345, 12.5, 512345.67891)), "(-0.000123, 12.5, 512345.6789)");
}

TEST(Notice, SentencesOfOneCauseDifferInNumbersButNotInQuotedNames) {
  EXPECT_EQ(withoutNumbers("12 points at -0.5 m"), withoutNumbers("7 points at 1e-3 m"));
  EXPECT_NE(withoutNumbers("tool 'a1' slips"), withoutNumbers("tool 'a2' slips"));
  EXPECT_NE(withoutNumbers("12 points"), withoutNumbers("12 steps"));
}

}  // namespace
}  // namespace deformable_surface
