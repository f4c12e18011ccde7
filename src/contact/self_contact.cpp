#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::contact {
namespace {

// Of a pair's thickness: nearer than that nothing comes on its own.
constexpr double kLeast = 0.5;
// Of the room between a pair that its points may use up in one step: less than all, so that rounding crosses nothing.
constexpr double kOfRoom = 0.9;
// Of a pair's thickness: parts as near as that may touch soon, however slow they are.
constexpr double kWatched = 1.5;
constexpr int kCollisions = 4;  // passes
constexpr int kPasses = 2;      // of shortening by planes, before ways are scaled

}  // namespace

SelfContact::SelfContact(Points rest, const std::vector<Triangle>& triangles, std::vector<double> masses,
                         const SelfContactParams& params)
    : list_(std::move(rest), triangles, params.thickness), masses_(std::move(masses)), params_(params) {}

bool SelfContact::touches(const Near& near) { return near.distance < near.pair->thickness && near.distance > 0.0; }

void SelfContact::addToMatrix(const Near& near, const Mat3& block, BlockSparse& matrix) {
  for (int v = 0; v < 4; ++v)
    for (int w = 0; w <= v; ++w)
      matrix.add(near.pair->vertices[v], near.pair->vertices[w], near.closest.weight[v] * near.closest.weight[w] * block);
}

// Pairs nearer than reach, or than the thickness.
const std::vector<SelfContact::Near>& SelfContact::measure(const Points& positions, double reach) {
  reach = std::max(reach, list_.thickness());
  if (reach <= measured_reach_ && positions == measured_at_) return near_;
  list_.update(positions, reach);
  near_.clear();
  list_.visitNear(reach, [&](const Pair& pair) {
    const Closest closest = findClosest(pair, positions);
    const double squared = closest.squaredDistance();
    if (squared < reach * reach) near_.push_back({&pair, closest, std::sqrt(squared)});
  });
  measured_at_ = positions;
  measured_reach_ = reach;
  return near_;
}

bool SelfContact::mayTouch(const Points& positions, const Points& velocities, double time) {
  for (const Near& near : measure(positions, list_.usualReach())) {
    const Pair& pair = *near.pair;
    double fastest = 0.0;  // of one primitive as seen from the other
    for (int v = 0; v < pair.numFirst(); ++v)
      for (int w = pair.numFirst(); w < 4; ++w)
        fastest = std::max(fastest, (velocities[pair.vertices[v]] - velocities[pair.vertices[w]]).squaredNorm());
    if (near.distance - time * std::sqrt(fastest) < kWatched * pair.thickness) return true;
  }
  return false;
}

double SelfContact::stiffness(const Pair& pair) const {
  double least = masses_[pair.vertices[0]];
  for (const Index v : pair.vertices) least = std::min(least, masses_[v]);
  return least * params_.rate * params_.rate;
}

