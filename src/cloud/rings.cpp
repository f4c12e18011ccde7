// From the stars of single points to the connectivity of the whole: links made symmetric, triangles collected from their corners.
#include "deformable_surface/cloud/rings.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/geometry/delaunay_star.h"
#include "point_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 1024;  // points per task: some milliseconds of work
// Widest angle (rad) of a triangle away from boundaries. The circle around a wider one is more than four times as wide as its
// longest side, and can be empty only beside a gap. There collinear points would span triangles with almost no area, whose
// stiffness grows as they get thinner.
constexpr double kInnerGap = 3.02;
const double kWidestCosine = std::cos(kInnerGap);
// Neighbours that contain the members of most stars.
constexpr Index kFirst = 12;
// Of each neighbour: neighbours that contain the members of nearly every star.
constexpr Index kFirstOfNeighbor = 16;
// Of the longest link: up to about two spacings of an even sampling.
constexpr double kNear = 0.375;
// Of a circle's diameter: a point farther than this from a point on the circle is outside by more than the tie tolerance.
constexpr double kMargin = 1.1;

// The star of every point, in the place of its neighbour list: star i has count[i] entries from neighbors.offsets[i] on.
struct Stars {
  std::vector<Index> member, cell_size, count;
};

// The squared distance (m^2) beyond which no other point can change the star: its circles, which pass through the origin, end
// before. Infinite if it is open.
double findSquaredReach(const std::vector<Vec2>& points, const geometry::DelaunayStar& star) {
  if (star.open) return std::numeric_limits<double>::infinity();
  double largest = 0.0;  // squared diameter
  for (std::size_t r = 0; r < star.ring.size(); ++r) {
    const Vec2 &a = points[star.ring[r]], &b = points[star.ring[r + 1 < star.ring.size() ? r + 1 : 0]];
    const double across = a.x() * b.y() - a.y() * b.x();
    largest = std::max(largest, a.squaredNorm() * b.squaredNorm() * (b - a).squaredNorm() / (across * across));
  }
  return kMargin * kMargin * largest;
}

// Appends what the first neighbours of point i list first and i does not list, if it is near. Farther ones lie across holes.
// known: scratch.
void appendNeighborsOfNeighbors(const Points& positions, const Lists& neighbors, const LinkRule& rule, Index i, PointMap& known,
                                std::vector<Index>& list) {
  known.clear();
  known.add(i);
  for (const Index j : list) known.add(j);
  const auto firstEnd = [&](Index j) { return neighbors.begin(j) + std::min(kFirstOfNeighbor, neighbors.count(j)); };
  for (const Index* j = neighbors.begin(i); j != firstEnd(i); ++j)
    for (const Index* k = neighbors.begin(*j); k != firstEnd(*j); ++k) {
      if (known.find(*k) >= 0) continue;
      known.add(*k);
      if ((positions[*k] - positions[i]).squaredNorm() <= kNear * kNear * rule.maxSquaredLength(i, *k)) list.push_back(*k);
    }
}

// Calls visit(i, linked, star) for every point, in parallel: linked neighbours in any order, of which the star names some.
// isWide(i): the neighbours' neighbours are members, too.
template <class IsWide, class Visit>
void visitStars(const Points& positions, const Points& normals, const Lists& neighbors, const LinkRule& rule,
                const std::vector<char>& is_boundary, const IsWide& isWide, const Visit& visit) {
  const Index n = neighbors.size();
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    geometry::DelaunayStarBuilder builder;
    std::vector<Index> linked, list;
    std::vector<Vec2> projected;
    PointMap known;
    for (Index i = begin; i < end; ++i) {
      list.assign(neighbors.begin(i), neighbors.end(i));
      if (isWide(i)) appendNeighborsOfNeighbors(positions, neighbors, rule, i, known, list);
      const TangentPlane plane(positions[i], normals[i]);
      linked.clear();
      projected.clear();
      const auto add = [&](const Index* begin, const Index* end) {
        for (const Index* j = begin; j != end; ++j) {
          if (!rule.accepts(i, *j)) continue;
          linked.push_back(*j);
          projected.push_back(plane.project(positions[*j]));
        }
        return &builder.build(projected, geometry::kStarTie, is_boundary[i] ? kBoundaryGap : kInnerGap);
      };
      // The others are needed only if one of them may belong to the star of the first. The circles of the star that has them,
      // too, lie within the circles of the first.
      Index* rest = list.data() + std::min(kFirst, neighbors.count(i));
      Index* const last = list.data() + list.size();
      const geometry::DelaunayStar* star = add(list.data(), rest);
      const double reach = findSquaredReach(projected, *star);
      const auto isNear = [&](Index j) {
        const Vec3 link = positions[j] - positions[i];
        const double height = link.dot(normals[i]);
        return !(link.squaredNorm() - height * height > reach);
      };
      const auto mayChange = [&](Index j) {
        return rule.accepts(i, j) && (star->open || !geometry::isOutside(plane.project(positions[j]), projected, *star));
      };
      Index* const beyond = std::partition(rest, last, isNear);
      if (std::any_of(rest, beyond, mayChange)) {
        star = add(rest, beyond);
        rest = beyond;
      }
      std::copy_if(rest, last, std::back_inserter(linked), [&](Index j) { return rule.accepts(i, j); });
      visit(i, linked, *star);
    }
  });
}

