// Strips that bend: under their weight, by a force and by a moment at the end, against the elastica.
#include "series.h"

#include <algorithm>

namespace deformable_surface::physics {
namespace {

bool isRegular(const Variant& variant) { return variant.sampling == Sampling::kRegular; }

TEST(HeavyElastica, IsFollowedOverFourDecades) {
  for (const char* gamma : {"0.1", "1", "10", "100", "1000"}) {
    const Problem problem = findProblem(listStrips(), std::string("heavy elastica, gamma ") + gamma);
    for (const Variant& variant : problem.variants) {
      // Twenty-five points along the length (forty for the heaviest). For small gamma the droop grows with the fourth power of
      // the length. Springs do not know the edge of a clamp between points.
      const std::size_t size = gamma == std::string("1000") ? 0 : 2;
      const bool springs = variant.membrane == model::Membrane::kSprings;
      EXPECT_LT(ask(problem, variant, 1, size)[0].error, springs ? 0.2 : 0.02) << describe(problem, variant);
    }
  }
}

TEST(HeavyElastica, OnAGridTheErrorFallsWithTheSquareOfTheSpacing) {
  // From fifteen points along the length on. The heaviest from forty on, with one and a quarter within its bend: its error is
  // already below a per cent there and falls more slowly.
  for (const auto& [gamma, first] : {std::pair("0.1", 1), {"10", 1}, {"1000", 0}}) {
    const Problem problem = findProblem(listStrips(), std::string("heavy elastica, gamma ") + gamma);
    const std::vector<Answer> answers = ask(problem, problem.variants[0], 3, first);
    EXPECT_GT(fitOrder(answers).value, first == 0 ? 1.3 : 1.6) << gamma;
    EXPECT_LT(answers.back().error, 0.005) << gamma;
  }
}

TEST(HeavyElastica, OnIrregularPointsTheErrorFallsToo) {
  const Problem problem = findProblem(listStrips(), "heavy elastica, gamma 10");
  for (const Variant& variant : problem.variants) {
    if (isRegular(variant)) continue;
    EXPECT_GT(fitOrder(ask(problem, variant, 3)).value, 0.8) << describe(problem, variant);
  }
}

TEST(EndForce, BendsAsTheElasticaAndTheTableOfSze) {
  const Problem problem = findProblem(listStrips(), "end force");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 3);
    // Forty points along the length; the clamp as above.
    EXPECT_LT(answers[2].error, isRegular(variant) ? 0.015 : 0.06) << describe(problem, variant);
    // The coarsest of the scanned strips happens to be only 0.15 % off, the finest 0.19 %.
    EXPECT_LT(answers[2].error, std::max(answers[0].error, 0.0025)) << describe(problem, variant);
  }
}

TEST(EndMoment, BendsTheStripToHalfACircle) {
  const Problem problem = findProblem(listStrips(), "end moment, half a circle");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 2);
    // Thirty-six points along the length; the couple that makes the moment acts within the last two spacings.
    EXPECT_LT(answers[1].error, 0.06) << describe(problem, variant);
    EXPECT_LT(answers[1].error, answers[0].error) << describe(problem, variant);
  }
}

}  // namespace
}  // namespace deformable_surface::physics
