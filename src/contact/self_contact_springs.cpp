// The springs between near parts, and their damping.
#include "deformable_surface/contact/pad.h"
#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::contact {
namespace {

// A spring that hardens does so from this share of the depth at kLeast on. From this share of the remainder on, where it is some
// hundred times as strong, it goes on linearly.
constexpr double kSoft = 0.5, kHardest = 0.98;
// Of the thickness: the depth from which on a spring that hardens is damped in full. A force that sets in at once has no balance.
constexpr double kDamped = 0.1;
// All springs at a point together are damped three times as strongly as one alone, in shares of critical damping. Largest excess
// of energy of ten runs in which needles press four layers: 0.4 %; four times as strongly: 0.03 %, with longer runs; twice and
// once: 5.5 and 3.6 % (six runs); each by its own: 1.4 %.
constexpr double kTogether = 3.0;
// Squared sine of the angle below which edges count as nearly parallel: 12 degrees.
constexpr double kParallel = 0.04;
// Share of a pad that crossing edges bear, and the area of one crossing over that of a vertex: 3 edges to a vertex, which meet at
// random angles.
constexpr double kOfEdges = 0.5, kPerCrossing = 0.151;

}  // namespace

void SelfContact::addToMatrix(const Near& near, const Mat3& block, BlockSparse& matrix) {
  for (int v = 0; v < 4; ++v)
    for (int w = 0; w <= v; ++w)
      matrix.add(near.pair.vertices[v], near.pair.vertices[w], near.closest.weight[v] * near.closest.weight[w] * block);
}

// The closest points of nearly parallel edges leap as these turn, and with them the force. Their vertices meet triangles, too. So
// their share vanishes as they become parallel, with a continuous derivative [Li 2020, sec. 4.5].
double SelfContact::weigh(const Pair& pair, const Points& positions) const {
  if (!params_.hardens || !pair.is_edges) return 1.0;
  const auto& v = pair.vertices;
  const Vec3 a = positions[v[1]] - positions[v[0]], b = positions[v[3]] - positions[v[2]];
  const double c = a.cross(b).squaredNorm() / (kParallel * a.squaredNorm() * b.squaredNorm());
  return c < 1.0 ? c * (2.0 - c) : 1.0;
}

// Minus the energy times the derivative of the weight. With A = |a|^2, B = |b|^2: c = (1 - (a b)^2 / (A B)) / kParallel.
void SelfContact::addTurning(const Near& near, const Points& positions, Points& forces) const {
  if (!(near.weight > 0.0)) return;
  const auto& v = near.pair.vertices;
  const Vec3 a = positions[v[1]] - positions[v[0]], b = positions[v[3]] - positions[v[2]];
  const double squared_a = a.squaredNorm(), squared_b = b.squaredNorm(), product = a.dot(b);
  const double c = a.cross(b).squaredNorm() / (kParallel * squared_a * squared_b);
  const double factor =
      findSpring(near).energy / near.weight * (2.0 - 2.0 * c) * 2.0 * product / (kParallel * squared_a * squared_b);
  const Vec3 on_a = factor * (b - product / squared_a * a), on_b = factor * (a - product / squared_b * b);
  forces[v[1]] += on_a;
  forces[v[0]] -= on_a;
  forces[v[3]] += on_b;
  forces[v[2]] -= on_b;
}

SelfContact::Damping SelfContact::findDamping(const Near& near) const {
  if (!params_.hardens) return {params_.damping, 0.0};
  const double full = kDamped * near.pair.thickness, depth = near.pair.thickness - near.distance;
  const double damping = params_.damping * near.weight;
  return depth < full ? Damping{damping * depth / full, damping / full} : Damping{damping, 0.0};
}

double SelfContact::findOpening(const Near& near, const Points& velocities) {
  const Vec3 normal = near.closest.gap / near.distance;
  double speed = 0.0;
  for (int v = 0; v < 4; ++v) speed += near.closest.weight[v] * normal.dot(velocities[near.pair.vertices[v]]);
  return speed;
}

// Linear; where it hardens plus the barrier -y^2 ln(1 - y) [Li 2020, eq. 6], here of the share y of the depth beyond a soft part.
SelfContact::Spring SelfContact::findSpring(const Near& near) const {
  const double depth = near.pair.thickness - near.distance;
  if (!(depth > 0.0)) return {0.0, 0.0, 0.0};
  const double k = near.weight * near.stiffness;
  Spring spring{0.5 * k * depth * depth, k * depth, k};
  const double deepest = (1.0 - kLeast) * near.pair.thickness, soft = kSoft * deepest, hard = deepest - soft;
  if (!params_.hardens || depth <= soft) return spring;
  const double y = (depth - soft) / hard, x = std::min(y, kHardest), over = y - x, rest = 1.0 - x, log = std::log(rest);
  const double slope = -2.0 * log + 4.0 * x / rest + x * x / (rest * rest), force = -2.0 * x * log + x * x / rest;
  const double scale = near.weight * penalty(near.pair) * deepest * deepest;  // no pad is thicker
  spring.energy += scale * (-x * x * log + over * (force + 0.5 * over * slope));
  spring.force += scale / hard * (force + over * slope);
  spring.stiffness += scale / (hard * hard) * slope;
  return spring;
}

