// Layers that the neighbourhoods of a cloud do not tell apart are told; sheets, rough ones, tubes and creases are not.
#include "deformable_surface/simulation/rest_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

namespace deformable_surface::test {
namespace {

constexpr double kSpacing = 0.01;
constexpr int kPoints = 16;  // along a side

class Draw {
 public:
  double operator()(double most) { return most * (engine_() / 2147483648.0 - 1.0); }

 private:
  std::mt19937 engine_{7};
};

// Layers of n x n points. gap: of the spacing.
Points makeLayers(int layers, double gap, double jitter, int n = kPoints) {
  Points points;
  Draw draw;
  for (int k = 0; k < layers; ++k)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double x = i + draw(jitter), y = j + draw(jitter);
        points.push_back(kSpacing * Vec3(x, y, gap * k));
      }
  return points;
}

struct Told {
  std::string warning, note;
};

Told build(const Points& points) {
  cloud::PointCloud cloud;
  cloud.positions = points;
  simulation::SceneParams scene;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.accuracy.estimate = false;
  const simulation::RestSurface s = simulation::buildRestSurface(scene, cloud);
  const auto find = [](const std::vector<std::string>& sentences) {
    const auto found = std::find_if(sentences.begin(), sentences.end(), [](const std::string& sentence) {
      return sentence.find("points above or below them, up to") != std::string::npos;
    });
    return found == sentences.end() ? "" : *found;
  };
  return {find(s.warnings), find(s.notes)};
}

TEST(JoinedLayers, ManyPointsAreAWarning) {
  const Told told = build(makeLayers(5, 0.8, 0.0));  // planes across the layers are denser than the layers
  EXPECT_NE(told.warning.find("of 1280 simulation points"), std::string::npos) << told.warning;
  EXPECT_EQ(told.note, "");
}

TEST(JoinedLayers, APointBetweenLayersIsANoteWithItsPlace) {
  Points points = makeLayers(2, 2.5, 0.1, 24);
  points.push_back(kSpacing * Vec3(7.75, 7.5, 1.1));
  const Told told = build(points);
  EXPECT_EQ(told.warning, "");
  EXPECT_NE(told.note.find("one of them at (0.0691, 0.0705, 0) m"), std::string::npos) << told.note;
}

TEST(JoinedLayers, LayersThatAreApartAndSingleSurfacesAreNotTold) {
  Points rough = makeLayers(1, 0.0, 0.4), crease, tube;
  Draw draw;
  for (Vec3& p : rough) p.z() += draw(0.25 * kSpacing);
  for (const Vec3& p : makeLayers(1, 0.0, 0.0)) {
    const double x = p.x() - 7.0 * kSpacing;  // turned by 110 degrees at x = 0
    crease.emplace_back(x < 0.0 ? x : x * std::cos(110.0 * M_PI / 180.0), p.y(),
                        x < 0.0 ? 0.0 : x * std::sin(110.0 * M_PI / 180.0));
    const double angle = 2.0 * M_PI * p.x() / (kPoints * kSpacing), radius = kPoints * kSpacing / (2.0 * M_PI);
    tube.emplace_back(radius * std::cos(angle), radius * std::sin(angle), p.y());
  }
  for (const Points& points : {makeLayers(2, 1.2, 0.2), makeLayers(4, 1.2, 0.3), rough, crease, tube}) {
    const Told told = build(points);
    EXPECT_EQ(told.warning + told.note, "");
  }
}

}  // namespace
}  // namespace deformable_surface::test
