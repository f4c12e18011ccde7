#include "clamp_edges.h"

#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "rest_parts.h"
#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

using Link = std::pair<Index, Index>;

constexpr double kRide = 0.35;  // fraction of the spacing: a point nearer to an edge would have to bend too sharply beside it
constexpr int kHalvings = 12;
// Spacings of the cloud. A region of twice the spacing holds two rows wherever they lie. The ends of links, which lie around
// their point, appear wider by up to a fifth.
constexpr double kWide = 2.5;
// Of the points that a pin holds: fewer that are not like the others are not worth a word, as at the tips of a patch.
constexpr double kHingedShare = 0.1;

// Where the region ends between a place inside and one outside, as a fraction of their distance.
double findEnd(const Vec3& inside, const Vec3& outside, const Contains& contains) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (contains(inside + middle * (outside - inside)) ? low : high) = middle;
  }
  return low;
}

Vec3 nearestOn(const Vec3& a, const Vec3& b, const Vec3& p) {
  const double length = (b - a).squaredNorm();
  const double share = length > 0.0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
  return a + share * (b - a);
}

double measureSpacing(Index i, const Points& x, const Lists& ring) {
  double sum = 0.0;
  for (const Index* j = ring.begin(i); j != ring.end(i); ++j) sum += (x[*j] - x[i]).norm();
  return sum / std::max(Index{1}, ring.count(i));
}

// Whether the nearest neighbours of a point lie to one side of it. Compared are the length of the sum of their ways from it and
// the sum of the lengths. The ratio is 0.45 at the edge of a grid, and about 0.1 within jittered points. The farthest of them
// have little weight: some of their ring are left out, which would look one-sided.
bool isOnRim(Index i, const Points& points, const Lists& neighbors) {
  constexpr Index kNearest = 10;
  constexpr double kOneSided = 0.3;
  std::vector<std::pair<double, Index>> nearest;
  for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) nearest.emplace_back((points[*j] - points[i]).norm(), *j);
  const Index count = std::min(kNearest, static_cast<Index>(nearest.size()));
  std::partial_sort(nearest.begin(), nearest.begin() + count, nearest.end());
  Vec3 sum = Vec3::Zero();
  double lengths = 0.0;
  for (Index k = 0; k < count; ++k) {
    const auto& [length, j] = nearest[k];
    const double share = length / nearest[count - 1].first, weight = 1.0 - share * share;
    sum += weight * (points[j] - points[i]);
    lengths += weight * length;
  }
  return sum.norm() > kOneSided * lengths;
}

// Whether the points inside around this one are the rim of a surface that goes on within it. Round a corner or a curve such a row
// is as wide as a band, and is a hinge nevertheless. A few points do not make a row: a corner and its two neighbours hold a
// plane.
bool isRowOnRim(Index i, const Points& points, const Lists& neighbors, const std::vector<char>& inside) {
  constexpr Index kFewest = 5;  // with the point itself
  if (!isOnRim(i, points, neighbors)) return false;
  bool goes_on = false;
  Index count = 1;
  for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
    const bool is_on_rim = isOnRim(*j, points, neighbors);
    if (inside[*j] && !is_on_rim) return false;
    count += inside[*j];
    goes_on = goes_on || !is_on_rim;
  }
  return goes_on && count >= kFewest;
}

}  // namespace

ClampEdges findClampEdges(const ClampedSurface& surface, const std::vector<char>& clamping, const Contains& contains) {
  ClampEdges found;
  if (std::find(clamping.begin(), clamping.end(), 1) == clamping.end()) return found;
  const Index n = static_cast<Index>(surface.rest.size());
  // For every link that the edge crosses, the place of the crossing at rest; and for each point beside the edge, its nearest
  // place on it.
  std::map<Link, Vec3> crossings;
  const auto cross = [&](Index in, Index out) {
    const auto known = crossings.find(Link(in, out));
    if (known != crossings.end()) return known->second;
    const double share = findEnd(surface.now[in], surface.now[out], contains);
    return crossings[Link(in, out)] = surface.rest[in] + share * (surface.rest[out] - surface.rest[in]);
  };
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> distance(n, kFar);
  Points nearest(n, Vec3::Zero());
  for (const model::WeightedTriangle& t : surface.triangles) {
    Vec3 ends[2];
    int num_ends = 0;
    for (int c = 0; c < 3; ++c) {
      const Index a = t.corner[c], b = t.corner[(c + 1) % 3];
      const Index in = clamping[a] ? a : b, out = clamping[a] ? b : a;
      if (clamping[a] != clamping[b] && !contains(surface.now[out])) ends[num_ends++] = cross(in, out);
    }
    if (num_ends != 2) continue;
    for (const Index i : t.corner) {
      const Vec3 place = nearestOn(ends[0], ends[1], surface.rest[i]);
      const double d = (place - surface.rest[i]).norm();
      if (!(d < distance[i])) continue;
      distance[i] = d;
      nearest[i] = place;
    }
  }
  // Where the region's edge meets that of the surface, it crosses the outermost links.
  for (const auto& [link, place] : crossings)
    for (const Index i : {link.first, link.second}) {
      if (!surface.open[link.first] || !surface.open[link.second]) continue;
      distance[i] = std::min(distance[i], (place - surface.rest[i]).norm());
      nearest[i] = place;
    }
  std::vector<char> held = clamping;
  for (Index i = 0; i < n; ++i) {
    if (clamping[i] || !(distance[i] < kRide * measureSpacing(i, surface.rest, surface.ring))) continue;
    found.riding.push_back(i);
    held[i] = 1;
  }
  for (Index i = 0; i < n; ++i) {
    if (!held[i] || !(distance[i] < kFar)) continue;
    if (std::any_of(surface.ring.begin(i), surface.ring.end(i), [&](Index j) { return !held[j]; }))
      found.edges.push_back({i, nearest[i]});
  }
  return found;
}