Stars buildStars(const Points& positions, const Points& normals, const Lists& neighbors, Rings& rings) {
  const Index n = neighbors.size();
  Stars stars{std::vector<Index>(neighbors.items.size()), std::vector<Index>(neighbors.items.size()), std::vector<Index>(n)};
  rings.open.resize(n);
  // Half of the neighbours are used for the boundary first, then all of them.
  Index max_count = 0;
  for (Index i = 0; i < n; ++i) max_count = std::max(max_count, neighbors.count(i));
  const Boundary boundary = findBoundary(positions, normals, neighbors, std::max(1, max_count / 2));
  const auto isWide = [](Index) { return false; };
  visitStars(positions, normals, neighbors, LinkRule(positions, normals, neighbors), boundary.is_boundary, isWide,
             [&](Index i, const std::vector<Index>& linked, const geometry::DelaunayStar& star) {
               stars.count[i] = static_cast<Index>(star.ring.size());
               for (Index r = 0; r < stars.count[i]; ++r) {
                 stars.member[neighbors.offsets[i] + r] = linked[star.ring[r]];
                 stars.cell_size[neighbors.offsets[i] + r] = star.cell_size[r];
               }
               rings.open[i] = star.open;
             });
  return stars;
}

void checkSizes(const char* function, const Points& positions, const Points& normals, const Lists& neighbors) {
  if (positions.size() == normals.size() && static_cast<Index>(positions.size()) == neighbors.size()) return;
  throw InputError(std::string(function) + ": found " + std::to_string(positions.size()) + " positions, " +
                   std::to_string(normals.size()) + " normals and " + std::to_string(neighbors.size()) +
                   " neighbour lists; accepted: equally many");
}

// Sorts the ring of point i by angle; an open one then starts after its widest gap.
void sortRing(const Points& positions, const Vec3& normal, Index i, bool open, Index* begin, Index* end) {
  const TangentPlane plane(positions[i], normal);
  std::vector<std::pair<double, Index>> by_angle;
  for (const Index* j = begin; j != end; ++j) {
    const Vec2 q = plane.project(positions[*j]);
    by_angle.push_back({std::atan2(q.y(), q.x()), *j});
  }
  std::sort(by_angle.begin(), by_angle.end());
  std::size_t start = 0;
  if (open) {
    double widest = by_angle.front().first - by_angle.back().first + 2.0 * kPi;
    for (std::size_t r = 1; r < by_angle.size(); ++r) {
      const double gap = by_angle[r].first - by_angle[r - 1].first;
      if (gap > widest) {
        widest = gap;
        start = r;
      }
    }
  }
  for (std::size_t r = 0; r < by_angle.size(); ++r) begin[r] = by_angle[(start + r) % by_angle.size()].second;
}

// The union of both directions: where j is in the star of i but i not in that of j, i joins the ring of j by angle.
Lists makeSymmetric(const Points& positions, const Points& normals, const Lists& neighbors, const Stars& stars,
                    const std::vector<char>& open) {
  const Index n = neighbors.size();
  const auto starBegin = [&](Index i) { return stars.member.data() + neighbors.offsets[i]; };
  const auto starEnd = [&](Index i) { return starBegin(i) + stars.count[i]; };

  std::vector<std::pair<Index, Index>> missing;  // (j, i): i is missing in the star of j
  std::vector<Index> num_missing(n, 0);
  for (Index i = 0; i < n; ++i) {
    for (const Index* j = starBegin(i); j != starEnd(i); ++j) {
      if (std::find(starBegin(*j), starEnd(*j), i) != starEnd(*j)) continue;
      missing.push_back({*j, i});
      ++num_missing[*j];
    }
  }

  Lists ring;
  ring.offsets.resize(n + 1);
  for (Index i = 0; i < n; ++i) ring.offsets[i + 1] = ring.offsets[i] + stars.count[i] + num_missing[i];
  ring.items.resize(ring.offsets[n]);
  std::vector<Index> next(n);
  for (Index i = 0; i < n; ++i) {
    next[i] = static_cast<Index>(std::copy(starBegin(i), starEnd(i), ring.items.begin() + ring.offsets[i]) - ring.items.begin());
  }
  for (const auto& [j, i] : missing) ring.items[next[j]++] = i;
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (num_missing[i] == 0) continue;
      sortRing(positions, normals[i], i, open[i], ring.items.data() + ring.offsets[i], ring.items.data() + ring.offsets[i + 1]);
    }
  });
  return ring;
}

