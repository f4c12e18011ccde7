// Strips that bend: under their weight, by a force and by a moment at the end, against the elastica. A clamp acts behind the last held
// points, by less than their spacing: that makes the first order and, where the strip bends little, most of the error.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(HeavyElastica, IsFollowedOverFourDecades) {
  for (const char* gamma : {"0.1", "1", "10", "100", "1000"}) {
    const Problem problem = findProblem(listStrips(), std::string("heavy elastica, gamma ") + gamma);
    for (const Variant& variant : problem.variants) {
      // Twenty-five points along the length: a clamp that acts a spacing further back makes a strip four per cent longer, and its
      // droop grows with the fourth power of that where gamma is small.
      EXPECT_LT(ask(problem, variant, 1, 2)[0].error, 0.3) << describe(problem, variant);
    }
  }
}

TEST(HeavyElastica, TheErrorFallsWithTheSpacing) {
  const Problem problem = findProblem(listStrips(), "heavy elastica, gamma 10");
  for (const Variant& variant : problem.variants)
    EXPECT_GT(fitOrder(ask(problem, variant, 3)).value, 0.7) << describe(problem, variant);
}

TEST(EndForce, BendsAsTheElasticaAndTheTableOfSze) {
  const Problem problem = findProblem(listStrips(), "end force");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 2, 1);
    EXPECT_LT(answers[1].error, 0.11) << describe(problem, variant);
    EXPECT_GT(fitOrder(answers).value, 0.6) << describe(problem, variant);
  }
}

}  // namespace
}  // namespace deformable_surface::physics
