#include "self_contact_load.h"

#include "deformable_surface/cloud/links.h"
#include "deformable_surface/simulation/model_kind.h"

#include <cmath>
#include <set>
#include <utility>

namespace deformable_surface::simulation {
namespace {

constexpr double kAlone = 0.99;  // weight of a triangle whose Delaunay cell holds no other
// Fraction of the length of the shorter edge: nearer edges without a common point belong to overlapping triangles.
constexpr double kOverlap = 0.05;
constexpr double kOfSpacing = 0.2;  // thickness of the skin of a solid, which has none of its own

struct Edge {
  Index from, to;
  std::size_t triangle;
};

// Drops the triangles at the longer of two edges that cross within the surface, triangles that hold a point of others, and of two
// neighbours that pass through each other the larger.
void dropOverlaps(const Points& rest, std::vector<contact::Triangle>& triangles) {
  std::vector<Edge> edges;
  std::vector<contact::Box> boxes, triangle_boxes;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    contact::Box whole;
    for (int k = 0; k < 3; ++k) {
      edges.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t});
      contact::Box box(rest[edges.back().from]);
      boxes.push_back(box.extend(rest[edges.back().to]));
      whole.extend(box);
    }
    const double margin = kOverlap * whole.diagonal().norm();
    triangle_boxes.emplace_back(whole.min() - Vec3::Constant(margin), whole.max() + Vec3::Constant(margin));
  }
  const contact::BoxTree tree(boxes), triangle_tree(triangle_boxes);
  const auto lengthOf = [&](const Edge& e) { return (rest[e.to] - rest[e.from]).norm(); };
  std::vector<char> is_dropped(triangles.size(), 0);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge& one = edges[e];
    const double length = lengthOf(one);
    const Vec3 margin = Vec3::Constant(kOverlap * length);
    tree.visitMeeting({boxes[e].min() - margin, boxes[e].max() + margin}, [&](Index f) {
      const Edge& other = edges[f];
      const bool are_joined = one.from == other.from || one.from == other.to || one.to == other.from || one.to == other.to;
      if (are_joined || lengthOf(other) < length || is_dropped[one.triangle] || is_dropped[other.triangle]) return;
      const contact::Closest closest =
          contact::findClosestOfEdges(rest[one.from], rest[one.to], rest[other.from], rest[other.to]);
      if (closest.squaredDistance() < kOverlap * kOverlap * length * length) is_dropped[other.triangle] = 1;
    });
  }
  // A point within a triangle that is covered by the triangles of its own neighbours.
  for (std::size_t p = 0; p < rest.size(); ++p)
    triangle_tree.visitMeeting(contact::Box(rest[p]), [&](Index f) {
      const contact::Triangle& t = triangles[f];
      if (static_cast<Index>(p) == t[0] || static_cast<Index>(p) == t[1] || static_cast<Index>(p) == t[2]) return;
      const double squared = contact::findClosestToTriangle(rest[p], rest[t[0]], rest[t[1]], rest[t[2]]).squaredDistance();
      if (squared < kOverlap * kOverlap * (rest[t[1]] - rest[t[0]]).squaredNorm()) is_dropped[f] = 1;
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
      const auto has = [&](Index v) { return std::find(other.begin(), other.end(), v) != other.end(); };
      if (is_dropped[edge.triangle] || is_dropped[f] || has(edge.from) || has(edge.to)) return;
      if (std::none_of(own.begin(), own.end(), has)) return;
      if (contact::pierces(rest[edge.from], rest[edge.to], rest[other[0]], rest[other[1]], rest[other[2]]))
        is_dropped[size(own) > size(other) ? edge.triangle : f] = 1;
    });
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (is_dropped[t] == 0) triangles[kept++] = triangles[t];
  triangles.resize(kept);
}

}  // namespace

