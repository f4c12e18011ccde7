// The lengths that hold a surface together around each point: from the minimum spanning tree, and from how points are surrounded.
#include "trust_radii.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/links.h"
#include "signed_sets.h"
#include "spanning_forest.h"
#include "wide_gaps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 1024;  // points per task: about a millisecond of work

// A step off the mean tangent plane counts this much: a sheet half a spacing away is then beyond the trust radius with jitter,
// too, while bends and noise of a tenth of the spacing are next to nothing. Chosen on stacked sheets and folded garments
// (docs/geodesics.md).
constexpr double kOffPlaneScale = 0.35;
// The same between points whose oriented normals oppose each other: two sides of a body, however thin. More than rounding of
// normals and positions, so that a wrongly flipped normal on a flat sheet does no harm.
constexpr double kOppositeScale = 0.05;
// Squared sine of 10 degrees. A bend by less costs a link no more than a twentieth of its length, and its planes meet far away.
constexpr double kNoCrease = 0.03;
// Cosine of 60 degrees. Steeper bends from point to point do not tell which way unoriented normals belong together.
constexpr double kBendCosine = 0.5;

// Of the lengths around a point: the tenth above may be the few bridges between parts.
constexpr double kTreeQuantile = 0.9;
// The trust radius over that length. With less, jittered samplings lose links that are theirs; with more, narrower gaps are
// bridged (docs/geodesics.md).
constexpr double kTreeFactor = 1.16;
// So many links of each point are trusted whatever lies around it: where the sampling is sparser than beside it, the lengths
// around are those of the others. Two lead through a point; three would lead from the end of a row across a gap.
constexpr std::size_t kOwnLinks = 2;
// The trust radius over the longer of them: less than above, for that one is no typical length.
constexpr double kOwnFactor = 1.08;
// Widest angle (rad) without neighbours around a point that is surrounded: less than at a straight edge, and no less than a
// jittered sampling leaves at its nearest neighbours.
constexpr double kCoverGap = 2.8;
// Of the lengths around a point: points at a gap or an edge are surrounded only from across it, if at all, so that all but the
// shortest may be too long. A sampling that is denser in one direction has none that are short.
constexpr double kCoverQuantile = 0.1;
// More than this over the spanning tree's length is not a matter of direction.
constexpr double kMaxCover = 2.0;
// A link stretched more than this by its step off the plane does not count as surrounding.
constexpr double kMaxCoverStretch = 2.0;  // of the squared length
// In a body: how much farther than the nearest on the other side, within 37 degrees, a neighbour may be. Beyond a gap it is
// farther.
constexpr double kOtherSide = 0.8, kAlike = 1.4;
// Neighbours surround a point of a body if each of these directions is within 60 degrees of one; of a cubic lattice's it is
// within 55.
constexpr double kProbed = 0.5;
const Vec3 kProbes[] = {{1, 0, 0},
                        {-1, 0, 0},
                        {0, 1, 0},
                        {0, -1, 0},
                        {0, 0, 1},
                        {0, 0, -1},
                        Vec3(1, 1, 1) / std::sqrt(3.0),
                        Vec3(1, 1, -1) / std::sqrt(3.0),
                        Vec3(1, -1, 1) / std::sqrt(3.0),
                        Vec3(1, -1, -1) / std::sqrt(3.0),
                        Vec3(-1, 1, 1) / std::sqrt(3.0),
                        Vec3(-1, 1, -1) / std::sqrt(3.0),
                        Vec3(-1, -1, 1) / std::sqrt(3.0),
                        Vec3(-1, -1, -1) / std::sqrt(3.0)};
// Over the spanning tree's length: below it, jitter explains the length at which points of a body are surrounded.
constexpr double kDirectional = 1.25;
// Of a body: fewer points that are surrounded that far away alone lie where thin parts meet, and say nothing of the sampling.
constexpr Index kDirectionalShare = 4;
// Around a point: as many as lie within two spacings.
constexpr Index kAround = 12;
// Links of a point that are offered to the spanning tree: a hexagon's.
constexpr Index kTreeLinks = 6;

