#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"
#include "deformable_surface/model/oriented_particles/rest_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr double kSkin = 0.3;      // of the distance r0: a good trade between listing too much and listing too often
constexpr double kKeptSkin = 0.6;  // the same with kept bonds, where few of those listed cost anything
// Of the spacing: particles that are kept apart repel below it. Far below the distance of neighbours, as side by side they are in
// one lattice; the energy of two in one place is then several times that of a bond.
constexpr double kApart = 0.5;
constexpr double kLinkLength = 1.3;  // of the spacing: between the first neighbours of a lattice and the second
// Of the spacing, longest edge of triangles: the diagonal of two lattice triangles is not a gap, a missing particle is.
constexpr double kLongestEdge = 1.75;
constexpr double kTurn = 6.283185307179586, kGoldenAngle = 2.399963229728653;  // rad
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

Vec3 normalOf(const Quaternion& q) {
  const double x = q.x(), y = q.y(), z = q.z(), w = q.w();
  return {2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)};
}

// The shortest turn that takes z to a unit normal; half a turn about x for -z.
Quaternion turnFromZ(const Vec3& normal) {
  constexpr double kOpposite = 1e-12;  // of 1 + cosine: the axis is lost in rounding
  const double w = 1.0 + normal.z();
  if (!(w > kOpposite)) return {0.0, 1.0, 0.0, 0.0};
  return Quaternion(w, -normal.y(), normal.x(), 0.0).normalized();
}

}  // namespace

double OrientedParticles::findSpacing(double area, Index n) { return std::sqrt(2.0 * area / (std::sqrt(3.0) * n)); }

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

