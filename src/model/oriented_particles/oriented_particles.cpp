#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/oriented_particles/rest_shape.h"
#include "particle_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::model {
namespace {

using particles::kBlock;
using particles::kSkin;
using particles::kTurn;
using particles::normalOf;

// Of the spacing: particles that are kept apart repel below it. Far below the distance of neighbours, as side by side they are in
// one lattice; the energy of two in one place is then several times that of a bond.
constexpr double kApart = 0.5;
constexpr double kGoldenAngle = 2.399963229728653;  // rad
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// The shortest turn that takes z to a unit normal; half a turn about x for -z.
Quaternion turnFromZ(const Vec3& normal) {
  constexpr double kOpposite = 1e-12;  // of 1 + cosine: the axis is lost in rounding
  const double w = 1.0 + normal.z();
  if (!(w > kOpposite)) return {0.0, 1.0, 0.0, 0.0};
  return Quaternion(w, -normal.y(), normal.x(), 0.0).normalized();
}

}  // namespace

OrientedParticles::OrientedParticles(const Points& rest, const Points& normals, double spacing, const MaterialParams& material,
                                     const OrientedParticlesParams& params, Lists apart)
    : params_(params),
      material_(material),
      stated_spacing_(params.spacing.valueOr(spacing)),
      lattice_(calibrateLattice(stated_spacing_, material, params)),
      mass_(material.arealDensity() * lattice_.area_per_particle),
      normals_(normals),
      is_bent_(params.yield_curvature > 0.0),
      masses_(rest.size(), mass_),
      inertias_(rest.size(), lattice_.inertia_by_mass * mass_),
      lists_(lattice_.pair.cutoff, kSkin * lattice_.pair.distance, std::move(apart)),
      partners_(lists_) {}

void OrientedParticles::beginAtRest(State& state) {
  const std::size_t n = state.positions.size();
  state.orientations.resize(n);
  state.spins.assign(n, Vec3::Zero());
  state.traits.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 normal = normals_[i];
    if (params_.mode == ParticleMode::kPlane) {
      state.positions[i].y() = 0.0;
      normal.y() = 0.0;
      normal = normal.norm() > 0.0 ? Vec3(normal.normalized()) : Vec3::UnitZ();
    }
    state.orientations[i] = turnFromZ(normal);
    state.traits[i].id = state.traits[i].ancestor = static_cast<Index>(i);
    // In all directions, none of them chosen.
    if (!rest_curvatures_.empty()) state.traits[i].rest_curvature = rest_curvatures_[i];
    if (params_.axis_alignment_rate > 0.0) state.traits[i].turn = std::remainder(kGoldenAngle * static_cast<double>(i), kTurn);
  }
  state.next_id = static_cast<Index>(n);
  adopt(state);
}

void OrientedParticles::setRest(const State& state) {
  normals_.clear();
  rest_curvatures_.clear();
  for (Index i = 0; i < state.size(); ++i) {
    normals_.push_back(normalOf(state.orientations[i]));
    const Mat3 curvature = turnCurvatureToWorld(state.orientations[i], state.traits[i].rest_curvature);
    rest_curvatures_.push_back(turnCurvatureToFrame(turnFromZ(normals_.back()), curvature));
  }
}

ApartPotential OrientedParticles::apartPotential() const {
  return {std::max(0.0, findLennardJonesCurvature(lattice_.pair, lattice_.pair.distance)), kApart * lattice_.spacing};
}

void OrientedParticles::adopt(const State& state) {
  lists_.forget();
  links_.clear();
  triangles_.clear();
  is_bent_ = params_.yield_curvature > 0.0 ||
             std::any_of(state.traits.begin(), state.traits.end(),
                         [](const ParticleTraits& traits) { return !traits.rest_curvature.isZero(0.0); });
  has_bonds_ = false;
  masses_.assign(state.positions.size(), mass_);
  inertias_.assign(state.positions.size(), lattice_.inertia_by_mass * mass_);
  for (Index i = 0; kept_ && i < state.size(); ++i) {
    masses_[i] = material_.arealDensity() * areaOf(state.traits[i]);
    inertias_[i] = kept_->inertia_by_mass * masses_[i];
  }
}

double OrientedParticles::areaOf(const ParticleTraits& traits) const {
  return kept_ && traits.id < static_cast<Index>(kept_->areas.size()) ? kept_->areas[traits.id] : lattice_.area_per_particle;
}

double OrientedParticles::coolDown(double temperature, double time) const {
  return temperature * std::exp(-params_.cooling * time);
}

