// Which particles bind each other: kept bonds, layers, strangers, and cuts.
#include "deformable_surface/base/parallel.h"
#include "particle_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::model {
namespace {

using particles::normalOf;
using particles::updateBonds;

constexpr Index kBondBlock = 2048;  // some microseconds of work
constexpr double kKeptSkin = 0.6;   // of the distance r0, with kept bonds, where few of those listed cost anything

}  // namespace

void OrientedParticles::keepLayers(const State& state) {
  constexpr double kBeside = 0.5;  // of the distance: nearer to both tangent planes, a pair is side by side
  const Lists& apart = lists_.apart();
  std::vector<double> ranges;
  ranges.reserve(apart.items.size());
  for (Index i = 0; i < apart.size(); ++i) {
    const Vec3 normal = normalOf(state.orientations[i]);
    for (const Index* j = apart.begin(i); j != apart.end(i); ++j) {
      const Vec3 other = normalOf(state.orientations[*j]), r = state.positions[*j] - state.positions[i];
      const double d = r.norm(), height = std::max(std::abs(normal.dot(r)), std::abs(other.dot(r)));
      const bool is_beside = normal.dot(other) > 0.0 && height <= kBeside * d;
      ranges.push_back(is_beside ? std::numeric_limits<double>::infinity() : d);
    }
  }
  if (ranges.empty()) return;
  for (NeighborList* lists : {&lists_, &partners_}) lists->setApartRanges(ranges);
}

void OrientedParticles::keepBonds(const State& state, const std::vector<WeightedTriangle>& triangles, std::vector<double> areas) {
  const auto kept = std::make_shared<KeptBonds>(state, triangles, std::move(areas), material_, params_);
  kept_ = kept;
  // Strangers repel below r0. Axes see all within the cutoff.
  const double radius = params_.axis_alignment_rate > 0.0 ? lattice_.pair.cutoff : lattice_.pair.distance;
  for (NeighborList* lists : {&lists_, &partners_}) lists->setRadius(radius, kKeptSkin * lattice_.pair.distance);
  adopt(state);
  if (!prepare(state)) return;
  for (Index i = 0; i < state.size(); ++i)
    forEachStranger(i, [&](Index j, double d, double) {
      if (i < j) kept->close.push_back({i, j, d});
    });
  has_bonds_ = false;
  // Those that are kept apart repel where they come nearer than they are, and not at all along a bond.
  const Lists& apart = lists_.apart();
  std::vector<double> ranges;
  ranges.reserve(apart.items.size());
  for (Index i = 0; i < apart.size(); ++i)
    for (const Index* j = apart.begin(i); j != apart.end(i); ++j)
      ranges.push_back(bonds_.areBound(i, *j) ? 0.0 : (state.positions[*j] - state.positions[i]).norm());
  if (ranges.empty()) return;
  for (NeighborList* lists : {&lists_, &partners_}) lists->setApartRanges(ranges);
}

ParticleCuts::Pairs OrientedParticles::findCrossed(const State& state,
                                                   const std::function<bool(Index, Index)>& is_crossed) const {
  ParticleCuts::Pairs pairs;
  if (!kept_ || !prepare(state)) return pairs;
  for (const KeptBonds::Bond& bond : bonds_.bonds()) {
    if (!is_crossed(bond.i, bond.j)) continue;
    const Index a = state.traits[bond.i].id, b = state.traits[bond.j].id;
    pairs.emplace_back(std::min(a, b), std::max(a, b));
  }
  return pairs;
}

// Of a kept bond, times its length at rest.
double OrientedParticles::mostStretch() const { return params_.tear_strain > 0.0 ? 1.0 + params_.tear_strain : params_.cutoff; }

bool OrientedParticles::isAnyStretched(const State& state) const {
  if (!kept_) return false;
  if (!has_bonds_) updateBonds(*kept_, state.traits, cuts_, bonds_, links_, triangles_);
  const std::vector<KeptBonds::Bond>& bonds = bonds_.bonds();
  const double most = mostStretch();
  return parallelMax(static_cast<Index>(bonds.size()), kBondBlock, [&](Index begin, Index end) {
           double beyond = 0.0;
           for (Index k = begin; k < end; ++k) {
             const KeptBonds::Bond& bond = bonds[k];
             beyond = std::max(beyond, (state.positions[bond.j] - state.positions[bond.i]).squaredNorm() -
                                           most * most * bond.length * bond.length);
           }
           return beyond;
         }) > 0.0;
}

ParticleCuts::Pairs OrientedParticles::findBroken(const State& state) const {
  ParticleCuts::Pairs pairs;
  if (!kept_ || !prepare(state)) return pairs;
  const double most = mostStretch();
  for (const KeptBonds::Bond& bond : bonds_.bonds()) {
    const ParticleTraits &i = state.traits[bond.i], &j = state.traits[bond.j];
    const bool is_molten = std::max(i.temperature, j.temperature) >= params_.melting;
    const double squared = (state.positions[bond.j] - state.positions[bond.i]).squaredNorm();
    if (!is_molten && squared <= most * most * bond.length * bond.length) continue;
    pairs.emplace_back(std::min(i.id, j.id), std::max(i.id, j.id));
  }
  return pairs;
}

// The listed pairs that have no bond.
void OrientedParticles::listStrangers() const {
  stranger_begins_.clear();
  strangers_.clear();
  for (Index i = 0; i < static_cast<Index>(masses_.size()); ++i) {
    stranger_begins_.push_back(static_cast<Index>(strangers_.size()));
    for (const Index* j = lists_.begin(i); j != lists_.end(i); ++j)
      if (!bonds_.areBound(i, *j)) strangers_.push_back(*j);
  }
  stranger_begins_.push_back(static_cast<Index>(strangers_.size()));
}

void OrientedParticles::setCuts(const ParticleCuts& cuts) {
  if (cuts_.isSameAs(cuts)) return;
  cuts_ = cuts;
  has_bonds_ = false;
  if (kept_) return;  // lists do not know of cut bonds
  lists_.forget();
  partners_.forget();
}

ParticleCuts::Lengths OrientedParticles::cutLengths() const {
  ParticleCuts::Lengths lengths;
  lengths.bond = lattice_.pair.cutoff;
  lengths.sight = lengths.bond + lattice_.spacing;
  // Growth still fills gaps between pairs that were bound.
  lengths.end = 1.1 * std::max(lengths.sight, params_.growth.max_gap * lattice_.spacing);
  return lengths;
}

ParticleCuts OrientedParticles::followCuts(const State& state) const {
  if (cuts_.isEmpty() || !prepare(state)) return cuts_;
  return cuts_.follow(state.positions, state.traits, lists_, cutLengths(), params_.weldingTemperature(), cut_scratch_);
}

}  // namespace deformable_surface::model
