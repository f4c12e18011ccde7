// Friction between parts that touch.
#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "find_place.h"

namespace deformable_surface::contact {
namespace {

void addTo(Points& forces, const Pair& pair, const Closest& closest, const Vec3& force) {
  for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += closest.weight[v] * force;
}

}  // namespace

const PairAnchor* SelfContact::findAnchor(Near& near, const std::vector<PairAnchor>& anchors, Index guess) {
  const Pair& pair = near.pair;
  near.place = findPlace(anchors, pair, near.place < 0 ? guess : near.place,
                         [](const PairAnchor& a, const Pair& p) { return a.isBefore(p.vertices, p.is_edges); });
  if (near.place == static_cast<Index>(anchors.size())) return nullptr;
  const PairAnchor& anchor = anchors[near.place];
  return anchor.is_edges == pair.is_edges && anchor.vertices == pair.vertices ? &anchor : nullptr;
}

SelfContact::Rub SelfContact::findRub(const Near& near, const Points& positions, const PairAnchor* anchor) const {
  const double pressing = findSpring(near).force;
  const FrictionLaw law{params_.friction * pressing, params_.kinetic_friction * pressing, near.stiffness,
                        2.0 * params_.damping * near.stiffness / near.rate};
  const Vec3 normal = near.closest.gap / near.distance;
  if (!anchor) return {law, normal, Vec3::Zero(), 0.0, nullptr};
  Vec3 moved = -anchor->offset;
  for (int v = 0; v < 4; ++v) moved += anchor->weight[v] * positions[near.pair.vertices[v]];
  return {law, normal, moved - moved.dot(normal) * normal, anchor->slid, anchor};
}

// Pairs that follow each other in the lists have parts in common, and their anchors are near each other.
template <class Visit>
void SelfContact::forEachRub(const Points& positions, const std::vector<PairAnchor>& anchors, const Visit& visit) {
  Index last = 0;
  for (Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const PairAnchor* const anchor = findAnchor(near, anchors, last);
    last = near.place;
    visit(near, findRub(near, positions, anchor));
  }
}

Vec3 SelfContact::findSliding(const Near& near, const Points& velocities) {
  Vec3 relative = Vec3::Zero();
  for (int v = 0; v < 4; ++v) relative += near.closest.weight[v] * velocities[near.pair.vertices[v]];
  const Vec3 normal = near.closest.gap / near.distance;
  return relative - relative.dot(normal) * normal;
}

void SelfContact::addFriction(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                              Points& forces) {
  forEachRub(positions, anchors, [&](const Near& near, const Rub& rub) {
    addTo(forces, near.pair, near.closest, rub.law.findForce(rub.stretch, findSliding(near, velocities), rub.slid));
  });
}

void SelfContact::addFrictionAtRest(const Points& positions, const std::vector<PairAnchor>& anchors, Points& forces) {
  if (anchors.empty()) return;
  forEachRub(positions, anchors, [&](const Near& near, const Rub& rub) {
    if (rub.anchor) addTo(forces, near.pair, near.closest, rub.law.findForce(rub.stretch, Vec3::Zero(), rub.slid));
  });
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
    const Rub rub = findRub(near, positions, &anchor);
    sum += rub.law.storedEnergy(rub.stretch);
  }
  return sum;
}

void SelfContact::addFrictionStiffness(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                                       double step, BlockSparse& stiffness_matrix) {
  forEachRub(positions, anchors, [&](const Near& near, const Rub& rub) {
    const double share = rub.law.findShare(rub.stretch, findSliding(near, velocities), rub.slid);
    const double along = share * ((rub.anchor ? rub.law.stiffness : 0.0) + (step > 0.0 ? rub.law.damping / step : 0.0));
    addToMatrix(near, along * (Mat3::Identity() - rub.normal * rub.normal.transpose()), stiffness_matrix);
  });
}

// Most pairs touch on: their anchors are in order already.
void SelfContact::moveAnchors(const Points& positions, const Points& velocities, double step, std::vector<PairAnchor>& anchors) {
  is_kept_.assign(anchors.size(), 0);
  begun_.clear();
  forEachRub(positions, anchors, [&](const Near& near, const Rub& rub) {
    const Pair& pair = near.pair;
    const Vec3 sliding = findSliding(near, velocities);
    if (!rub.anchor) {
      begun_.push_back({pair.vertices, pair.is_edges, near.closest.weight, near.closest.gap, rub.law.slidAtFirst(sliding)});
      return;
    }
    is_kept_[near.place] = 1;
    PairAnchor& anchor = anchors[near.place];
    Vec3 stretch = rub.stretch;
    anchor.slid = rub.law.slide(stretch, sliding, rub.slid, step);
    if (anchor.slid == 0.0) return;
    anchor.weight = near.closest.weight;
    anchor.offset = near.closest.gap - stretch;
  });
  const auto isBefore = [](const PairAnchor& a, const PairAnchor& b) { return a.isBefore(b.vertices, b.is_edges); };
  std::sort(begun_.begin(), begun_.end(), isBefore);
  next_.clear();
  auto begun = begun_.begin();
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    if (is_kept_[k] == 0) continue;
    for (; begun != begun_.end() && isBefore(*begun, anchors[k]); ++begun) next_.push_back(*begun);
    next_.push_back(anchors[k]);
  }
  next_.insert(next_.end(), begun, begun_.end());
  anchors.swap(next_);
}

}  // namespace deformable_surface::contact