// Updates lists and copies for this state; false if forces cannot be computed.
bool OrientedParticles::prepare(const State& state) const {
  if (!lists_.update(state.positions, state.traits, kept_ ? ParticleCuts() : cuts_)) return false;
  if (kept_ && !has_bonds_) particles::updateBonds(*kept_, state.traits, cuts_, bonds_, links_, triangles_);
  if (kept_ && (!has_bonds_ || strangers_of_ != lists_.numRebuilds())) listStrangers();
  has_bonds_ = true;
  strangers_of_ = lists_.numRebuilds();
  const Index n = state.size();
  packed_.places.resize(4 * static_cast<std::size_t>(n));
  packed_.normals.resize(4 * static_cast<std::size_t>(n));
  packed_.curvatures.resize(is_bent_ ? 8 * static_cast<std::size_t>(n) : 0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const ParticleTraits& traits = state.traits[i];
      const double share = 1.0 - traits.temperature / params_.melting;
      const double strength = share > 1.0 ? 1.0 : (share < 0.0 ? 0.0 : share);  // NaN stays NaN
      const Vec3 &p = state.positions[i], normal = normalOf(state.orientations[i]);
      Eigen::Map<Vec4>(packed_.places.data() + 4 * static_cast<std::ptrdiff_t>(i)) << p, strength;
      Eigen::Map<Vec4>(packed_.normals.data() + 4 * static_cast<std::ptrdiff_t>(i)) << normal, (traits.is_smooth ? 1.0 : 0.0);
      if (!is_bent_) continue;
      const Mat3 k = turnCurvatureToWorld(state.orientations[i], traits.rest_curvature);
      double* const row = packed_.curvatures.data() + 8 * static_cast<std::ptrdiff_t>(i);
      Eigen::Map<Eigen::Matrix<double, 8, 1>>(row) << k(0, 0), k(1, 1), k(2, 2), k(1, 2), k(0, 2), k(0, 1), 0.0, 0.0;
    }
  });
  return true;
}

void OrientedParticles::addForces(const State& state, Points& forces) const {
  torques_.assign(state.positions.size(), Vec3::Zero());
  addForcesAndTorques(state, forces, torques_);
}

void OrientedParticles::addForcesAndTorques(const State& state, Points& forces, Points& torques) const {
  if (!prepare(state)) {
    // The step is then refused, and the state restored.
    for (Vec3& f : forces) f.setConstant(kNotANumber);
    return;
  }
  const bool in_plane = params_.mode == ParticleMode::kPlane;
  if (kept_) bonds_.addForces(packed_, forces, torques);
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    if (kept_) {
      for (Index i = begin; i < end; ++i)
        forEachStranger(i, [&](Index j, double d, double c) {
          if (d > 0.0) forces[i] -= 2.0 * apartPotential().stiffness * (c - d) / d * (state.positions[j] - state.positions[i]);
        });
      gatherApart(apartPotential(), lists_, packed_, begin, end, forces.data());
      return;
    }
    gatherForces(lattice_.pair, lists_, packed_, begin, end, forces.data(), torques.data());
    gatherContact(lattice_.pair, lists_, packed_, begin, end, forces.data());
    gatherApart(apartPotential(), lists_, packed_, begin, end, forces.data());
    for (Index i = begin; in_plane && i < end; ++i) {
      forces[i].y() = 0.0;
      torques[i].x() = torques[i].z() = 0.0;
    }
  });
}

void OrientedParticles::leaveOnlyAttraction() {
  lattice_.pair.co_planarity = lattice_.pair.co_normality = lattice_.pair.co_circularity = 0.0;
}

double OrientedParticles::elasticEnergy(const State& state) const {
  if (!prepare(state)) return kNotANumber;
  if (kept_) {
    return bonds_.findEnergy(packed_) + parallelSum(state.size(), kBlock, [&](Index begin, Index end) {
             double sum = gatherApartEnergy(apartPotential(), lists_, packed_, begin, end);
             for (Index i = begin; i < end; ++i)
               forEachStranger(i,
                               [&](Index, double d, double c) { sum += 0.5 * apartPotential().stiffness * (c - d) * (c - d); });
             return sum;
           });
  }
  const double energy = parallelSum(state.size(), kBlock, [&](Index begin, Index end) {
    return gatherEnergy(lattice_.pair, lists_, packed_, begin, end) +
           gatherContactEnergy(lattice_.pair, lists_, packed_, begin, end) +
           gatherApartEnergy(apartPotential(), lists_, packed_, begin, end);
  });
  return energy - state.size() * lattice_.energy_per_particle;
}

std::size_t OrientedParticles::bytes() const {
  std::size_t numbers = masses_.capacity() + inertias_.capacity() + strain_.capacity();
  for (const std::vector<double>* packed : {&packed_.places, &packed_.normals, &packed_.curvatures})
    numbers += packed->capacity();
  for (const std::vector<double>* rows : {&row_maxima_, &row_bounds_, &weights_, &products_}) numbers += rows->capacity();
  const std::size_t vectors = torques_.capacity() + normals_.capacity() + rest_curvatures_.capacity();
  const std::size_t indices = strangers_.capacity() + stranger_begins_.capacity() + touching_.capacity() +
                              touch_numbers_.capacity() + touch_begins_.capacity();
  return lists_.bytes() + partners_.bytes() + cuts_.bytes() + bonds_.bytes() + (kept_ ? kept_->bytes() : 0) +
         numbers * sizeof(double) + indices * sizeof(Index) + vectors * sizeof(Vec3) + has_flowed_.capacity() +
         touches_.capacity() * sizeof(std::pair<Index, double>) + links_.capacity() * sizeof(std::pair<Index, Index>) +
         triangles_.capacity() * sizeof(WeightedTriangle);
}

}  // namespace deformable_surface::model