// Whether the widest angle is beyond kInnerGap. The stars of the two other corners do not see it.
bool isSliver(const Points& positions, const Index (&corner)[3]) {
  for (int c = 0; c < 3; ++c) {
    const Vec3 a = positions[corner[(c + 1) % 3]] - positions[corner[c]],
               b = positions[corner[(c + 2) % 3]] - positions[corner[c]];
    if (a.dot(b) < kWidestCosine * a.norm() * b.norm()) return true;
  }
  return false;
}

// Each triangle once, with the weights of all stars that hold it.
std::vector<Triangle> gatherTriangles(const Points& positions, const Points& normals, const Lists& neighbors,
                                      const Stars& stars) {
  const Index n = neighbors.size();
  const auto forTriangles = [&](Index i, const auto& visit) {
    const Index first = neighbors.offsets[i], count = stars.count[i];
    for (Index r = 0; r < count; ++r) {
      if (stars.cell_size[first + r] == 0) continue;
      Index corner[3] = {i, stars.member[first + r], stars.member[first + (r + 1) % count]};
      std::sort(corner, corner + 3);
      visit(Triangle{{corner[0], corner[1], corner[2]}, 1.0 / stars.cell_size[first + r]});
    }
  };

  // One list for each smallest corner, filled in the order of the stars.
  Lists lists;
  lists.offsets.assign(n + 1, 0);
  for (Index i = 0; i < n; ++i) forTriangles(i, [&](const Triangle& t) { ++lists.offsets[t.corner[0] + 1]; });
  for (Index i = 0; i < n; ++i) lists.offsets[i + 1] += lists.offsets[i];
  std::vector<Triangle> triangles(lists.offsets[n]);
  std::vector<Index> next(lists.offsets.begin(), lists.offsets.end() - 1);
  for (Index i = 0; i < n; ++i) forTriangles(i, [&](const Triangle& t) { triangles[next[t.corner[0]]++] = t; });

  // Within a list, copies are merged and corners turned counter-clockwise.
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto first = triangles.begin() + lists.offsets[i], last = triangles.begin() + lists.offsets[i + 1];
      std::stable_sort(first, last, [](const Triangle& a, const Triangle& b) {
        return std::tie(a.corner[1], a.corner[2]) < std::tie(b.corner[1], b.corner[2]);
      });
      auto out = first;
      for (auto t = first; t != last;) {
        Triangle merged = *t;
        for (++t; t != last && t->corner[1] == merged.corner[1] && t->corner[2] == merged.corner[2]; ++t) {
          merged.weight += t->weight;
        }
        if (!isSliver(positions, merged.corner)) *out++ = merged;
      }
      next[i] = static_cast<Index>(out - triangles.begin());
      for (auto t = first; t != out; ++t) {
        const auto& [a, b, c] = t->corner;
        const Vec3 area_vector = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
        if (area_vector.dot(normals[a] + normals[b] + normals[c]) < 0.0) std::swap(t->corner[1], t->corner[2]);
      }
      std::sort(first, out, [](const Triangle& a, const Triangle& b) {
        return std::tie(a.corner[1], a.corner[2]) < std::tie(b.corner[1], b.corner[2]);
      });
    }
  });
  auto out = triangles.begin();
  for (Index i = 0; i < n; ++i) out = std::move(triangles.begin() + lists.offsets[i], triangles.begin() + next[i], out);
  triangles.erase(out, triangles.end());
  return triangles;
}