void OrientedParticles::adopt(const State& state) {
  lists_.forget();
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

ParticleCuts::Pairs OrientedParticles::findBroken(const State& state) const {
  ParticleCuts::Pairs pairs;
  if (!kept_ || !prepare(state)) return pairs;
  const double most = params_.tear_strain > 0.0 ? 1.0 + params_.tear_strain : params_.cutoff;
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

// Calls take(j, d, c) for the particles to which i has no bond and that are nearer than c, m: than those of a lattice at rest, or
// than they were at rest if they were nearer or had one. They repel with the energy of ApartPotential.
template <class Take>
void OrientedParticles::forEachStranger(Index i, const Take& take) const {
  const Eigen::Map<const Vec3> p(packed_.place(i));
  const double most = lattice_.pair.distance;
  for (Index k = stranger_begins_[i]; k < stranger_begins_[i + 1]; ++k) {
    const Index j = strangers_[k];
    const double squared = (Eigen::Map<const Vec3>(packed_.place(j)) - p).squaredNorm();
    if (!(squared < most * most)) continue;
    const double d = std::sqrt(squared), c = std::min(most, bonds_.restDistance(i, j));
    if (d < c) take(j, d, c);
  }
}

void OrientedParticles::setCuts(const ParticleCuts& cuts) {
  if (cuts_.isSameAs(cuts)) return;
  cuts_ = cuts;
  has_bonds_ = false;
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

double OrientedParticles::coolDown(double temperature, double time) const {
  return temperature * std::exp(-params_.cooling * time);
}

// Updates lists and copies for this state; false if forces cannot be computed.
bool OrientedParticles::prepare(const State& state) const {
  if (!lists_.update(state.positions, state.traits, kept_ ? ParticleCuts() : cuts_)) return false;
  if (kept_ && !has_bonds_) bonds_.update(*kept_, state.traits, cuts_);
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

template <class Take>
void OrientedParticles::forEachNear(Index i, double distance, const Take& take) const {
  const Eigen::Map<const Vec3> p(packed_.place(i));
  for (const Index* j = lists_.begin(i); j != lists_.end(i); ++j) {
    const double d = (Eigen::Map<const Vec3>(packed_.place(*j)) - p).norm();
    if (d < distance) take(*j, d);
  }
}

template <class Take>
void OrientedParticles::forEachParted(Index i, const Take& take) const {
  const Eigen::Map<const Vec3> p(packed_.place(i));
  for (const Index* j = lists_.beginParted(i); j != lists_.endParted(i); ++j)
    take((Eigen::Map<const Vec3>(packed_.place(*j)) - p).norm());
}

// Calls add(i, k) with the bounds k of the stiffness of every pair of each particle i of begin .. end - 1, in ascending order of
// its neighbours. The bounds are the same from both sides: pairs within that range are evaluated once.
template <class Add>
void OrientedParticles::addStiffness(Index begin, Index end, const Add& add) const {
  for (Index i = begin; i < end; ++i)
    for (const Index* j = lists_.begin(i); j != lists_.end(i) && *j < begin; ++j)
      add(i, boundStiffness(lattice_.pair, packed_, i, *j));
  for (Index i = begin; i < end; ++i)
    for (const Index* j = std::upper_bound(lists_.begin(i), lists_.end(i), i); j != lists_.end(i); ++j) {
      const PairStiffness k = boundStiffness(lattice_.pair, packed_, i, *j);
      add(i, k);
      if (*j < end) add(*j, k);
    }
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

// E = sum psi x^2 z / a^3 [Szeliski 1991, eq. 14] or psi x^2 z^2 / a^4 [eq. 15] over the neighbours, x = X cos t + Y sin t in the
// frame turned by t, a the spacing: up to a constant it is -G cos 2(t - t0). With dt/dtime = -rate dE/dt, tan(t - t0) falls as
// exp(-4 rate G time).
void OrientedParticles::turnAxes(double time, State& state) const {
  if (!(params_.axis_alignment_rate > 0.0) || params_.mode == ParticleMode::kPlane || !prepare(state)) return;
  const double inverse = 1.0 / lattice_.spacing;
  const bool is_signed = params_.principal == PrincipalDirection::kSigned;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Mat3 to_frame = inverse * state.orientations[i].conjugate().toRotationMatrix();
      double even = 0.0, odd = 0.0;  // E = even cos 2t + odd sin 2t
      forEachNear(i, lattice_.pair.cutoff, [&](Index j, double d) {
        const Vec3 r = to_frame * (state.positions[j] - state.positions[i]);
        double psi, slope;
        weighByDistance(lattice_.pair, d * d, psi, slope);
        const double weight = packed_.normal(j)[3] * psi * (is_signed ? r.z() : r.z() * r.z());
        even += 0.5 * weight * (r.x() * r.x() - r.y() * r.y());
        odd += weight * r.x() * r.y();
      });
      const double target = 0.5 * std::atan2(-odd, -even), off = state.traits[i].turn - target;
      const double kept = std::exp(-4.0 * params_.axis_alignment_rate * std::hypot(even, odd) * packed_.normal(i)[3] * time);
      // The nearer of the two directions of the axis.
      const double side = std::cos(off) < 0.0 ? -1.0 : 1.0;
      const double left = std::atan2(side * std::sin(off) * kept, side * std::cos(off));
      state.traits[i].turn = std::remainder(target + (side < 0.0 ? 0.5 * kTurn : 0.0) + left, kTurn);
    }
  });
}

// From the neighbours within the cutoff that face the same way, weighted by their bonds.
std::optional<Vec3> OrientedParticles::fitCurvature(const State& state, Index i) const {
  const Eigen::Map<const Vec3> normal(packed_.normal(i));
  CurvatureFit fit(state.orientations[i]);
  forEachNear(i, lattice_.pair.cutoff, [&](Index j, double d) {
    const Eigen::Map<const Vec3> other(packed_.normal(j));
    if (!(other.dot(normal) > 0.0)) return;
    double psi, slope;
    weighByDistance(lattice_.pair, d * d, psi, slope);
    const double weight = packed_.normal(j)[3] * std::min(packed_.place(i)[3], packed_.place(j)[3]) * psi;
    fit.add(weight, state.positions[j] - state.positions[i], other - normal);
  });
  return fit.solve();
}

void OrientedParticles::keepShape(State& state) const {
  if (!prepare(state)) return;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (!state.traits[i].is_smooth) continue;
      const std::optional<Vec3> curvature = fitCurvature(state, i);
      if (!curvature) continue;
      const PrincipalCurvatures principal = findPrincipalCurvatures(*curvature);
      const double most = lattice_.spacing * std::max(std::abs(principal.larger), std::abs(principal.smaller));
      state.traits[i].rest_curvature = *curvature / std::max(1.0, most);
    }
  });
}

