// Bands of a plane with gaps between them, like rows that a sensor left out.
#include "deformable_surface/simulation/rest_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace deformable_surface::test {
namespace {

constexpr double kSpacing = 0.004, kGap = 0.012;

// Bands of 60 x 12 points side by side; each lies `rise` m above the one before.
simulation::RestSurface build(int num_bands, double gap, double rise = 0.0) {
  cloud::PointCloud cloud;
  for (int band = 0; band < num_bands; ++band) {
    for (int i = 0; i < 60; ++i) {
      for (int j = 0; j < 12; ++j) {
        cloud.positions.emplace_back(kSpacing * i, band * (11 * kSpacing + gap) + kSpacing * j, rise * band);
        cloud.normals.emplace_back(0.0, 0.0, 1.0);
      }
    }
  }
  simulation::SceneParams scene;
  scene.material.thickness = 0.002;
  scene.simplification.target_points = 100 * num_bands;
  scene.accuracy.estimate = false;
  return simulation::buildRestSurface(scene, cloud);
}

// The message about gaps among others; empty if there is none.
std::string findSentence(const std::vector<std::string>& sentences) {
  const auto found = std::find_if(sentences.begin(), sentences.end(), [](const std::string& sentence) {
    return sentence.find("lie beside each other in one surface") != std::string::npos;
  });
  return found == sentences.end() ? "" : *found;
}

TEST(NarrowGaps, BetweenManyPartsAreAWarning) {
  const simulation::RestSurface s = build(4, kGap);
  const std::string warning = findSentence(s.warnings);
  EXPECT_NE(warning.find("4 parts lie"), std::string::npos) << warning;
  EXPECT_NE(warning.find("gaps of 12 mm"), std::string::npos) << warning;
  EXPECT_NE(warning.find("input.min_gap 0.015"), std::string::npos) << warning;  // 1.25 times the gap
  EXPECT_EQ(findSentence(s.notes), "");
}

TEST(NarrowGaps, BetweenTwoPartsAreANote) {
  const simulation::RestSurface s = build(2, kGap);
  EXPECT_EQ(findSentence(s.warnings), "");
  EXPECT_NE(findSentence(s.notes), "");
}

TEST(NarrowGaps, AreNeitherWideNorBetweenLayersNorInOnePart) {
  for (const simulation::RestSurface& s : {build(4, 8.0 * kSpacing), build(4, 0.0, kGap), build(4, kSpacing)}) {
    EXPECT_EQ(findSentence(s.warnings), "");
    EXPECT_EQ(findSentence(s.notes), "");
  }
}

}  // namespace
}  // namespace deformable_surface::test