std::vector<char> markClamping(const Points& points, const Lists& neighbors, const std::vector<char>& inside, double spacing) {
  std::vector<char> clamping(points.size(), 0);
  Points near;
  for (Index i = 0; i < neighbors.size(); ++i) {
    if (!inside[i]) continue;
    near.assign(1, points[i]);
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j)
      if (inside[*j]) near.push_back(points[*j]);
    clamping[i] = isBandOfRows(near, spacing) && !isRowOnRim(i, points, neighbors, inside);
  }
  return clamping;
}

void markWide(const ClampedSurface& surface, const std::vector<char>& inside, const Contains& contains, double spacing,
              std::vector<char>& clamping) {
  Points patch;
  // The ends of the links of a point within the region, at rest.
  const auto addEnds = [&](Index i) {
    for (const Index* j = surface.ring.begin(i); j != surface.ring.end(i); ++j) {
      const double share = inside[*j] ? 1.0 : findEnd(surface.now[i], surface.now[*j], contains);
      patch.push_back(surface.rest[i] + share * (surface.rest[*j] - surface.rest[i]));
    }
  };
  for (Index i = 0; i < static_cast<Index>(inside.size()); ++i) {
    if (!inside[i] || clamping[i]) continue;
    patch.assign(1, surface.rest[i]);
    addEnds(i);
    for (const Index* j = surface.ring.begin(i); j != surface.ring.end(i); ++j)
      if (inside[*j]) addEnds(*j);
    clamping[i] = measureBand(patch) > kWide * spacing;
  }
}

bool canClamp(const SceneParams& params) { return findModel(params.model).isPlate(params); }

namespace {

// Notes pins that do not clamp, or at some of their points only.
void noteHinges(const SceneParams& params, const Points& dense, const std::vector<char>& clamping, RestSurface& s) {
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    Index held = 0, clamps = 0;
    for (std::size_t i = 0; i < dense.size(); ++i) {
      const bool is_held = params.pins[p].region.contains(dense[i]);
      held += is_held;
      clamps += is_held && clamping[i];
    }
    const std::string name = "pins[" + std::to_string(p) + "] is a hinge";
    if (clamps == 0) {
      s.notes.push_back(name + ": it holds one row of points or less, about which the surface turns; a pin of two rows clamps");
    } else if (held - clamps > kHingedShare * held && clamps > kHingedShare * held) {
      s.notes.push_back(
          name + " at " + std::to_string(held - clamps) + " of the " + std::to_string(held) +
          " points that it holds, where these are one row, and clamps at the others: a wider pin clamps everywhere");
    }
  }
}

}  // namespace

void clampPins(const SceneParams& params, const RestSurface& full, RestSurface& s) {
  const Points& dense = full.dense.positions;
  const Contains contains = [&](const Vec3& place) {
    return std::any_of(params.pins.begin(), params.pins.end(), [&](const PinParams& pin) { return pin.region.contains(place); });
  };
  std::vector<char> inside;
  for (const Vec3& p : dense) inside.push_back(contains(p));
  const double spacing = findSpacing(s.area, dense.size());
  const std::vector<char> dense_clamping = markClamping(dense, full.dense_neighbors, inside, spacing);
  std::vector<char> clamping;
  for (std::size_t i = 0; i < s.points.size(); ++i) clamping.push_back(s.pinned[i] == kInPin && dense_clamping[s.dense_index[i]]);
  std::vector<model::WeightedTriangle> triangles;
  for (const cloud::Triangle& t : s.rings.triangles) triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  const ClampEdges found = findClampEdges({s.points, s.points, s.rings.ring, s.rings.open, triangles}, clamping, contains);
  for (const Index i : found.riding)
    if (!s.pinned[i]) s.pinned[i] = kRidesOnPin;
  s.clamp_edges = found.edges;
  noteHinges(params, dense, dense_clamping, s);
}

}  // namespace deformable_surface::simulation
