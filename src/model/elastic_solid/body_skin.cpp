#include "deformable_surface/model/elastic_solid/body_skin.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/geometry/convex_cell.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 64;    // points per task: a millisecond or so
constexpr double kFar = 1e4;    // times the farthest neighbour: a corner as far away belongs to no cell
constexpr double kSame = 1e-7;  // of a corner's distance: its copies, one per facet, differ by rounding
constexpr int kStars = 3;       // that a facet belongs to

using Corners = std::array<Index, 3>;

// The facets at one point. The Voronoi cell of the point has a corner at the middle of each Delaunay cell. Its edges belong to
// the facets: an edge with one end outside is a facet of the skin.
class Star {
 public:
  Star(const Points& points, const Lists& neighbors) : points_(points), neighbors_(neighbors) {}

  void findSkin(Index i, double empty, std::vector<Corners>& skin);

 private:
  struct Edge {
    Vec3 outside, within;  // m, its ends
    Index neighbor;        // of one of the two faces beside it
  };

  const Points& points_;
  const Lists& neighbors_;
  geometry::ConvexCell cell_;
  std::vector<Edge> edges_;  // with one end outside, once for each face
};

void Star::findSkin(Index i, double empty, std::vector<Corners>& skin) {
  const Index* const first = neighbors_.begin(i);
  const Index count = neighbors_.count(i);
  double reach = 0.0;
  for (Index k = 0; k < count; ++k) reach = std::max(reach, (points_[first[k]] - points_[i]).norm());
  if (!(reach > 0.0)) return;
  cell_.reset(kFar * reach);
  for (Index k = 0; k < count; ++k) {
    const Vec3 d = points_[first[k]] - points_[i];
    cell_.cut(d, 0.5 * d.squaredNorm(), k);
  }
  edges_.clear();
  cell_.visitFacets([&](int label, const Vec3* begin, const Vec3* end) {
    if (label < 0) return;
    for (const Vec3* at = begin; at != end; ++at) {
      const Vec3& next = at + 1 == end ? *begin : *(at + 1);
      const bool is_outside = at->norm() > empty, is_next_outside = next.norm() > empty;
      if (is_outside == is_next_outside) continue;
      edges_.push_back(is_outside ? Edge{*at, next, first[label]} : Edge{next, *at, first[label]});
    }
  });
  const auto areSame = [](const Vec3& a, const Vec3& b) { return (a - b).norm() <= kSame * a.norm(); };
  for (std::size_t e = 0; e < edges_.size(); ++e)
    for (std::size_t f = e + 1; f < edges_.size(); ++f) {
      if (!areSame(edges_[e].outside, edges_[f].outside) || !areSame(edges_[e].within, edges_[f].within)) continue;
      Index a = edges_[e].neighbor, b = edges_[f].neighbor;
      const Vec3 normal = (points_[a] - points_[i]).cross(points_[b] - points_[i]);
      if (normal.dot(edges_[e].outside - edges_[e].within) < 0.0) std::swap(a, b);
      // The smallest index first.
      Corners corner{i, a, b};
      std::rotate(corner.begin(), std::min_element(corner.begin(), corner.end()), corner.end());
      skin.push_back(corner);
    }
}

}  // namespace

std::vector<WeightedTriangle> findBodySkin(const Points& points, const Lists& neighbors, const std::vector<double>& empty) {
  const Index n = neighbors.size();
  std::vector<std::vector<Corners>> found(n > 0 ? (n - 1) / kBlock + 1 : 0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Star star(points, neighbors);
    for (Index i = begin; i < end; ++i) star.findSkin(i, empty[i], found[begin / kBlock]);
  });
  std::vector<Corners> all;
  for (const std::vector<Corners>& block : found) all.insert(all.end(), block.begin(), block.end());
  std::sort(all.begin(), all.end());
  std::vector<WeightedTriangle> triangles;
  for (auto t = all.begin(); t != all.end();) {
    const auto next = std::find_if(t, all.end(), [&](const Corners& other) { return other != *t; });
    triangles.push_back({{(*t)[0], (*t)[1], (*t)[2]}, static_cast<double>(next - t) / kStars});
    t = next;
  }
  return triangles;
}

}  // namespace deformable_surface::model