// d: from one point to another, whose normals are n and m.
double measureSquaredLength(const Vec3& d, const Vec3& n, const Vec3& m, bool is_oriented) {
  const double squared = d.squaredNorm();
  const double along_i = d.dot(n), along_j = d.dot(m);
  const double cosine = n.dot(m);
  // The component along the mean normal: zero on any circular arc, for it rises at one end as much as it falls at the other.
  const auto square = [](double x) { return x * x; };
  const auto measureSame = [&] { return square(along_i + along_j) / (2.0 + 2.0 * cosine); };
  const auto measureOpposite = [&] { return square(along_i - along_j) / (2.0 - 2.0 * cosine); };
  double off_plane, scale = kOffPlaneScale;
  if (is_oriented && cosine < kFacingCosine && cosine > -kBendCosine && along_i > along_j) {
    off_plane = measureOpposite();
  } else if (cosine >= kBendCosine || (is_oriented && cosine > -kBendCosine)) {
    off_plane = measureSame();
  } else if (cosine <= -kBendCosine) {
    off_plane = measureOpposite();
    if (is_oriented) scale = kOppositeScale;
  } else {
    off_plane = std::min(measureSame(), measureOpposite());
  }
  // Rounding must not make a component longer than the whole.
  const double straight = squared + std::min(off_plane, squared) * (1.0 / (scale * scale) - 1.0);
  const double squared_sine = 1.0 - cosine * cosine;
  if (squared_sine < kNoCrease || (is_oriented && cosine < kFacingCosine)) return straight;
  // Over a crease: the way to the line in which the tangent planes meet, and on from it.
  const double way = square(std::abs(along_i) + std::abs(along_j)) + square(d.dot(n.cross(m)));
  return way < straight * squared_sine ? std::max(squared, way / squared_sine) : straight;
}

struct Link {
  float squared_length;
  Index i, j;
  bool operator<(const Link& other) const {
    return std::tie(squared_length, i, j) < std::tie(other.squared_length, other.i, other.j);
  }
};

// squared_own (n): the squared length of the last of a point's own links, m^2.
std::vector<Link> findSpanningTree(const Points& positions, const SurfaceSides& sides, const Lists& neighbors,
                                   std::vector<float>& squared_own) {
  const Index n = neighbors.size();
  std::vector<std::size_t> first(n + 1, 0);
  for (Index i = 0; i < n; ++i) first[i + 1] = first[i] + std::min(kTreeLinks, neighbors.count(i));
  std::vector<Link> links(first[n]);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Link> own;
    for (Index i = begin; i < end; ++i) {
      // The shortest, sorted; none is shorter than in space, so that the farther ones need not be asked.
      own.clear();
      const std::size_t wanted = first[i + 1] - first[i];
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        const bool is_full = own.size() == wanted;
        if (is_full && static_cast<float>((positions[*j] - positions[i]).squaredNorm()) > own.back().squared_length) break;
        const Link link{static_cast<float>(measureSquaredLength(positions, sides, i, *j)), std::min(i, *j), std::max(i, *j)};
        if (is_full && !(link < own.back())) continue;
        if (is_full) own.pop_back();
        own.insert(std::upper_bound(own.begin(), own.end(), link), link);
      }
      std::copy(own.begin(), own.end(), links.begin() + first[i]);
      if (wanted > 0) squared_own[i] = own[std::min(kOwnLinks, wanted) - 1].squared_length;
    }
  });

  SignedSets sets(n);
  const auto findRoot = [&](Index i) { return sets.find(i); };
  std::vector<Link> tree;
  tree.reserve(n);
  const auto forLinks = [&](Index i, const auto& visit) {
    std::for_each(links.begin() + first[i], links.begin() + first[i + 1], visit);
  };
  visitSpanningForest<Link>(n, forLinks, findRoot, [&](const Link& link) {
    if (sets.find(link.i) == sets.find(link.j)) return;
    sets.join(link.i, link.j, false);
    tree.push_back(link);
  });
  return tree;
}

