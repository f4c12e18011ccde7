// The spacing of the particles and of the lattice, and bonds for each particle.
#include "deformable_surface/base/parallel.h"
#include "particle_loops.h"

#include <cmath>

namespace deformable_surface::model {
namespace {

using particles::kBlock;
using particles::kSkin;

}  // namespace

double OrientedParticles::findSpacing(double area, Index n) { return std::sqrt(2.0 * area / (std::sqrt(3.0) * n)); }

double OrientedParticles::findSpacingWithoutTension(const State& state) const {
  constexpr int kHalvings = 30;  // to a billionth
  lists_.forget();               // they then hold all within the cutoff and the skin
  if (!prepare(state)) return lattice_.spacing;
  // In a lattice larger by a factor, pairs interact as they do here at distances smaller by it.
  const auto pulls = [&](double factor) {
    return parallelSum(state.size(), kBlock, [&](Index begin, Index end) {
             double sum = 0.0;
             for (Index i = begin; i < end; ++i)
               forEachNear(i, factor * lattice_.pair.cutoff, [&](Index, double distance) {
                 const double d = distance / factor;
                 if (!(d > 0.0)) return;
                 double on, on_slope, value, slope;
                 switchOff(lattice_.pair, d, on, on_slope);
                 evaluateLennardJones(lattice_.pair, d, 1.0 / d, on, on_slope, value, slope);
                 sum += d * slope;
               });
             return sum;
           }) > 0.0;
  };
  double high = 1.0 + kSkin * lattice_.pair.distance / lattice_.pair.cutoff, low = 1.0 / high;
  if (!pulls(low) || pulls(high)) return lattice_.spacing;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (pulls(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high) * lattice_.spacing;
}

double OrientedParticles::measureSpacing(const State& state) const {
  refreshDisplay(state);
  double area = 0.0, count = 0.0;
  for (const WeightedTriangle& t : triangles_) {
    const Vec3 &a = state.positions[t.corner[0]], &b = state.positions[t.corner[1]], &c = state.positions[t.corner[2]];
    area += 0.5 * t.weight * (b - a).cross(c - a).norm();
    count += t.weight;
  }
  return count > 0.0 ? std::sqrt(4.0 * area / (std::sqrt(3.0) * count)) : 0.0;
}

void OrientedParticles::setSpacing(double spacing) {
  lattice_ = calibrateLattice(spacing, material_, params_);
  mass_ = material_.arealDensity() * lattice_.area_per_particle;
  for (NeighborList* lists : {&lists_, &partners_}) lists->setRadius(lattice_.pair.cutoff, kSkin * lattice_.pair.distance);
}

double OrientedParticles::meanBonds(const State& state) const {
  if (state.size() == 0 || !prepare(state)) return 0.0;
  if (kept_) return 2.0 * static_cast<double>(bonds_.bonds().size()) / static_cast<double>(state.size());
  const double sum = parallelSum(state.size(), kBlock, [&](Index begin, Index end) {
    double count = 0.0;
    for (Index i = begin; i < end; ++i) forEachNear(i, lattice_.pair.cutoff, [&](Index, double) { count += 1.0; });
    return count;
  });
  return sum / static_cast<double>(state.size());
}

double OrientedParticles::latticeBonds() const {
  const double most = std::pow(lattice_.pair.cutoff / lattice_.spacing, 2);
  constexpr int kFar = 6;  // rows: the longest cutoff is four distances
  int count = -1;          // without itself
  const int rows = params_.mode == ParticleMode::kPlane ? 0 : kFar;
  for (int i = -kFar; i <= kFar; ++i)
    for (int j = -rows; j <= rows; ++j) count += i * i + i * j + j * j < most;
  return count;
}

void OrientedParticles::keepOpen(const State& state, double angle, std::vector<char>& is_open) const {
  if (!prepare(state)) return is_open.assign(is_open.size(), 0);
  const double cosine = std::cos(angle);
  for (Index i = 0; i < state.size(); ++i) {
    if (!is_open[i]) continue;
    const Vec3 normal = state.orientations[i] * Vec3::UnitZ();
    // Calls take(direction, j) for each that faces the same way: the unit direction to it in the tangent plane.
    const auto forEachDirection = [&](const auto& take) {
      forEachNear(i, lattice_.pair.cutoff, [&](Index j, double) {
        if (!(normal.dot(state.orientations[j] * Vec3::UnitZ()) > 0.0)) return;
        const Vec3 line = state.positions[j] - state.positions[i], flat = line - normal.dot(line) * normal;
        if (flat.squaredNorm() > 0.0) take(Vec3(flat.normalized()), j);
      });
    };
    bool is_any = false, has_gap = false;
    forEachDirection([&](const Vec3& from, Index j) {
      is_any = true;
      if (has_gap) return;
      // None within the angle to the left of this one.
      const Vec3 left = normal.cross(from);
      bool is_free = true;
      forEachDirection([&](const Vec3& to, Index k) {
        const double along = from.dot(to), across = left.dot(to);
        if (k != j && (angle < kPi ? across >= 0.0 && along > cosine : across >= 0.0 || along < cosine)) is_free = false;
      });
      has_gap = is_free;
    });
    is_open[i] = has_gap || !is_any;
  }
}

}  // namespace deformable_surface::model
