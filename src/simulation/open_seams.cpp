#include "open_seams.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kJump = 4.0;      // of the spacing: longer links are refused (cloud::LinkRule)
constexpr double kAcross = 1.5;    // spacings of the coarse part: farther away lies another part, or a hole
constexpr double kOffPlane = 0.4;  // of its length: what rises more than that goes to another layer
constexpr Index kFewest = 4;       // points: fewer are corners and outliers

// The median length of its links, m; 0 without any.
double findSpacingAt(const Points& points, const Lists& ring, Index i, std::vector<double>& lengths) {
  lengths.clear();
  for (const Index* j = ring.begin(i); j != ring.end(i); ++j) lengths.push_back((points[*j] - points[i]).norm());
  if (lengths.empty()) return 0.0;
  std::nth_element(lengths.begin(), lengths.begin() + lengths.size() / 2, lengths.end());
  return lengths[lengths.size() / 2];
}

// Whether they are linked, at most over one other.
bool areNear(const Lists& ring, Index i, Index j) {
  const auto linked = [&](Index a) { return a == j || std::find(ring.begin(a), ring.end(a), j) != ring.end(a); };
  return linked(i) || std::any_of(ring.begin(i), ring.end(i), linked);
}

}  // namespace

void warnOfOpenSeams(RestSurface& s) {
  const cloud::Rings& rings = s.rings;
  // Fewer points are chosen evenly. At silhouettes of camera frames their spacing differs all the same, without a gap between.
  const bool are_all_simulated = s.points.size() == s.dense.positions.size();
  if (!are_all_simulated || rings.ring.size() != static_cast<Index>(s.points.size())) return;
  std::vector<double> spacing, lengths;
  Points edge;
  std::vector<Index> points;  // these
  for (Index i = 0; i < rings.ring.size(); ++i) {
    const double at = rings.open[i] ? findSpacingAt(s.points, rings.ring, i, lengths) : 0.0;
    if (!(at > 0.0)) continue;
    edge.push_back(s.points[i]);
    points.push_back(i);
    spacing.push_back(at);
  }
  if (edge.empty()) return;
  const cloud::KdTree tree(edge);
  std::vector<cloud::Neighbor> near;
  Index count = 0, first = 0;
  for (std::size_t k = 0; k < edge.size(); ++k) {
    const Index i = points[k];
    const Vec3 &p = edge[k], &normal = s.normals[i];
    const double here = spacing[k];
    tree.withinRadius(p, kAcross * here, near);
    const bool faces = std::any_of(near.begin(), near.end(), [&](const cloud::Neighbor& other) {
      const Vec3 line = edge[other.index] - p;
      return !areNear(rings.ring, i, points[other.index]) && here > kJump * spacing[other.index] &&
             line.norm() > kJump * spacing[other.index] && std::abs(normal.dot(line)) <= kOffPlane * line.norm();
    });
    if (faces && count++ == 0) first = i;
  }
  if (count < kFewest) return;
  s.warnings.push_back(
      std::to_string(count) +
      " points at open edges lie across from points whose spacing is less than a quarter of theirs, the first at " +
      formatPlace(s.points[first]) +
      " m: no link is longer than four spacings, so that the surface is open there "
      "and gives way; simplification.target_points makes points even and joins it");
}

}  // namespace deformable_surface::simulation
