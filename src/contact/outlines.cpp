#include "deformable_surface/contact/outlines.h"

#include "deformable_surface/base/median.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace deformable_surface::contact {
namespace {

using Triangle = std::array<Index, 3>;
using Loop = std::vector<Index>;

// Of the median edge: loops are filled up where the triangles of their edges with their middles are lower at rest.
constexpr double kLow = 0.35;
constexpr std::size_t kSmallHole = 6;  // points of a hole that is filled up as a whole

// Twice the area vector.
Vec3 areaOf(const Loop& loop, const Points& rest) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < loop.size(); ++k)
    sum += (rest[loop[k]] - rest[loop[0]]).cross(rest[loop[(k + 1) % loop.size()]] - rest[loop[0]]);
  return sum;
}

Vec3 middleOf(const Loop& loop, const Points& rest) {
  Vec3 sum = Vec3::Zero();
  for (const Index i : loop) sum += rest[i];
  return sum / static_cast<double>(loop.size());
}

// Loops of the edges without a triangle beyond. None passes a point twice: there the loop is closed.
std::vector<Loop> findLoops(const std::vector<Triangle>& triangles) {
  std::set<std::pair<Index, Index>> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) edges.insert({t[k], t[(k + 1) % 3]});
  std::set<std::pair<Index, Index>> boundary;
  for (const auto& [from, to] : edges)
    if (edges.count({to, from}) == 0) boundary.insert({from, to});
  std::vector<Loop> loops;
  while (!boundary.empty()) {
    Loop way{boundary.begin()->first};
    do {
      const auto edge = boundary.lower_bound({way.back(), 0});
      const Index next = edge->second;
      boundary.erase(edge);
      const auto passed = std::find(way.begin(), way.end(), next);
      if (passed != way.end()) {
        loops.emplace_back(passed, way.end());
        way.erase(passed, way.end());
      }
      way.push_back(next);
    } while (way.size() > 1);
  }
  return loops;
}

// Whether some edge runs towards the middle of the loop, or back. direction: from which the loop runs anticlockwise.
bool recedes(const Loop& loop, const Points& rest, const Vec3& direction, double least) {
  const Vec3 middle = middleOf(loop, rest);
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Vec3 p = rest[loop[k]] - middle, q = rest[loop[(k + 1) % loop.size()]] - middle;
    if (!(direction.dot(p.cross(q)) >= least * std::max(p.norm(), q.norm()))) return true;
  }
  return false;
}

// Cuts off the best triangle between three points in a row outside of the surface. Returns whether there is one.
bool fillOne(Loop& loop, const Points& rest, const Vec3& direction, std::vector<Triangle>& triangles) {
  const auto areaBetween = [&](Index a, Index b, Index c) { return direction.dot((rest[b] - rest[a]).cross(rest[c] - rest[a])); };
  const std::size_t n = loop.size();
  std::size_t best = n;
  double highest = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const Index before = loop[(k + n - 1) % n], at = loop[k], after = loop[(k + 1) % n];
    const double longest =
        std::max({(rest[before] - rest[at]).norm(), (rest[after] - rest[at]).norm(), (rest[after] - rest[before]).norm()});
    const double altitude = areaBetween(at, before, after) / longest;
    if (!(altitude > highest)) continue;
    const bool is_free = std::none_of(loop.begin(), loop.end(), [&](Index i) {
      return i != before && i != at && i != after && areaBetween(at, before, i) >= 0.0 && areaBetween(before, after, i) >= 0.0 &&
             areaBetween(after, at, i) >= 0.0;
    });
    if (!is_free) continue;
    highest = altitude;
    best = k;
  }
  if (best == n) return false;
  triangles.push_back({loop[best], loop[(best + n - 1) % n], loop[(best + 1) % n]});
  loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(best));
  return true;
}

}  // namespace

Outlines findOutlines(const Points& rest, const std::vector<Triangle>& triangles) {
  const Index n = static_cast<Index>(rest.size());
  std::vector<Index> root(n);
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<char> is_lone(n, 1);
  std::vector<double> lengths;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = find(t[k]), b = find(t[(k + 1) % 3]);
      root[std::max(a, b)] = std::min(a, b);
      is_lone[t[k]] = 0;
      lengths.push_back((rest[t[k]] - rest[t[(k + 1) % 3]]).norm());
    }
  if (triangles.empty()) return {};
  const double edge = findMedian(std::move(lengths));
  const std::vector<Loop> loops = findLoops(triangles);

  // The loop around each part, by the part's first point.
  std::map<Index, Vec3> whole;  // twice the area vector
  for (const Loop& loop : loops) whole.emplace(find(loop[0]), Vec3::Zero()).first->second += areaOf(loop, rest);
  std::map<Index, std::size_t> around;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const Index part = find(loops[l][0]);
    std::size_t& largest = around.emplace(part, l).first->second;
    if (areaOf(loops[l], rest).dot(whole[part]) > areaOf(loops[largest], rest).dot(whole[part])) largest = l;
  }

  std::vector<Index> middle(loops.size(), -1);
  for (Index i = 0; i < n; ++i) {
    if (!is_lone[i]) continue;
    std::size_t nearest = loops.size();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t l = 0; l < loops.size(); ++l)
      for (const Index j : loops[l])
        if ((rest[i] - rest[j]).squaredNorm() < least) {
          least = (rest[i] - rest[j]).squaredNorm();
          nearest = l;
        }
    if (nearest == loops.size() || middle[nearest] >= 0) return {};
    const Index part = find(loops[nearest][0]);
    if (around[part] == nearest) return {};
    middle[nearest] = i;
    root[i] = part;
  }

  Outlines made;
  for (Index i = 0; i < n; ++i) {
    if (find(i) != i || is_lone[i]) continue;
    made.parts.push_back({static_cast<Index>(made.points.size()), static_cast<Index>(made.triangles.size()),
                          static_cast<Index>(made.loops.size())});
    for (Index j = 0; j < n; ++j)
      if (find(j) == i) made.points.push_back(j);
    for (const Triangle& t : triangles)
      if (find(t[0]) == i) made.triangles.push_back(t);
    if (around.count(i) == 0) return {};  // closed
    const Vec3 direction = whole[i].normalized();
    for (std::size_t l = 0; l < loops.size(); ++l) {
      if (find(loops[l][0]) != i) continue;
      Loop loop = loops[l];
      const bool is_hole = l != around[i];
      const Vec3 seen_from = is_hole ? Vec3(-direction) : direction;
      if (is_hole && middle[l] < 0 && loop.size() <= kSmallHole) {
        while (loop.size() > 3 && fillOne(loop, rest, direction, made.triangles)) {}
        if (loop.size() == 3) {
          made.triangles.push_back({loop[0], loop[2], loop[1]});
          continue;
        }
      }
      while (middle[l] < 0 && loop.size() > 3 && recedes(loop, rest, seen_from, kLow * edge))
        if (!fillOne(loop, rest, direction, made.triangles)) break;
      made.loops.push_back({static_cast<Index>(made.loop_points.size()), middle[l], is_hole});
      made.loop_points.insert(made.loop_points.end(), loop.begin(), loop.end());
    }
  }
  made.parts.push_back(
      {static_cast<Index>(made.points.size()), static_cast<Index>(made.triangles.size()), static_cast<Index>(made.loops.size())});
  made.loops.push_back({static_cast<Index>(made.loop_points.size()), -1, false});
  return made;
}

}  // namespace deformable_surface::contact