void OrientedParticles::smoothShape(Index times, State& state) const {
  if (!prepare(state)) return;
  std::vector<Mat3> curvatures(state.positions.size());
  for (; times > 0; --times) {
    for (Index i = 0; i < state.size(); ++i)
      curvatures[i] = turnCurvatureToWorld(state.orientations[i], state.traits[i].rest_curvature);
    parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        if (!state.traits[i].is_smooth) continue;
        const Vec3 normal = normalOf(state.orientations[i]);
        Mat3 sum = curvatures[i];
        double count = 1.0;
        forEachNear(i, lattice_.pair.cutoff, [&](Index j, double) {
          const Vec3 other = normalOf(state.orientations[j]);
          if (!state.traits[j].is_smooth || !(other.dot(normal) > 0.0)) return;
          const Mat3 along = Quaternion::FromTwoVectors(other, normal).toRotationMatrix();
          sum += along * curvatures[j] * along.transpose();
          count += 1.0;
        });
        state.traits[i].rest_curvature = turnCurvatureToFrame(state.orientations[i], sum / count);
      }
    });
  }
}

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

void OrientedParticles::leaveOnlyAttraction() {
  lattice_.pair.co_planarity = lattice_.pair.co_normality = lattice_.pair.co_circularity = 0.0;
}

void OrientedParticles::setSpacing(double spacing) {
  lattice_ = calibrateLattice(spacing, material_, params_);
  mass_ = material_.arealDensity() * lattice_.area_per_particle;
  for (NeighborList* lists : {&lists_, &partners_}) lists->setRadius(lattice_.pair.cutoff, kSkin * lattice_.pair.distance);
}

bool OrientedParticles::flow(State& state) const {
  if (!(params_.yield_curvature > 0.0) || !prepare(state)) return false;
  has_flowed_.assign(state.positions.size(), 0);
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (!state.traits[i].is_smooth) continue;
      const std::optional<Vec3> curvature = fitCurvature(state, i);
      if (!curvature) continue;
      const Vec3 rest = flowToYield(state.traits[i].rest_curvature, *curvature, params_.yield_curvature);
      has_flowed_[i] = rest != state.traits[i].rest_curvature;
      state.traits[i].rest_curvature = rest;
    }
  });
  return std::find(has_flowed_.begin(), has_flowed_.end(), 1) != has_flowed_.end();
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

