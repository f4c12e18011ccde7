#include "contact_skin.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "overlaps.h"
#include "skin_holes.h"
#include "triangles_beneath.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kAlone = 0.99;  // weight of a triangle whose Delaunay cell holds no other

struct Edge {
  Index from, to;
  std::size_t triangle;
};

// Drops the triangles at the longer of two edges that cross within the surface, triangles that hold a point of others, and of two
// neighbours that pass through each other the larger.
void dropOverlaps(const Points& rest, std::vector<contact::Triangle>& triangles) {
  std::vector<Edge> edges;
  std::vector<contact::Box> boxes;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      edges.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t});
      contact::Box box(rest[edges.back().from]);
      boxes.push_back(box.extend(rest[edges.back().to]));
    }
  const contact::BoxTree tree(boxes), triangle_tree(listBoxes(rest, triangles));
  const auto lengthOf = [&](const Edge& e) { return (rest[e.to] - rest[e.from]).norm(); };
  std::vector<char> is_dropped(triangles.size(), 0);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge& one = edges[e];
    const double length = lengthOf(one);
    const Vec3 margin = Vec3::Constant(kOverlap * length);
    tree.visitMeeting({boxes[e].min() - margin, boxes[e].max() + margin}, [&](Index f) {
      const Edge& other = edges[f];
      if (lengthOf(other) < length || is_dropped[one.triangle] || is_dropped[other.triangle]) return;
      if (doEdgesOverlap(rest, one.from, one.to, other.from, other.to)) is_dropped[other.triangle] = 1;
    });
  }
  // A point within a triangle that is covered by the triangles of its own neighbours.
  for (Index p = 0; p < static_cast<Index>(rest.size()); ++p)
    triangle_tree.visitMeeting(contact::Box(rest[p]), [&](Index f) {
      const contact::Triangle& t = triangles[f];
      if (!hasCorner(t, p) && liesOn(rest, p, t)) is_dropped[f] = 1;
    });
  // On rough surfaces overlapping triangles pass through each other. Only those with a common vertex: others may be two layers,
  // which keep their contact.
  const auto size = [&](const contact::Triangle& t) {
    return (rest[t[1]] - rest[t[0]]).norm() + (rest[t[2]] - rest[t[1]]).norm() + (rest[t[0]] - rest[t[2]]).norm();
  };
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge& edge = edges[e];
    triangle_tree.visitMeeting(boxes[e], [&](Index f) {
      const contact::Triangle &own = triangles[edge.triangle], &other = triangles[f];
      if (is_dropped[edge.triangle] || is_dropped[f]) return;
      if (std::none_of(own.begin(), own.end(), [&](Index v) { return hasCorner(other, v); })) return;
      if (passesThrough(rest, edge.from, edge.to, other)) is_dropped[size(own) > size(other) ? edge.triangle : f] = 1;
    });
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (is_dropped[t] == 0) triangles[kept++] = triangles[t];
  triangles.resize(kept);
}

std::vector<contact::Triangle> listCorners(const std::vector<model::WeightedTriangle>& triangles) {
  std::vector<contact::Triangle> corners;
  corners.reserve(triangles.size());
  for (const model::WeightedTriangle& t : triangles) corners.push_back({t.corner[0], t.corner[1], t.corner[2]});
  return corners;
}

// By four places of each triangle of the model.
double findShareWithout(const Points& rest, const std::vector<model::WeightedTriangle>& given,
                        const std::vector<contact::Triangle>& triangles) {
  const TrianglesBeneath skin(rest, triangles);
  const std::set<contact::Triangle> chosen(triangles.begin(), triangles.end());
  double whole = 0.0, without = 0.0;
  contact::Triangle beneath;
  for (const model::WeightedTriangle& triangle : given) {
    const contact::Triangle t{triangle.corner[0], triangle.corner[1], triangle.corner[2]};
    const double area = triangle.weight * findNormal(rest, t).norm();
    whole += area;
    if (chosen.count(t) > 0) continue;
    for (const Vec3& place : listPlaces(rest, t))
      if (!skin.find(t, place, beneath)) without += 0.25 * area;
  }
  return whole > 0.0 ? without / whole : 0.0;
}

}  // namespace

// A triangle that would traverse an edge in the same direction as another one overlaps it.
std::vector<contact::Triangle> chooseTriangulation(const std::vector<model::WeightedTriangle>& triangles) {
  std::vector<contact::Triangle> chosen;
  std::set<std::pair<Index, Index>> taken;
  for (const bool takes_shared : {false, true}) {
    for (const model::WeightedTriangle& triangle : triangles) {
      if ((triangle.weight < kAlone) != takes_shared) continue;
      const contact::Triangle t{triangle.corner[0], triangle.corner[1], triangle.corner[2]};
      const auto overlaps = [&](int k) { return taken.count({t[k], t[(k + 1) % 3]}) > 0; };
      if (overlaps(0) || overlaps(1) || overlaps(2)) continue;
      for (int k = 0; k < 3; ++k) taken.emplace(t[k], t[(k + 1) % 3]);
      chosen.push_back(t);
    }
  }
  return chosen;
}

ContactSkin::ContactSkin(const Points& rest, const std::vector<model::WeightedTriangle>& given)
    : triangles(chooseTriangulation(given)) {
  dropOverlaps(rest, triangles);
  const std::vector<contact::Triangle> surface = listCorners(given);
  for (const Filling& filling : fillHoles(rest, triangles, surface)) {
    triangles.push_back(filling.triangle);
    beneath_.push_back(filling.beneath);
  }
  share_without = findShareWithout(rest, given, triangles);
}

std::vector<char> ContactSkin::findWhole(const std::vector<model::WeightedTriangle>& now) const {
  std::vector<contact::Triangle> present = listCorners(now);
  std::sort(present.begin(), present.end());
  const auto isPresent = [&](const contact::Triangle& t) { return std::binary_search(present.begin(), present.end(), t); };
  std::vector<char> is_whole;
  is_whole.reserve(triangles.size());
  for (auto t = triangles.begin(); t != triangles.end() - beneath_.size(); ++t) is_whole.push_back(isPresent(*t));
  for (const auto& beneath : beneath_) is_whole.push_back(std::all_of(beneath.begin(), beneath.end(), isPresent));
  return is_whole;
}

}  // namespace deformable_surface::simulation
