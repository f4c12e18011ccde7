// The surface that particles stand for: triangles and links to show, areas, volume and strain.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"
#include "particle_loops.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

using particles::kBlock;
using particles::kLinkLength;
using particles::normalOf;

// Of the spacing, longest edge of triangles: the diagonal of two lattice triangles is not a gap, a missing particle is.
constexpr double kLongestEdge = 1.75;

}  // namespace

void OrientedParticles::refreshDisplay(const State& state) const {
  const bool is_known = prepare(state);
  if (kept_) return;  // they follow the bonds
  links_.clear();
  triangles_.clear();
  if (!is_known) return;
  Points normals;
  normals.reserve(state.orientations.size());
  for (const Quaternion& q : state.orientations) normals.push_back(normalOf(q));
  const double longest = kLongestEdge * lattice_.spacing;
  AreApart apart;
  if (!cuts_.isEmpty()) apart = [&](Index i, Index j) { return !cuts_.mayBind(state.traits[i].id, state.traits[j].id); };
  if (params_.mode == ParticleMode::kPlane) {
    links_ = linkChains(state.positions, normals, longest, apart);
    return;
  }
  triangles_ = triangulateParticles(state.positions, normals, longest, apart);
  for (Index i = 0; i < state.size(); ++i)
    forEachNear(i, kLinkLength * lattice_.spacing, [&](Index j, double) {
      if (i < j) links_.emplace_back(i, j);
    });
}

void OrientedParticles::computeAreaVectors(const State& state, Points& area_vectors) const {
  area_vectors.resize(state.positions.size());
  for (std::size_t i = 0; i < area_vectors.size(); ++i)
    area_vectors[i] = areaOf(state.traits[i]) * normalOf(state.orientations[i]);
}

double OrientedParticles::enclosedVolume(const State& state) const {
  double sum = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    const double share = kept_ ? areaOf(state.traits[i]) / lattice_.area_per_particle : 1.0;
    sum += share * state.positions[i].dot(normalOf(state.orientations[i]));
  }
  return sum * lattice_.area_per_particle / 3.0;
}

void OrientedParticles::computeVolumeGradient(const State& state, Points& gradient) const {
  computeAreaVectors(state, gradient);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& g : gradient) mean += g / static_cast<double>(gradient.size());
  for (Vec3& g : gradient) g -= mean;
}

double OrientedParticles::maxStretch(const State& state) const {
  computePointStrain(state, strain_);
  double largest = 0.0;
  for (double strain : strain_) largest = std::max(largest, strain);
  return largest;
}

void OrientedParticles::computePointStrain(const State& state, std::vector<double>& strain) const {
  strain.assign(state.positions.size(), 0.0);
  if (!prepare(state)) return;
  if (kept_) {
    for (const KeptBonds::Bond& bond : bonds_.bonds()) {
      const double longer = std::abs((state.positions[bond.j] - state.positions[bond.i]).norm() / bond.length - 1.0);
      for (const Index i : {bond.i, bond.j}) strain[i] = std::max(strain[i], longer);
    }
    return;
  }
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      forEachNear(i, kLinkLength * lattice_.spacing,
                  [&](Index, double d) { strain[i] = std::max(strain[i], std::abs(d / lattice_.spacing - 1.0)); });
  });
}

}  // namespace deformable_surface::model
