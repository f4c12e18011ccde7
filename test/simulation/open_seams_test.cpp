// Jumps in the spacing of points that leave a surface open are told, milder ones are not.
#include "clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

// A sheet of 0.3 m with a spacing of 10 mm, and a finer spacing in its middle, m.
bool isTold(double fine, bool are_all_simulated = true) {
  Points points;
  const auto fill = [&](double spacing, bool is_middle) {
    const Index n = static_cast<Index>(std::lround(0.3 / spacing));
    for (Index i = 0; i <= n; ++i)
      for (Index j = 0; j <= n; ++j) {
        const Vec3 p(spacing * i - 0.15, spacing * j - 0.15, 0.0);
        if ((std::max(std::abs(p.x()), std::abs(p.y())) < 0.0301) == is_middle) points.push_back(p);
      }
  };
  fill(0.01, false);
  fill(fine, true);
  simulation::SceneParams p;
  if (are_all_simulated)
    p.simplification.method = cloud::SimplificationMethod::kNone;
  else
    p.simplification.target_points = 600;
  p.accuracy.estimate = false;
  const simulation::Simulation s(p, asCloud(points));
  for (const std::string& warning : s.buildWarnings())
    if (warning.find("points at open edges lie across from points whose spacing is less than a quarter of theirs") !=
        std::string::npos)
      return true;
  return false;
}

TEST(OpenSeams, AreToldWhereTheSpacingJumpsFarEnoughToLeaveGaps) {
  EXPECT_TRUE(isTold(0.001));
  EXPECT_FALSE(isTold(0.0025));
  EXPECT_FALSE(isTold(0.01));
  EXPECT_FALSE(isTold(0.001, false));
}

}  // namespace
}  // namespace deformable_surface::test
