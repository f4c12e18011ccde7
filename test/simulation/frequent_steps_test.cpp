// What happens in many steps is told once.
#include "../../src/simulation/frequent_steps.h"

#include <gtest/gtest.h>

#include <functional>

namespace deformable_surface::simulation {
namespace {

// The numbers of the steps, from 0 on, at whose end it is told.
std::vector<int> listTold(FrequentSteps& watch, int steps, double step, const std::function<bool(int)>& happens) {
  std::vector<int> told;
  for (int k = 0; k < steps; ++k)
    if (watch.endStep((k + 1) * step, step, happens(k))) told.push_back(k);
  return told;
}

TEST(FrequentSteps, AreToldOnceAtTheEndOfTheSecond) {
  FrequentSteps watch;
  EXPECT_EQ(listTold(watch, 500, 0.01, [](int k) { return k >= 200 && k % 5 == 0; }), std::vector<int>{299});
  EXPECT_EQ(watch.count(), 20);
  EXPECT_EQ(watch.steps(), 100);
}

TEST(FrequentSteps, ATenthOfTheStepsIsNotMany) {
  FrequentSteps watch;
  EXPECT_TRUE(listTold(watch, 1000, 0.01, [](int k) { return k % 10 == 0; }).empty());
  EXPECT_TRUE(listTold(watch, 1000, 0.01, [](int k) { return k == 3; }).empty());
}

TEST(FrequentSteps, AreCountedInTenStepsAtLeast) {
  FrequentSteps watch;
  EXPECT_TRUE(listTold(watch, 40, 0.5, [](int k) { return k % 10 == 0; }).empty());
  EXPECT_EQ(listTold(watch, 40, 0.5, [](int k) { return k % 5 == 0; }), std::vector<int>{9});
}

TEST(FrequentSteps, AreToldAgainOnceCleared) {
  FrequentSteps watch;
  const auto always = [](int) { return true; };
  EXPECT_EQ(listTold(watch, 300, 0.01, always).size(), 1u);
  EXPECT_TRUE(listTold(watch, 300, 0.01, always).empty());
  watch.clear();
  EXPECT_EQ(listTold(watch, 300, 0.01, always).size(), 1u);
}

}  // namespace
}  // namespace deformable_surface::simulation
