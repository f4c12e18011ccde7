// Up to which length links of a body are trusted: across its layers, but not across its gaps.
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace deformable_surface::cloud {
namespace {

// Of layers of 9 x 9 points, spacing 1, at these heights: how many points are listed with points of another layer, and with
// points beyond a gap, wider than 1.7.
struct Listed {
  Index across_layers = 0, across_gaps = 0;
};

Listed listLayers(const std::vector<double>& heights, double jitter) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  Points points;
  std::vector<int> layer, body;
  for (std::size_t l = 0; l < heights.size(); ++l)
    for (int j = 0; j < 81; ++j) {
      const double x = shift(generator), y = shift(generator), z = shift(generator);
      points.emplace_back(heights[l] + x, j % 9 + y, j / 9 + z);
      layer.push_back(static_cast<int>(l));
      body.push_back(l == 0 ? 0 : body[81 * (l - 1)] + (heights[l] - heights[l - 1] > 1.7));
    }
  const Lists listed = nearestNeighbors(points, 32);
  const GeodesicGraph graph = buildGeodesicGraph(points, {}, listed, {}, 0.0, true);
  const Lists kept = keepGeodesicNeighbors(graph, points, {}, listed).lists;
  Listed count;
  for (Index i = 0; i < kept.size(); ++i) {
    const auto isAny = [&](const std::vector<int>& of) {
      return std::any_of(kept.begin(i), kept.end(i), [&](Index j) { return of[j] != of[i]; });
    };
    count.across_layers += isAny(layer);
    count.across_gaps += isAny(body);
  }
  return count;
}

TEST(TrustRadii, ABodyIsHeldTogetherAcrossLayersThatAreFartherApart) {
  for (const double ratio : {1.43, 1.6})
    for (const double jitter : {0.0, 0.1}) {
      std::vector<double> heights;
      for (int l = 0; l < 9; ++l) heights.push_back(ratio * l);
      EXPECT_EQ(listLayers(heights, jitter).across_layers, 729) << ratio << ", jitter " << jitter;
    }
}

TEST(TrustRadii, AGapInABodyIsNoDistanceOfLayers) {
  for (const double jitter : {0.0, 0.1})
    for (const std::vector<double>& heights : {std::vector<double>{0.0, 1.0, 2.0, 3.8, 4.8, 5.8}, {0.0, 1.0, 2.8, 3.8}}) {
      const Listed listed = listLayers(heights, jitter);
      EXPECT_EQ(listed.across_layers, static_cast<Index>(81 * heights.size()));
      EXPECT_EQ(listed.across_gaps, 0) << heights.size() << " layers, jitter " << jitter;
    }
}

}  // namespace
}  // namespace deformable_surface::cloud
