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

TEST(Notice, SentencesOfOneCauseDifferInNumbersButNotInQuotedNames) {
  EXPECT_EQ(withoutNumbers("12 points at -0.5 m"), withoutNumbers("7 points at 1e-3 m"));
  EXPECT_NE(withoutNumbers("tool 'a1' slips"), withoutNumbers("tool 'a2' slips"));
  EXPECT_NE(withoutNumbers("12 points"), withoutNumbers("12 steps"));
}

}  // namespace
}  // namespace deformable_surface
