// What lasts is told twice, and no scene tells more than a few lines in a second.
#include "../../src/simulation/lasting_notices.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

namespace deformable_surface::simulation {
namespace {

constexpr double kStep = 0.01;  // s

// The lines of steps, without empty ones. act: what is so in the step of that number; returns what else there is to tell.
std::vector<std::string> listLines(LastingNotices& notices, int steps, const std::function<std::string(int)>& act,
                                   double step = kStep, bool is_static = false) {
  std::vector<std::string> lines;
  for (int k = 0; k < steps; ++k) {
    const std::string line = notices.endStep(k * step, step, is_static, act(k));
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

TEST(LastingNotices, WhatLastsIsToldAtItsBeginningAndAfterItsEnd) {
  LastingNotices notices;
  const auto lines = listLines(notices, 500, [&](int k) {
    const bool is_so = k >= 50 && k < 250 && k % 4 != 3;  // it trembles
    return is_so && notices.see(Lasting::kStopped, k == 100 ? 30 : 3) ? "it begins in step " + std::to_string(k) : "";
  });
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "it begins in step 50");
  EXPECT_EQ(
      lines[1],
      "contact limited the motion of points in 150 of 200 steps, from 0.5 to 2.5 s, at most 30 in a step; none in the last 1 s");
  EXPECT_EQ(notices.endRun(), "");
}

TEST(LastingNotices, WhatDoesNotMatterIsToldNeitherAtItsBeginningNorAtItsEnd) {
  for (const int matters_from : {1000, 120}) {
    LastingNotices notices;
    const auto see = [&](int k) {
      return k >= 50 && k < 250 && notices.see(Lasting::kStopped, 3, k >= matters_from)
                 ? "it matters in step " + std::to_string(k)
                 : "";
    };
    const auto lines = listLines(notices, 240, see);
    if (matters_from > 240) {
      EXPECT_TRUE(lines.empty());
      EXPECT_EQ(notices.endRun(), "");
    } else {
      EXPECT_EQ(lines, std::vector<std::string>{"it matters in step 120"});
      EXPECT_EQ(notices.endRun(),
                "contact limited the motion of points in 190 of 190 steps, from 0.5 to 2.4 s, at most 3 in a step");
    }
  }
}

TEST(LastingNotices, WhatLastsToTheEndOfTheRunIsCountedThere) {
  LastingNotices notices;
  const auto lines =
      listLines(notices, 100, [&](int k) { return k >= 20 && notices.see(Lasting::kUnbalanced, 0.25) ? "begun" : ""; });
  EXPECT_EQ(lines, std::vector<std::string>{"begun"});
  EXPECT_EQ(notices.endRun(),
            "forces were left unbalanced in 80 of 80 steps, from 0.2 to 1 s, at most 0.25 of the largest force");
  notices.clear();
  EXPECT_EQ(notices.endRun(), "");
}

// Each is a search of its own: its success must not be hidden by the failure of the one before, nor the reverse.
TEST(LastingNotices, OfEquilibriaEachChangeIsTold) {
  LastingNotices notices;
  const auto lines = listLines(
      notices, 4, [&](int k) { return k % 2 == 0 && notices.see(Lasting::kUnbalanced, 0.5) ? "begun" : ""; }, 1.0, true);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2], lines[0]);
  EXPECT_EQ(lines[1].find("forces were left unbalanced in 1 of 1 steps"), 0u) << lines[1];
  EXPECT_NE(lines[1].find("in this step no longer"), std::string::npos) << lines[1];
}

// Whatever happens: steps of any length, states that come and go, hundreds of causes.
TEST(LastingNotices, ASecondHasAFewLinesWhateverHappens) {
  std::mt19937 engine(5);
  for (const double step : {0.001, 0.01, 0.3}) {
    for (const double share : {0.02, 0.3, 1.0}) {
      for (const int causes : {1, 3, 500}) {
        LastingNotices notices;
        const int steps = static_cast<int>(20.0 / step);
        std::uniform_real_distribution<double> draw(0.0, 1.0);
        const auto lines = listLines(
            notices, steps,
            [&](int k) -> std::string {
              std::string told;
              for (int what = 0; what < kNumLasting; ++what)
                if (draw(engine) < 0.5 * share && notices.see(static_cast<Lasting>(what), k)) told += "begun; ";
              if (draw(engine) < share) told += "tool '" + std::to_string(static_cast<int>(causes * draw(engine))) + "' slips";
              return told;
            },
            step);
        EXPECT_LE(lines.size(), 4u * 21u) << step << ' ' << share << ' ' << causes;
        EXPECT_GE(lines.size(), 1u);
        for (const std::string& line : lines) EXPECT_LT(line.size(), 3000u);
      }
    }
  }
}

TEST(LastingNotices, WhatIsPutOffIsToldLaterWithItsCount) {
  LastingNotices notices;
  auto lines = listLines(notices, 150, [](int k) { return k < 50 ? "force 'f' has lost " + std::to_string(k) + " N" : ""; });
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "force 'f' has lost 0 N");
  EXPECT_EQ(lines[1], "since the last notice: 49 times: force 'f' has lost 49 N");
  notices.clear();
  lines = listLines(notices, 20, [](int k) { return "tool '" + std::to_string(k) + "' slips"; });
  EXPECT_EQ(lines.size(), 4u);
  EXPECT_NE(notices.endRun().find("tool '7' slips"), std::string::npos) << notices.endRun();
  EXPECT_NE(notices.endRun().find("8 others, the last: tool '19' slips"), std::string::npos) << notices.endRun();
}

}  // namespace
}  // namespace deformable_surface::simulation