void SelfContact::addForces(const Points& positions, Points& forces) {
  for (const Near& near : measure(positions, 0.0)) {
    const Pair& pair = *near.pair;
    const double depth = pair.thickness - near.distance;
    if (!(depth > 0.0) || !(near.distance > 0.0)) continue;
    const Vec3 force = stiffness(pair) * depth / near.distance * near.closest.gap;
    for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

void SelfContact::addDampingForces(const Points& positions, const Points& velocities, Points& forces) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Pair& pair = *near.pair;
    const Vec3 normal = near.closest.gap / near.distance;
    double speed = 0.0;
    for (int v = 0; v < 4; ++v) speed += near.closest.weight[v] * normal.dot(velocities[pair.vertices[v]]);
    const Vec3 force = -2.0 * params_.damping * stiffness(pair) / params_.rate * speed * normal;
    for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

double SelfContact::potential(const Points& positions) {
  double sum = 0.0;
  for (const Near& near : measure(positions, 0.0)) {
    const Pair& pair = *near.pair;
    const double depth = pair.thickness - near.distance;
    if (depth > 0.0) sum += 0.5 * stiffness(pair) * depth * depth;
  }
  return sum;
}

void SelfContact::addStiffness(const Points& positions, double step, BlockSparse& stiffness_matrix) {
  const double damping = step > 0.0 ? 2.0 * params_.damping / (params_.rate * step) : 0.0;
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Pair& pair = *near.pair;
    const Vec3 normal = near.closest.gap / near.distance;
    addToMatrix(near, (1.0 + damping) * stiffness(pair) * normal * normal.transpose(), stiffness_matrix);
  }
}

void SelfContact::addRowBounds(const Points& positions, std::vector<double>& stiffness_bounds, std::vector<double>& damping) {
  for (const Near& near : measure(positions, 0.0)) {
    const Pair& pair = *near.pair;
    if (!(near.distance < pair.thickness)) continue;
    // The weights sum to two in size.
    for (int v = 0; v < 4; ++v) {
      const double share = 2.0 * std::abs(near.closest.weight[v]) * stiffness(pair);
      stiffness_bounds[pair.vertices[v]] += share;
      damping[pair.vertices[v]] += 2.0 * params_.damping / params_.rate * share;
    }
  }
}

SelfContact::Rub SelfContact::findRub(const Near& near, const Points& positions, const std::vector<PairAnchor>& anchors) const {
  const Pair& pair = *near.pair;
  const double spring = stiffness(pair), limit = params_.friction * spring * (pair.thickness - near.distance);
  const FrictionLaw law{limit, limit, spring, 2.0 * params_.damping * spring / params_.rate};
  const Vec3 normal = near.closest.gap / near.distance;
  const auto at = std::lower_bound(anchors.begin(), anchors.end(), pair,
                                   [](const PairAnchor& a, const Pair& p) { return a.isBefore(p.vertices, p.is_edges); });
  if (at == anchors.end() || at->is_edges != pair.is_edges || at->vertices != pair.vertices)
    return {law, normal, Vec3::Zero(), false, nullptr};
  Vec3 moved = -at->offset;
  for (int v = 0; v < 4; ++v) moved += at->weight[v] * positions[pair.vertices[v]];
  return {law, normal, moved - moved.dot(normal) * normal, at->slides, &*at};
}

Vec3 SelfContact::findSliding(const Near& near, const Points& velocities) {
  Vec3 relative = Vec3::Zero();
  for (int v = 0; v < 4; ++v) relative += near.closest.weight[v] * velocities[near.pair->vertices[v]];
  const Vec3 normal = near.closest.gap / near.distance;
  return relative - relative.dot(normal) * normal;
}

void SelfContact::addFriction(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                              Points& forces) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const Vec3 force = rub.law.findForce(rub.stretch, findSliding(near, velocities), rub.slides);
    for (int v = 0; v < 4; ++v) forces[near.pair->vertices[v]] += near.closest.weight[v] * force;
  }
}

double SelfContact::frictionEnergy(const Points& positions, const std::vector<PairAnchor>& anchors) {
  double sum = 0.0;
  if (anchors.empty()) return sum;
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const double force = std::min(rub.law.stiffness * rub.stretch.norm(), rub.law.static_limit);
    sum += 0.5 * force * force / rub.law.stiffness;
  }
  return sum;
}

void SelfContact::addFrictionStiffness(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                                       double step, BlockSparse& stiffness_matrix) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const double share = rub.law.findShare(rub.stretch, findSliding(near, velocities), rub.slides);
    const double along = share * ((rub.anchor ? rub.law.stiffness : 0.0) + rub.law.damping / step);
    addToMatrix(near, along * (Mat3::Identity() - rub.normal * rub.normal.transpose()), stiffness_matrix);
  }
}

void SelfContact::moveAnchors(const Points& positions, const Points& velocities, std::vector<PairAnchor>& anchors) {
  next_.clear();
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    Vec3 stretch = rub.stretch;
    const bool slides = rub.law.slide(stretch, findSliding(near, velocities), rub.slides);
    if (rub.anchor && !slides) {
      next_.push_back(*rub.anchor);
      next_.back().slides = false;
    } else {
      const Pair& pair = *near.pair;
      next_.push_back({pair.vertices, pair.is_edges, near.closest.weight, near.closest.gap - stretch, slides});
    }
  }
  std::sort(next_.begin(), next_.end(),
            [](const PairAnchor& a, const PairAnchor& b) { return a.isBefore(b.vertices, b.is_edges); });
  anchors = next_;
}

// The plane across the gap separates two convex primitives. As long as the points of each stay on its side, the two never meet.
// Each side may use up its share of the room between them beyond kLeast.
SelfContact::Plane SelfContact::makePlane(const Near& near, const Points& before) const {
  const Pair& pair = *near.pair;
  const double share = 0.5 * kOfRoom * std::max(0.0, near.distance - kLeast * pair.thickness);
  Plane plane;
  plane.vertices = pair.vertices;
  plane.weight = near.closest.weight;
  plane.normal = near.closest.gap / near.distance;
  plane.share = share;
  for (int v = 0; v < 4; ++v) {
    const bool is_first = v < pair.numFirst();
    plane.towards[v] = (is_first ? -1.0 : 1.0) * plane.normal;
    // How far the point is behind the closest point of its primitive.
    double behind = 0.0;
    for (int w = 0; w < 4; ++w)
      if ((w < pair.numFirst()) == is_first)
        behind += std::abs(near.closest.weight[w]) * plane.towards[v].dot(before[pair.vertices[w]] - before[pair.vertices[v]]);
    plane.room[v] = std::max(0.0, behind) + share;
  }
  return plane;
}