double OrientedParticles::findStableStep(const State& state) const {
  if (!prepare(state)) return std::numeric_limits<double>::infinity();  // the first sub-step reports the problem
  const double mass = mass_, inertia = lattice_.inertia_by_mass * mass_, both = std::sqrt(mass * inertia);
  const Index n = state.size(), num_blocks = (n + kBlock - 1) / kBlock;
  const ApartPotential apart = apartPotential();
  if (kept_) {
    row_bounds_.assign(n, 0.0);
    addKeptBounds(kept_->inertia_by_mass, row_bounds_);
    const double most = parallelMax(n, kBlock, [&](Index begin, Index end) {
      double largest = 0.0;
      for (Index i = begin; i < end; ++i) largest = std::max(largest, row_bounds_[i] / masses_[i]);
      return largest;
    });
    return most > 0.0 ? 2.0 / std::sqrt(most) : std::numeric_limits<double>::infinity();
  }
  row_maxima_.assign(num_blocks, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    double largest = 0.0, moves[kBlock] = {}, turns[kBlock] = {};
    addStiffness(begin, end, [&](Index i, const PairStiffness& k) {
      moves[i - begin] += 2.0 * (k.x / mass + k.y / both);
      turns[i - begin] += 2.0 * k.y / both + k.z / inertia;
    });
    for (Index i = begin; i < end; ++i) {
      double move = moves[i - begin];
      forEachParted(i, [&](double d) { move += 2.0 * boundContactStiffness(lattice_.pair, d) / mass; });
      move += countApart(apart, lists_, packed_, i) * 4.0 * apart.stiffness / mass;
      largest = std::max({largest, move, turns[i - begin]});
    }
    row_maxima_[begin / kBlock] = largest;
  });
  double largest = 0.0;
  for (double row : row_maxima_) largest = std::max(largest, row);
  return largest > 0.0 ? 2.0 / std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

void OrientedParticles::addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  if (!prepare(state)) return;
  // Normals that do not turn have an infinite inertia.
  if (kept_) return addKeptBounds(std::numeric_limits<double>::infinity(), stiffness);
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    addStiffness(begin, end, [&](Index i, const PairStiffness& k) { stiffness[i] += 2.0 * k.x; });
    for (Index i = begin; i < end; ++i)
      forEachParted(i, [&](double d) { stiffness[i] += 2.0 * boundContactStiffness(lattice_.pair, d); });
    if (!lists_.hasApart()) return;
    const ApartPotential apart = apartPotential();
    for (Index i = begin; i < end; ++i) stiffness[i] += 4.0 * apart.stiffness * countApart(apart, lists_, packed_, i);
  });
}

// Of kept bonds and of the repulsion of strangers; as PresentBonds::addRowBounds().
void OrientedParticles::addKeptBounds(double inertia_by_mass, std::vector<double>& bounds) const {
  bonds_.addRowBounds(packed_, inertia_by_mass, bounds);
  const ApartPotential apart = apartPotential();
  parallelFor(static_cast<Index>(bounds.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      forEachStranger(i, [&](Index, double, double) { bounds[i] += 4.0 * apart.stiffness; });
      if (lists_.hasApart()) bounds[i] += 4.0 * apart.stiffness * countApart(apart, lists_, packed_, i);
    }
  });
}

void OrientedParticles::refreshDisplay(const State& state) const {
  links_.clear();
  triangles_.clear();
  if (!prepare(state)) return;
  if (kept_) {
    for (const KeptBonds::Bond& bond : bonds_.bonds()) links_.emplace_back(std::min(bond.i, bond.j), std::max(bond.i, bond.j));
    triangles_ = bonds_.triangles();
    return;
  }
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

std::size_t OrientedParticles::bytes() const {
  std::size_t numbers = masses_.capacity() + inertias_.capacity() + strain_.capacity();
  for (const std::vector<double>* packed : {&packed_.places, &packed_.normals, &packed_.curvatures})
    numbers += packed->capacity();
  for (const std::vector<double>* rows : {&row_maxima_, &row_bounds_}) numbers += rows->capacity();
  const std::size_t vectors = torques_.capacity() + normals_.capacity() + rest_curvatures_.capacity();
  const std::size_t indices = strangers_.capacity() + stranger_begins_.capacity();
  return lists_.bytes() + partners_.bytes() + cuts_.bytes() + bonds_.bytes() + (kept_ ? kept_->bytes() : 0) +
         numbers * sizeof(double) + indices * sizeof(Index) + vectors * sizeof(Vec3) + has_flowed_.capacity() +
         links_.capacity() * sizeof(std::pair<Index, Index>) + triangles_.capacity() * sizeof(WeightedTriangle);
}

}  // namespace deformable_surface::model