double SelfContact::penalty(const Pair& pair) const {
  double least = masses_[pair.vertices[0]];
  for (const Index v : pair.vertices) least = std::min(least, masses_[v]);
  return least * params_.rate * params_.rate;
}

// The vertices on both sides and the crossing edges share a pad. All vertices of a side together stand for its whole area; how
// many edges cross, their mean number tells.
double SelfContact::stiffness(const Pair& pair) const {
  const double full = penalty(pair);
  if (!(params_.compliance > 0.0)) return full;
  const std::vector<double>& areas = params_.areas;
  const auto& v = pair.vertices;
  const double area = pair.is_edges ? kOfEdges * kPerCrossing * 0.25 * (areas[v[0]] + areas[v[1]] + areas[v[2]] + areas[v[3]])
                                    : 0.5 * (1.0 - kOfEdges) * areas[v[0]];
  return std::min(full, findPadStiffness(area, params_.compliance));
}

void SelfContact::setSpring(Near& near) const {
  near.stiffness = stiffness(near.pair);
  near.rate = params_.compliance > 0.0 ? params_.rate * std::sqrt(near.stiffness / penalty(near.pair)) : params_.rate;
}

// Springs with a point in common add up: where layers lie on each other, up to a hundred bear a point. The critical damping of
// all grows with the root of their sum. Were each damped by its own, motion in such places would be damped half critically, and
// explicit steps would have to be less than half as long. Springs that harden are for methods without this limit.
void SelfContact::findRates() {
  if (!params_.hardens) borne_.assign(masses_.size(), 0.0);
  for (Near& near : near_) {
    if (!(near.distance < near.pair.thickness)) continue;
    setSpring(near);
    if (params_.hardens || !touches(near)) continue;
    for (int v = 0; v < 4; ++v) borne_[near.pair.vertices[v]] += std::abs(near.closest.weight[v]) * near.stiffness;
  }
  if (params_.hardens) return;
  for (Near& near : near_) {
    if (!touches(near)) continue;
    double squared = near.rate * near.rate;
    for (const Index v : near.pair.vertices) squared = std::max(squared, borne_[v] / (masses_[v] * kTogether * kTogether));
    near.rate = std::sqrt(squared);
  }
}

double SelfContact::ownCompliance() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < masses_.size(); ++i)
    largest = std::max(largest, 0.5 * (1.0 - kOfEdges) * params_.areas[i] / (masses_[i] * params_.rate * params_.rate));
  return largest;
}

void SelfContact::addForces(const Points& positions, Points& forces) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    ++num_near_;
    const Pair& pair = near.pair;
    const Vec3 force = findSpring(near).force / near.distance * near.closest.gap;
    for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += near.closest.weight[v] * force;
    if (near.weight < 1.0) addTurning(near, positions, forces);
  }
}

void SelfContact::addDampingForces(const Points& positions, const Points& velocities, Points& forces) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const Pair& pair = near.pair;
    const Vec3 normal = near.closest.gap / near.distance;
    const Vec3 force = -2.0 * findDamping(near).share * near.stiffness / near.rate * findOpening(near, velocities) * normal;
    for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

double SelfContact::potential(const Points& positions) {
  double sum = 0.0;
  for (const Near& near : measure(positions)) sum += findSpring(near).energy;
  return sum;
}

void SelfContact::addStiffness(const Points& positions, const Points& velocities, double step, BlockSparse& stiffness_matrix) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    double along = findSpring(near).stiffness;
    if (step > 0.0) {
      const Damping damping = findDamping(near);
      along += 2.0 * near.stiffness / near.rate * (damping.share / step - damping.onset * findOpening(near, velocities));
    }
    const Vec3 normal = near.closest.gap / near.distance;
    addToMatrix(near, std::max(0.0, along) * normal * normal.transpose(), stiffness_matrix);
  }
}

// The absolute weights of a pair sum to two.
void SelfContact::addStiffnessBounds(const Points& positions, std::vector<double>& bounds) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    for (int v = 0; v < 4; ++v)
      bounds[near.pair.vertices[v]] += 2.0 * std::abs(near.closest.weight[v]) * findSpring(near).stiffness;
  }
}

void SelfContact::addDampingBounds(const Points& positions, std::vector<double>& bounds) {
  for (const Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const double full = 2.0 * params_.damping / near.rate * near.stiffness;
    for (int v = 0; v < 4; ++v) bounds[near.pair.vertices[v]] += 2.0 * std::abs(near.closest.weight[v]) * full;
  }
}

}  // namespace deformable_surface::contact
