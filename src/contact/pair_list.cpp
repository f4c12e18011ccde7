#include "deformable_surface/contact/pair_list.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_surface::contact {
namespace {

// Fraction of the median edge: the cheapest for falling or folding sheets; below the rest distance of parts that are not
// neighbours.
constexpr double kUsualRadius = 0.7;
// Factor on a requested radius beyond the usual one, so that the list remains valid for a while.
constexpr double kSpare = 1.5;
// Fraction of the rest distance at which parts begin to repel each other; and neighbours on the surface, which are strained
// elastically before they fold onto each other.
constexpr double kOfRest = 0.9;
constexpr double kOfRestJoined = 0.5;
constexpr Index kBlock = 64;  // vertices or edges per task

Box grow(const Box& box, double by) { return Box(box.min() - Vec3::Constant(by), box.max() + Vec3::Constant(by)); }

template <std::size_t N>
Box boundOf(const Points& positions, const std::array<Index, N>& vertices) {
  Box box;
  for (const Index v : vertices) box.extend(positions[v]);
  return box;
}

template <std::size_t N>
std::vector<Box> boundAll(const Points& positions, const std::vector<std::array<Index, N>>& items) {
  std::vector<Box> boxes;
  boxes.reserve(items.size());
  for (const std::array<Index, N>& vertices : items) boxes.push_back(boundOf(positions, vertices));
  return boxes;
}

std::vector<std::array<Index, 2>> listEdges(Index n, const std::vector<Triangle>& triangles) {
  std::vector<std::array<Index, 2>> edges;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] < 0 || t[k] >= n)
        throw InputError("contact: found a triangle with vertex " + std::to_string(t[k]) + "; accepted: 0 to " +
                         std::to_string(n - 1));
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Whether edge p q crosses triangle a b c.
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a), along = q - p;
  const double from = normal.dot(p - a), to = normal.dot(q - a);
  if (!(from * to < 0.0)) return false;
  const double u = along.dot((b - p).cross(c - p)), v = along.dot((c - p).cross(a - p)), w = along.dot((a - p).cross(b - p));
  return (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
}

}  // namespace

PairList::PairList(Points rest, const std::vector<Triangle>& triangles, double thickness)
    : rest_(std::move(rest)),
      triangles_(triangles),
      thickness_(thickness),
      edges_(listEdges(static_cast<Index>(rest_.size()), triangles_)),
      triangle_boxes_(boundAll(rest_, triangles_)),
      edge_boxes_(boundAll(rest_, edges_)),
      triangle_tree_(triangle_boxes_),
      edge_tree_(edge_boxes_) {
  if (!(thickness > 0.0)) throw InputError("contact: the thickness is " + std::to_string(thickness) + " m; accepted: above 0");
  std::vector<double> lengths;
  for (const auto& [a, b] : edges_) lengths.push_back((rest_[a] - rest_[b]).norm());
  usual_radius_ = lengths.empty() ? 0.0 : std::max(kUsualRadius * findMedian(std::move(lengths)), 2.0 * thickness);
  findCrossed();
}

void PairList::keepWhole(const std::vector<char>& is_whole) {
  is_whole_ = is_whole;
  is_edge_whole_.assign(edges_.size(), 0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (!is_whole[t]) continue;
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      const std::array<Index, 2> edge{std::min(a, b), std::max(a, b)};
      is_edge_whole_[std::lower_bound(edges_.begin(), edges_.end(), edge) - edges_.begin()] = 1;
    }
  }
  reference_.clear();
}

void PairList::findCrossed() {
  std::vector<char> crosses(triangles_.size(), 0);
  for (const auto& edge : edges_) {
    const Vec3 &p = rest_[edge[0]], &q = rest_[edge[1]];
    triangle_tree_.visitMeeting(boundOf(rest_, edge), [&](Index t) {
      const Triangle& v = triangles_[t];
      const bool are_joined = std::any_of(v.begin(), v.end(), [&](Index i) { return i == edge[0] || i == edge[1]; });
      if (are_joined || !pierces(p, q, rest_[v[0]], rest_[v[1]], rest_[v[2]])) return;
      if (std::none_of(crosses.begin(), crosses.end(), [](char c) { return c != 0; })) first_crossing_ = 0.5 * (p + q);
      crosses[t] = 1;
      for (const Index e : edge)
        for (const Index i : v) crossed_.push_back({std::min(e, i), std::max(e, i)});
    });
  }
  std::sort(crossed_.begin(), crossed_.end());
  crossed_.erase(std::unique(crossed_.begin(), crossed_.end()), crossed_.end());
  num_crossed_ = std::count(crosses.begin(), crosses.end(), char{1});
}