// Whether the gap at the widest corner of a triangle beside a boundary is part of a hole, and no dent in the side of the surface:
// it is very long, or long with neighbours on its other side towards both of its ends. Without the slivers in the dents of its
// sides, a strip of 120 by 30 scanned points has 0.7 % less area. With those in its rim, a hole of 5 spacings in radius has 40 %
// less.
bool isAcrossHole(const Points& positions, const LinkRule& rule, const std::array<Index, 3>& corner,
                  const std::vector<Index>& neighbors) {
  constexpr double kLongest = 0.75;                // of the longest link
  constexpr double kBeyond = 0.05, kAround = 1.5;  // of the gap: distance to it and to its middle
  static const double kSquaredCosine = std::cos(kBoundaryGap) * std::cos(kBoundaryGap);
  for (int c = 0; c < 3; ++c) {
    const Index own = corner[c], first = corner[(c + 1) % 3], second = corner[(c + 2) % 3];
    const Vec3 a = positions[first] - positions[own], b = positions[second] - positions[own];
    const double cosine = a.dot(b);  // times the lengths
    if (cosine >= 0.0 || cosine * cosine < kSquaredCosine * a.squaredNorm() * b.squaredNorm()) continue;
    const Vec3 gap = b - a, middle = positions[own] + 0.5 * (a + b);
    const double squared = gap.squaredNorm();
    const double longest = std::min(rule.maxSquaredLength(first, second), rule.maxSquaredLength(own, first));
    if (squared <= kNear * kNear * longest) return false;
    if (squared > kLongest * kLongest * longest) return true;
    const Vec3 outward = a - a.dot(gap) / squared * gap;  // from the corner to the gap
    const double beyond = kBeyond * std::sqrt(squared) * outward.norm();
    bool is_beyond[2] = {false, false};
    for (const Index j : neighbors) {
      const Vec3 d = positions[j] - middle;
      if (d.squaredNorm() < kAround * kAround * squared && d.dot(outward) > beyond) is_beyond[d.dot(gap) > 0.0] = true;
    }
    return is_beyond[0] && is_beyond[1];
  }
  return false;
}

}  // namespace

Rings buildRings(const Points& positions, const Points& normals, const Lists& neighbors) {
  checkSizes("buildRings", positions, normals, neighbors);
  Rings rings;
  const Stars stars = buildStars(positions, normals, neighbors, rings);
  rings.ring = makeSymmetric(positions, normals, neighbors, stars, rings.open);
  rings.triangles = gatherTriangles(positions, normals, neighbors, stars);
  rings.area.assign(positions.size(), 0.0);
  for (const Triangle& t : rings.triangles) {
    const auto& [a, b, c] = t.corner;
    const double area = 0.5 * (positions[b] - positions[a]).cross(positions[c] - positions[a]).norm();
    for (Index corner : t.corner) rings.area[corner] += t.weight * area / 3.0;
  }
  for (Index i = 0; i < rings.ring.size(); ++i) rings.num_isolated += rings.ring.count(i) == 0;
  return rings;
}

// Lists over the surface leave out some near points beyond wide gaps between points. Stars that disagree overlap: by 0.8 % of the
// area of a lattice jittered by 0.3 of its spacing, by 3 % with 0.45. Their neighbours' neighbours are enough (0.0, 0.1 %). Gaps
// at boundaries count up to kInnerGap, but for those across holes.
double measureArea(const Points& positions, const Points& normals, const Lists& neighbors, const std::vector<char>& are_nearest) {
  checkSizes("measureArea", positions, normals, neighbors);
  if (!are_nearest.empty() && are_nearest.size() != positions.size())
    throw InputError("measureArea: " + std::to_string(are_nearest.size()) + " marks for " + std::to_string(positions.size()) +
                     " points; accepted: as many, or none");
  const LinkRule rule(positions, normals, neighbors);
  // A list of the nearest in space that reaches farther than appendNeighborsOfNeighbors() has all that this would append.
  const auto isWide = [&](Index i) {
    constexpr double kRounding = 1.0 + 1e-9;
    if (are_nearest.empty() || !are_nearest[i] || neighbors.count(i) == 0) return true;
    const double squared_reach = (positions[neighbors.end(i)[-1]] - positions[i]).squaredNorm();
    return !(squared_reach > kRounding * kNear * kNear * rule.maxSquaredLength(i, i));
  };
  std::vector<double> area(positions.size(), 0.0);
  visitStars(positions, normals, neighbors, rule, std::vector<char>(positions.size(), 0), isWide,
             [&](Index i, const std::vector<Index>& linked, const geometry::DelaunayStar& star) {
               const std::size_t count = star.ring.size();
               for (std::size_t r = 0; r < count; ++r) {
                 if (star.cell_size[r] == 0) continue;
                 const Index j = linked[star.ring[r]], k = linked[star.ring[(r + 1) % count]];
                 if (isAcrossHole(positions, rule, {i, j, k}, linked)) continue;
                 area[i] += 0.5 * (positions[j] - positions[i]).cross(positions[k] - positions[i]).norm() / star.cell_size[r];
               }
             });
  return std::accumulate(area.begin(), area.end(), 0.0);
}

}  // namespace deformable_surface::cloud