// Squared length at which neighbours, taken nearest first, leave no wide angle; infinite if they always do.
float findSquaredCover(const Points& positions, const SurfaceSides& sides, const Lists& neighbors, Index i, WideGaps& gaps) {
  const TangentPlane plane(positions[i], sides.normals[i]);
  double longest = 0.0;
  gaps.clear();
  for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
    const double squared = measureSquaredLength(positions, sides, i, *j);
    if (squared > kMaxCoverStretch * (positions[*j] - positions[i]).squaredNorm()) continue;
    longest = std::max(longest, squared);
    gaps.add(plane.project(positions[*j]));
    if (gaps.isEmpty()) return static_cast<float>(longest);
  }
  return std::numeric_limits<float>::infinity();
}

// The same in a body; infinite, too, if the last neighbour lies beyond a gap: the nearest on the other side is much nearer.
float findSquaredCoverInSpace(const Points& positions, const Lists& neighbors, Index i) {
  constexpr std::size_t kNumProbes = std::size(kProbes);
  bool is_covered[kNumProbes] = {};
  std::size_t num_covered = 0;
  for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
    const Vec3 d = positions[*j] - positions[i];
    const double length = d.norm();
    for (std::size_t p = 0; p < kNumProbes; ++p) {
      if (is_covered[p] || d.dot(kProbes[p]) < kProbed * length) continue;
      is_covered[p] = true;
      ++num_covered;
    }
    if (num_covered < kNumProbes) continue;
    for (const Index* k = neighbors.begin(i); k != j; ++k) {
      const Vec3 e = positions[*k] - positions[i];
      if (-d.dot(e) < kOtherSide * length * e.norm()) continue;
      if (length > kAlike * e.norm()) return std::numeric_limits<float>::infinity();
      break;
    }
    return static_cast<float>(length * length);
  }
  return std::numeric_limits<float>::infinity();
}

// The last of the first `count` in order. Overwrites values. For a few dozen, of which few are kept, insertion is faster than a
// heap.
template <class IsBefore>
float findLastOf(std::size_t count, std::vector<float>& values, const IsBefore& isBefore) {
  for (std::size_t v = 1; v < values.size(); ++v) {
    const float value = values[v];
    std::size_t at = std::min(v, count);
    if (at == count && !isBefore(value, values[--at])) continue;
    for (; at > 0 && isBefore(value, values[at - 1]); --at) values[at] = values[at - 1];
    values[at] = value;
  }
  return values[count - 1];
}

// The value below which the share of values lies. Overwrites values, which are not empty.
float findQuantile(std::vector<float>& values, double share) {
  // From the nearer end: shares are near one of them.
  const std::size_t count = values.size(), at = static_cast<std::size_t>(share * (count - 1));
  return 2 * at < count ? findLastOf(at + 1, values, std::less<float>()) : findLastOf(count - at, values, std::greater<float>());
}

// Raises the radii (m) of a body if it is sampled more densely in one direction. Returns whether it is. typical: m, of the tree's
// links around each point.
bool holdBodyTogether(const Lists& neighbors, const std::vector<float>& squared_cover, const std::vector<double>& typical,
                      std::vector<double>& radius) {
  const Index n = neighbors.size();
  const auto isDirectional = [&](double cover, Index i) { return std::isfinite(cover) && cover > kDirectional * typical[i]; };
  Index num_directional = 0;
  for (Index i = 0; i < n; ++i) num_directional += isDirectional(std::sqrt(squared_cover[i]), i);
  if (num_directional == 0 || num_directional < n / kDirectionalShare) return false;
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<float> around;
    for (Index i = begin; i < end; ++i) {
      around.assign(1, squared_cover[i]);
      const Index* last = neighbors.begin(i) + std::min(kAround, neighbors.count(i));
      for (const Index* j = neighbors.begin(i); j != last; ++j) around.push_back(squared_cover[*j]);
      const double cover = std::sqrt(findQuantile(around, kCoverQuantile));
      if (isDirectional(cover, i)) radius[i] = std::max(radius[i], std::min(kTreeFactor * cover, kMaxCover * radius[i]));
    }
  });
  return true;
}

}  // namespace

