// Friction between parts that touch.
#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::contact {

SelfContact::Rub SelfContact::findRub(const Near& near, const Points& positions, const std::vector<PairAnchor>& anchors) const {
  const Pair& pair = near.pair;
  const double pressing = findSpring(near).force;
  const FrictionLaw law{params_.friction * pressing, params_.kinetic_friction * pressing, near.stiffness,
                        2.0 * params_.damping * near.stiffness / near.rate};
  const Vec3 normal = near.closest.gap / near.distance;
  const auto at = std::lower_bound(anchors.begin(), anchors.end(), pair,
                                   [](const PairAnchor& a, const Pair& p) { return a.isBefore(p.vertices, p.is_edges); });
  if (at == anchors.end() || at->is_edges != pair.is_edges || at->vertices != pair.vertices)
    return {law, normal, Vec3::Zero(), 0.0, nullptr};
  Vec3 moved = -at->offset;
  for (int v = 0; v < 4; ++v) moved += at->weight[v] * positions[pair.vertices[v]];
  return {law, normal, moved - moved.dot(normal) * normal, at->slid, &*at};
}

Vec3 SelfContact::findSliding(const Near& near, const Points& velocities) {
  Vec3 relative = Vec3::Zero();
  for (int v = 0; v < 4; ++v) relative += near.closest.weight[v] * velocities[near.pair.vertices[v]];
  const Vec3 normal = near.closest.gap / near.distance;
  return relative - relative.dot(normal) * normal;
}

void SelfContact::addFriction(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                              Points& forces) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const Vec3 force = rub.law.findForce(rub.stretch, findSliding(near, velocities), rub.slid);
    for (int v = 0; v < 4; ++v) forces[near.pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

void SelfContact::addFrictionAtRest(const Points& positions, const std::vector<PairAnchor>& anchors, Points& forces) {
  if (anchors.empty()) return;
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    if (!rub.anchor) continue;
    const Vec3 force = rub.law.findForce(rub.stretch, Vec3::Zero(), rub.slid);
    for (int v = 0; v < 4; ++v) forces[near.pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

// Of the pairs with a place at which they stick: nothing is searched, which would be costly for positions of another time.
double SelfContact::frictionEnergy(const Points& positions, const std::vector<PairAnchor>& anchors) {
  double sum = 0.0;
  for (const PairAnchor& anchor : anchors) {
    Pair pair{anchor.vertices, anchor.is_edges, 0.0};
    pair.thickness = list_.thicknessOf(pair);
    const Closest closest = findClosest(pair, positions);
    Near near{pair, closest, std::sqrt(closest.squaredDistance()), weigh(pair, positions)};
    if (!touches(near)) continue;
    setSpring(near);
    const Rub rub = findRub(near, positions, anchors);
    sum += rub.law.storedEnergy(rub.stretch);
  }
  return sum;
}

void SelfContact::addFrictionStiffness(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                                       double step, BlockSparse& stiffness_matrix) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const double share = rub.law.findShare(rub.stretch, findSliding(near, velocities), rub.slid);
    const double along = share * ((rub.anchor ? rub.law.stiffness : 0.0) + (step > 0.0 ? rub.law.damping / step : 0.0));
    addToMatrix(near, along * (Mat3::Identity() - rub.normal * rub.normal.transpose()), stiffness_matrix);
  }
}

void SelfContact::moveAnchors(const Points& positions, const Points& velocities, double step, std::vector<PairAnchor>& anchors) {
  next_.clear();
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    Vec3 stretch = rub.stretch;
    const Vec3 sliding = findSliding(near, velocities);
    const double slid = rub.anchor ? rub.law.slide(stretch, sliding, rub.slid, step) : rub.law.slidAtFirst(sliding);
    if (rub.anchor && slid == 0.0) {
      next_.push_back(*rub.anchor);
      next_.back().slid = 0.0;
    } else {
      const Pair& pair = near.pair;
      next_.push_back({pair.vertices, pair.is_edges, near.closest.weight, near.closest.gap - stretch, slid});
    }
  }
  std::sort(next_.begin(), next_.end(),
            [](const PairAnchor& a, const PairAnchor& b) { return a.isBefore(b.vertices, b.is_edges); });
  anchors = next_;
}

}  // namespace deformable_surface::contact