// Neighbours on a surface traverse their common edge in opposite directions. A triangle that would traverse an edge in the same
// direction as another one overlaps it.
std::vector<contact::Triangle> chooseContactTriangles(const Points& rest, const std::vector<model::WeightedTriangle>& triangles) {
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
  dropOverlaps(rest, chosen);
  return chosen;
}

ContactSkin::ContactSkin(const Points& rest, const std::vector<model::WeightedTriangle>& given)
    : triangles(chooseContactTriangles(rest, given)) {
  const auto areaOf = [&](Index a, Index b, Index c) { return (rest[b] - rest[a]).cross(rest[c] - rest[a]).norm(); };
  double whole = 0.0, kept = 0.0;
  for (const model::WeightedTriangle& t : given) whole += t.weight * areaOf(t.corner[0], t.corner[1], t.corner[2]);
  for (const contact::Triangle& t : triangles) kept += areaOf(t[0], t[1], t[2]);
  share_without = whole > kept ? 1.0 - kept / whole : 0.0;
}

double findContactThickness(const SceneParams& params, const RestSurface& rest) {
  if (!params.contact.thickness.is_auto) return params.contact.thickness.value;
  if (findModel(params.model).traits().is_surface) return params.material.thickness;
  return kOfSpacing * std::sqrt(rest.area / static_cast<double>(rest.points.size()));
}

namespace {

// The parts that the whole triangles connect.
std::vector<Index> labelParts(Index n, const std::vector<contact::Triangle>& triangles, const std::vector<char>& is_whole) {
  std::vector<std::pair<Index, Index>> links;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!is_whole[t]) continue;
    links.emplace_back(triangles[t][0], triangles[t][1]);
    links.emplace_back(triangles[t][0], triangles[t][2]);
  }
  Index num_parts = 0;
  return cloud::labelComponents(n, links, num_parts);
}

}  // namespace

SelfContactLoads::SelfContactLoads(const Points& rest, std::shared_ptr<const ContactSkin> skin, const std::vector<double>& masses,
                                   const contact::SelfContactParams& params)
    : contact(rest, skin->triangles, masses, params),
      limit(contact, labelParts(static_cast<Index>(rest.size()), skin->triangles, std::vector<char>(skin->triangles.size(), 1))),
      skin_(std::move(skin)),
      is_whole_(skin_->triangles.size(), 1),
      rubs_(params.friction > 0.0) {}

void SelfContactLoads::followTriangles(const std::vector<model::WeightedTriangle>& now) {
  std::vector<contact::Triangle> present;
  present.reserve(now.size());
  for (const model::WeightedTriangle& t : now) present.push_back({t.corner[0], t.corner[1], t.corner[2]});
  std::sort(present.begin(), present.end());
  std::vector<char> is_whole;
  is_whole.reserve(skin_->triangles.size());
  for (const contact::Triangle& t : skin_->triangles) is_whole.push_back(std::binary_search(present.begin(), present.end(), t));
  if (is_whole == is_whole_) return;
  is_whole_ = std::move(is_whole);
  contact.keepWhole(is_whole_);
  limit.setParts(labelParts(static_cast<Index>(limit.parts().size()), skin_->triangles, is_whole_));
}

void SelfContactLoads::setMemory(const Memory& memory) {
  may_act_ = memory.may_act;
  contact.setProven(memory.proven);
}

// Where the loads do not act, the limit still does: parts that come faster than predicted are stopped, not bounced.
bool SelfContactLoads::beginStep(const model::State& state, double step, bool untangles) {
  limit.forgetStopped();
  const bool may_act = contact.mayTouch(state.positions, state.velocities, step);
  const bool pushes = untangles && contact.beginPushing(state.positions);
  const bool has_changed = pushes != pushes_ || may_act != may_act_;
  may_act_ = may_act;
  pushes_ = pushes;
  return has_changed;
}

void SelfContactLoads::followCrossings(const Points& positions) {
  contact.findCrossed(positions);
  contact.endPushing();
  pushes_ = false;
}

}  // namespace deformable_surface::simulation
