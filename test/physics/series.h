// Runs a problem of the physics suite at several resolutions.
#pragma once

#include "physics/problem.h"

#include <gtest/gtest.h>

namespace deformable_surface::physics {

inline std::string describe(const Problem& problem, const Variant& variant) {
  return problem.name + ", " + nameMembrane(variant) + ", " + nameSampling(variant);
}

/// The answers at `count` sizes from the coarsest on. The test fails if a size has none.
inline std::vector<Answer> ask(const Problem& problem, const Variant& variant, std::size_t count, std::size_t first = 0) {
  std::vector<Answer> answers;
  for (std::size_t k = first; k < first + count; ++k) {
    answers.push_back(solve(problem, variant, problem.sizes.at(k)));
    EXPECT_EQ(answers.back().failure, "") << describe(problem, variant) << ", size " << problem.sizes[k];
  }
  return answers;
}

inline bool isTriangles(const Variant& variant) { return variant.membrane == model::Membrane::kTriangles; }

}  // namespace deformable_surface::physics