void PairList::measureWays(const Points& positions) {
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < positions.size(); ++i) mean += positions[i] - reference_[i];
  mean /= static_cast<double>(positions.size());
  largest_way_ = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    way_[i] = (positions[i] - reference_[i] - mean).norm();
    largest_way_ = std::max(largest_way_, way_[i]);
  }
}

void PairList::update(const Points& positions, double reach) {
  if (edges_.empty()) return;
  if (!reference_.empty()) {
    measureWays(positions);
    if (reach + 2.0 * largest_way_ <= radius_) return;
  }
  search(positions, std::max(usual_radius_, kSpare * reach));
}

bool PairList::isAnyIn(const std::vector<std::array<Index, 2>>& couples, const Pair& pair) {
  for (int v = 0; v < pair.numFirst(); ++v)
    for (int w = pair.numFirst(); w < 4; ++w) {
      const Index i = pair.vertices[v], j = pair.vertices[w];
      if (std::binary_search(couples.begin(), couples.end(), std::array<Index, 2>{std::min(i, j), std::max(i, j)})) return true;
    }
  return false;
}

void PairList::offer(const Points& positions, double radius, Pair pair, std::vector<std::pair<Pair, double>>& found) const {
  const double squared = findClosest(pair, positions).squaredDistance();
  if (!(squared < radius * radius) || (!crossed_.empty() && isAnyIn(crossed_, pair))) return;
  const double at_rest = std::sqrt(findClosest(pair, rest_).squaredDistance());
  pair.thickness = std::min(thickness_, kOfRest * at_rest);
  if (kOfRestJoined * at_rest < thickness_ && isAnyIn(edges_, pair)) pair.thickness = kOfRestJoined * at_rest;
  if (pair.thickness > 0.0) found.emplace_back(pair, std::sqrt(squared));
}

void PairList::search(const Points& positions, double radius) {
  ++num_searches_;
  const Index n = static_cast<Index>(positions.size()), num_edges = static_cast<Index>(edges_.size());
  // No box meets an empty one.
  const auto isWhole = [](const std::vector<char>& marks, std::size_t i) { return marks.empty() || marks[i] != 0; };
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    triangle_boxes_[t] = isWhole(is_whole_, t) ? boundOf(positions, triangles_[t]) : Box();
  for (Index e = 0; e < num_edges; ++e) edge_boxes_[e] = isWhole(is_edge_whole_, e) ? boundOf(positions, edges_[e]) : Box();
  triangle_tree_.refit(triangle_boxes_);
  edge_tree_.refit(edge_boxes_);
  std::vector<std::vector<std::pair<Pair, double>>> blocks((n + kBlock - 1) / kBlock + (num_edges + kBlock - 1) / kBlock);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      triangle_tree_.visitMeeting(grow(Box(positions[v]), radius), [&](Index t) {
        const auto& [a, b, c] = triangles_[t];
        if (v != a && v != b && v != c) offer(positions, radius, {{v, a, b, c}, false, 0.0}, blocks[begin / kBlock]);
      });
    }
  });
  parallelFor(num_edges, kBlock, [&](Index begin, Index end) {
    auto& block = blocks[(n + kBlock - 1) / kBlock + begin / kBlock];
    for (Index e = begin; e < end; ++e) {
      if (!isWhole(is_edge_whole_, e)) continue;
      const auto& [a, b] = edges_[e];
      edge_tree_.visitMeeting(grow(edge_boxes_[e], radius), [&](Index f) {
        const auto& [c, d] = edges_[f];
        if (f > e && a != c && a != d && b != c && b != d) offer(positions, radius, {{a, b, c, d}, true, 0.0}, block);
      });
    }
  });
  pairs_.clear();
  distance_.clear();
  for (const auto& block : blocks) {
    for (const auto& [pair, distance] : block) {
      pairs_.push_back(pair);
      distance_.push_back(distance);
    }
  }
  reference_ = positions;
  radius_ = radius;
  way_.assign(n, 0.0);
  largest_way_ = 0.0;
}

}  // namespace deformable_surface::contact