double measureSquaredLength(const Points& positions, const SurfaceSides& sides, Index i, Index j) {
  const Vec3 d = positions[j] - positions[i];
  if (sides.normals.empty()) return d.squaredNorm();
  const double smooth = measureSquaredLength(d, sides.normals[i], sides.normals[j], sides.oriented);
  if (sides.at_creases.empty() || (sides.at_creases[i] == sides.normals[i] && sides.at_creases[j] == sides.normals[j]))
    return smooth;
  return std::min(smooth, measureSquaredLength(d, sides.at_creases[i], sides.at_creases[j], sides.oriented));
}

TrustRadii findTrustRadii(const Points& positions, const SurfaceSides& sides, const Lists& neighbors, bool of_body) {
  const Index n = neighbors.size();
  std::vector<float> squared_own(n);
  const std::vector<Link> tree = findSpanningTree(positions, sides, neighbors, squared_own);

  // The lengths of the tree's links at each point, in any order.
  std::vector<std::atomic<Index>> place(n);
  const auto forEnds = [&](const auto& visit) {
    parallelFor(static_cast<Index>(tree.size()), kBlock, [&](Index begin, Index end) {
      for (Index t = begin; t < end; ++t) {
        visit(tree[t].i, tree[t].squared_length);
        visit(tree[t].j, tree[t].squared_length);
      }
    });
  };
  for (std::atomic<Index>& p : place) p.store(0, std::memory_order_relaxed);
  forEnds([&](Index i, float) { place[i].fetch_add(1, std::memory_order_relaxed); });
  std::vector<Index> offset(n + 1, 0);
  for (Index i = 0; i < n; ++i) {
    offset[i + 1] = offset[i] + place[i].load(std::memory_order_relaxed);
    place[i].store(offset[i], std::memory_order_relaxed);
  }
  std::vector<float> squared(offset[n]);
  forEnds([&](Index i, float length) { squared[place[i].fetch_add(1, std::memory_order_relaxed)] = length; });

  std::vector<float> squared_cover(sides.normals.empty() && !of_body ? 0 : n);
  parallelFor(static_cast<Index>(squared_cover.size()), kBlock, [&](Index begin, Index end) {
    WideGaps gaps(kCoverGap);
    for (Index i = begin; i < end; ++i)
      squared_cover[i] =
          of_body ? findSquaredCoverInSpace(positions, neighbors, i) : findSquaredCover(positions, sides, neighbors, i, gaps);
  });

  std::vector<double> radius(n, 0.0), typical_of(of_body ? n : 0, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<float> around;
    for (Index i = begin; i < end; ++i) {
      const Index* last = neighbors.begin(i) + std::min(kAround, neighbors.count(i));
      around.assign(squared.begin() + offset[i], squared.begin() + offset[i + 1]);
      for (const Index* j = neighbors.begin(i); j != last; ++j) {
        around.insert(around.end(), squared.begin() + offset[*j], squared.begin() + offset[*j + 1]);
      }
      if (around.empty()) continue;
      const double typical = std::sqrt(findQuantile(around, kTreeQuantile));
      const double from_tree = std::max(kTreeFactor * typical, kOwnFactor * std::sqrt(squared_own[i]));
      radius[i] = from_tree;
      if (of_body) typical_of[i] = typical;
      if (of_body || squared_cover.empty()) continue;
      around.assign(1, squared_cover[i]);
      for (const Index* j = neighbors.begin(i); j != last; ++j) around.push_back(squared_cover[*j]);
      const double cover = std::sqrt(findQuantile(around, kCoverQuantile));
      if (std::isfinite(cover)) radius[i] = std::max(from_tree, std::min(cover, kMaxCover * from_tree));
    }
  });
  const bool is_directional = of_body && holdBodyTogether(neighbors, squared_cover, typical_of, radius);
  return {std::move(radius), is_directional};
}

}  // namespace deformable_surface::cloud
