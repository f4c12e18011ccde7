#include "joined_layers.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/layers.h"

#include <algorithm>
#include <cmath>

#include "rest_parts.h"
#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

// Of the mean spacing of the simulation points: shorter links are steep on rough surfaces, too. Chosen on drawn layers and on
// scans (docs/geodesics.md).
constexpr double kShortest = 0.9;
constexpr Index kManyShare = 4;  // of the points: one in so many. Steep steps and narrow tubes have up to that many, too

}  // namespace

void noteJoinedLayers(RestSurface& s) {
  const Index n = static_cast<Index>(s.points.size());
  if (s.rings.ring.size() != n || s.normals.size() != s.points.size()) return;
  const double shortest = kShortest * findSpacing(s.area, n);
  std::vector<char> is_joined(n);
  double longest = 0.0;
  std::vector<Index> around;
  for (Index i = 0; i < n; ++i) {
    around.assign(s.rings.ring.begin(i), s.rings.ring.end(i));
    around.push_back(i);
    for (const Index j : around)
      for (const Index k : around) {
        const Vec3 way = s.points[k] - s.points[j];
        if (k <= j || way.norm() < shortest || !cloud::leadsUp(way, s.normals[j], s.normals[k])) continue;
        is_joined[j] = is_joined[k] = 1;
        longest = std::max(longest, way.norm());
      }
  }
  const auto first = std::find(is_joined.begin(), is_joined.end(), 1);
  if (first == is_joined.end()) return;
  const Index joined = static_cast<Index>(std::count(first, is_joined.end(), 1));
  (joined > n / kManyShare ? s.warnings : s.notes)
      .push_back(
          formatCount(joined, "of ") + std::to_string(n) +
          " simulation points are linked, at most over one other, to points above or below them, up to " + formatShort(longest) +
          " m away, one of them at " + formatPlace(s.points[first - is_joined.begin()]) +
          " m: if these are layers near each other, or with single points between them, they are joined there and move as one; "
          "normals in the cloud, or a denser one, may tell them apart (sharp creases, steps and narrow tubes look alike)");
}

}  // namespace deformable_surface::simulation