// Pairs that would use up more than their room exchange momentum until they do not, one after the other: plastic impacts, which
// take energy. No point gets farther than the farthest would have: pairs that were not looked at stay apart.
void SelfContact::collide(const Points& before, const Points& after, double farthest) {
  for (int pass = 0; pass < kCollisions; ++pass) {
    for (const Plane& plane : planes_) {
      double approach = 0.0, mobility = 0.0;
      for (int v = 0; v < 4; ++v) {
        const Index i = plane.vertices[v];
        approach -= plane.weight[v] * plane.normal.dot(ways_[i]);
        if (after[i] != before[i]) mobility += plane.weight[v] * plane.weight[v] / masses_[i];
      }
      if (!(approach > 2.0 * plane.share) || !(mobility > 0.0)) continue;
      const double momentum = (approach - 2.0 * plane.share) / mobility;
      for (int v = 0; v < 4; ++v) {
        const Index i = plane.vertices[v];
        if (after[i] == before[i]) continue;
        ways_[i] += momentum * plane.weight[v] / masses_[i] * plane.normal;
        is_cut_[i] = 1;
      }
    }
  }
  for (Vec3& way : ways_)
    if (way.squaredNorm() > farthest) way *= std::sqrt(farthest / way.squaredNorm());
}

const std::vector<Index>& SelfContact::limit(const Points& before, Points& after) {
  const Index n = static_cast<Index>(before.size());
  cut_.clear();
  // A way that all share brings nothing nearer.
  Vec3 shared = Vec3::Zero();
  bool does_one_stay = false;
  for (Index i = 0; i < n; ++i) {
    shared += after[i] - before[i];
    does_one_stay = does_one_stay || after[i] == before[i];
  }
  if (does_one_stay) shared.setZero();
  shared /= static_cast<double>(n);
  ways_.resize(n);
  double farthest = 0.0;
  for (Index i = 0; i < n; ++i) {
    ways_[i] = after[i] - before[i] - shared;
    farthest = std::max(farthest, ways_[i].squaredNorm());
  }
  // Pairs that are farther apart cannot use up their room.
  const double reach = kLeast * list_.thickness() + 2.0 / kOfRoom * std::sqrt(farthest);
  planes_.clear();
  for (const Near& near : measure(before, reach))
    if (near.distance < reach && near.distance > 0.0) planes_.push_back(makePlane(near, before));
  if (planes_.empty()) return cut_;
  is_cut_.assign(n, 0);
  collide(before, after, farthest);
  wanted_ = ways_;
  for (int pass = 0; pass <= kPasses; ++pass) {
    for (const Plane& plane : planes_) {
      for (int v = 0; v < 4; ++v) {
        const Index i = plane.vertices[v];
        const double nearing = plane.towards[v].dot(ways_[i]);
        if (!(nearing > plane.room[v])) continue;
        is_cut_[i] = 1;
        if (pass < kPasses) {
          ways_[i] -= (nearing - plane.room[v]) * plane.towards[v];
        } else {
          ways_[i] *= plane.room[v] / nearing;
        }
      }
    }
  }
  for (Index i = 0; i < n; ++i) {
    if (is_cut_[i] == 0) continue;
    // Several planes after another may squeeze a point out between them: what stops it would then do work on it.
    const double gained = ways_[i].squaredNorm() - wanted_[i].dot(ways_[i]);
    if (gained > 0.0) ways_[i] *= std::max(0.0, 1.0 - gained / ways_[i].squaredNorm());
    after[i] = before[i] + shared + ways_[i];
    cut_.push_back(i);
  }
  return cut_;
}

std::vector<SelfContactForce> SelfContact::listForces(const Points& positions) {
  std::vector<SelfContactForce> list;
  for (const Near& near : measure(positions, 0.0)) {
    const Pair& pair = *near.pair;
    const double depth = pair.thickness - near.distance;
    if (depth > 0.0) list.push_back({pair, near.closest, stiffness(pair) * depth});
  }
  return list;
}

double SelfContact::leastDistance(const Points& positions) {
  double least = std::numeric_limits<double>::infinity();
  for (const Near& near : measure(positions, 0.0))
    if (near.distance < near.pair->thickness) least = std::min(least, near.distance);
  return least;
}

}  // namespace deformable_surface::contact
