#include "deformable_surface/contact/untangling.h"

#include "deformable_surface/base/disjoint_sets.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::contact {
namespace {

// The parts that remain connected where edges are cut.
class Parts {
 public:
  // is_cut: (edges)
  Parts(const std::vector<Edge>& edges, const std::vector<char>& is_cut, const std::vector<double>& masses)
      : mass_(masses.size(), 0.0) {
    const Index n = static_cast<Index>(masses.size());
    makeSingleSets(n, of_);
    for (std::size_t e = 0; e < edges.size(); ++e)
      if (is_cut[e] == 0) joinSets(of_, edges[e][0], edges[e][1]);
    for (Index i = 0; i < n; ++i) {
      of_[i] = findRoot(of_, i);
      mass_[of_[i]] += masses[i];
    }
  }

  Index of(Index vertex) const { return of_[vertex]; }
  double massOf(Index vertex) const { return mass_[of_[vertex]]; }
  // Of vertices in different parts.
  bool isLighter(Index one, Index other) const {
    return std::make_pair(massOf(one), of_[one]) < std::make_pair(massOf(other), of_[other]);
  }

 private:
  std::vector<Index> of_;  // by vertex: the lowest vertex of its part
  std::vector<double> mass_;
};

Vec3 normalOf(const Points& x, const Triangle& t) { return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized(); }

// Where an edge crosses a triangle, with the triangles at the edge.
struct Place {
  Edge edge;
  Triangle triangle;
  std::vector<Triangle> beside;
  Vec3 point;   // m
  Vec3 across;  // unit normal of the triangle
};

// The direction that brings the lighter part back, for the edge; zero if nothing is cut off here.
Vec3 findWayBack(const Points& x, const Parts& parts, const Place& place) {
  const auto& [edge, t, beside, point, across] = place;
  const auto [low, high] = std::minmax_element(t.begin(), t.end(), [&](Index i, Index j) { return parts.isLighter(i, j); });
  const bool is_edge_cut = parts.of(edge[0]) != parts.of(edge[1]), is_triangle_cut = parts.of(*low) != parts.of(*high);
  const Index lighter = parts.isLighter(edge[0], edge[1]) ? edge[0] : edge[1];
  if (is_edge_cut && (!is_triangle_cut || !parts.isLighter(*low, lighter))) {
    const Vec3 back = x[lighter == edge[0] ? edge[1] : edge[0]] - x[lighter];
    return back.dot(across) > 0.0 ? across : Vec3(-across);
  }
  if (!is_triangle_cut) return Vec3::Zero();
  Vec3 normal = Vec3::Zero(), back = Vec3::Zero();
  for (const Triangle& s : beside) normal += normalOf(x, s);
  for (const Index i : t) back += (parts.of(i) == parts.of(*low) ? -1.0 : 1.0) * (x[i] - point);
  if (!(normal.squaredNorm() > 0.0)) return normal;
  normal.normalize();
  return back.dot(normal) > 0.0 ? Vec3(-normal) : normal;
}

// With unit vectors R from the point along the line of crossings, edge E and normal N: sum R - (E sum R) / (E N) N is minus the
// gradient of the line's length by the edge's displacement. Divided by its length where that is above 1.
Vec3 findShortening(const Points& x, const Place& place) {
  const Vec3 along = (x[place.edge[1]] - x[place.edge[0]]).normalized();
  Vec3 lines = Vec3::Zero();
  for (const Triangle& s : place.beside) {
    Vec3 line = normalOf(x, s).cross(place.across);
    if (!(line.squaredNorm() > 0.0)) continue;
    line.normalize();
    const Index opposite = *std::find_if(s.begin(), s.end(), [&](Index i) { return i != place.edge[0] && i != place.edge[1]; });
    const Vec3 inside = x[opposite] - place.point;
    lines += line.dot(inside - inside.dot(along) * along) < 0.0 ? Vec3(-line) : line;
  }
  const Vec3 shortening = lines - along.dot(lines) / along.dot(place.across) * place.across;
  return shortening / std::max(1.0, shortening.norm());
}

}  // namespace

std::vector<Push> findPushes(const PairList& pairs, const Points& x, const std::vector<double>& masses) {
  const std::vector<Edge>& edges = pairs.edges();
  const std::vector<Triangle>& triangles = pairs.triangles();
  std::vector<char> is_cut(edges.size(), 0);
  // Crossed an odd number of times: its ends lie on different sides.
  for (const Crossing& crossing : pairs.crossings()) is_cut[crossing.edge] ^= 1;
  for (std::size_t e = 0; e < pairs.areEdgesWhole().size(); ++e) is_cut[e] |= pairs.areEdgesWhole()[e] == 0;
  const Parts parts(edges, is_cut, masses);
  std::vector<std::pair<Index, Index>> beside;  // crossed edges, their triangles
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      const Edge edge{std::min(a, b), std::max(a, b)};
      beside.emplace_back(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin(), t);
    }
  std::sort(beside.begin(), beside.end());
  std::vector<Push> pushes;
  Place place;
  for (const Crossing& crossing : pairs.crossings()) {
    place.edge = edges[crossing.edge];
    place.triangle = triangles[crossing.triangle];
    place.beside.clear();
    for (auto b = std::lower_bound(beside.begin(), beside.end(), std::make_pair(crossing.edge, Index{0}));
         b != beside.end() && b->first == crossing.edge; ++b)
      place.beside.push_back(triangles[b->second]);
    const auto& [a, b, c] = place.triangle;
    const Vec3 &p = x[place.edge[0]], &q = x[place.edge[1]];
    place.across = normalOf(x, place.triangle);
    const double from = place.across.dot(x[a] - p), to = place.across.dot(x[a] - q), share = from / (from - to);
    place.point = p + share * (q - p);
    Vec3 direction = findWayBack(x, parts, place);
    if (direction.isZero()) direction = findShortening(x, place);
    if (!direction.allFinite()) continue;
    const Closest on = findClosestToTriangle(place.point, x[a], x[b], x[c]);
    pushes.push_back(
        {{place.edge[0], place.edge[1], a, b, c}, {1.0 - share, share, on.weight[1], on.weight[2], on.weight[3]}, direction});
  }
  return pushes;
}

}  // namespace deformable_surface::contact
