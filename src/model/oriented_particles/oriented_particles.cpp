#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr double kSkin = 0.3;         // of the distance r0: a good trade between listing too much and listing too often
constexpr double kLinkLength = 1.3;   // of the spacing: between the first neighbours of a lattice and the second
constexpr double kLongestEdge = 1.75;  // of the spacing, of triangles: the diagonal of two lattice triangles is not a gap, a missing particle is
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
                                     const OrientedParticlesParams& params)
    : params_(params),
      lattice_(calibrateLattice(params.spacing.valueOr(spacing), material, params)),
      mass_(material.arealDensity() * lattice_.area_per_particle),
      normals_(normals),
      masses_(rest.size(), mass_),
      inertias_(rest.size(), lattice_.inertia_by_mass * mass_),
      lists_(lattice_.pair.cutoff, kSkin * lattice_.pair.distance) {}

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
  }
  state.next_id = static_cast<Index>(n);
  adopt(state);
}

void OrientedParticles::adopt(const State& state) {
  masses_.assign(state.positions.size(), mass_);
  inertias_.assign(state.positions.size(), lattice_.inertia_by_mass * mass_);
}

double OrientedParticles::coolDown(double temperature, double time) const {
  return temperature * std::exp(-params_.cooling * time);
}

// Lists and copies for this state; false if forces cannot be told.
bool OrientedParticles::prepare(const State& state) const {
  if (!lists_.update(state.positions)) return false;
  const Index n = state.size();
  packed_.places.resize(4 * static_cast<std::size_t>(n));
  packed_.normals.resize(4 * static_cast<std::size_t>(n));
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const ParticleTraits& traits = state.traits[i];
      const double share = 1.0 - traits.temperature / params_.melting;
      const double strength = share > 1.0 ? 1.0 : (share < 0.0 ? 0.0 : share);  // what is not a number stays that
      const Vec3 &p = state.positions[i], normal = normalOf(state.orientations[i]);
      Eigen::Map<Vec4>(packed_.places.data() + 4 * static_cast<std::ptrdiff_t>(i)) << p, strength;
      Eigen::Map<Vec4>(packed_.normals.data() + 4 * static_cast<std::ptrdiff_t>(i)) << normal, (traits.is_smooth ? 1.0 : 0.0);
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

void OrientedParticles::addForces(const State& state, Points& forces) const {
  torques_.assign(state.positions.size(), Vec3::Zero());
  addForcesAndTorques(state, forces, torques_);
}

void OrientedParticles::addForcesAndTorques(const State& state, Points& forces, Points& torques) const {
  if (!prepare(state)) {
    // The step is then refused, and the state stays.
    for (Vec3& f : forces) f.setConstant(kNotANumber);
    return;
  }
  const bool in_plane = params_.mode == ParticleMode::kPlane;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    gatherForces(lattice_.pair, lists_, packed_, begin, end, forces.data(), torques.data());
    for (Index i = begin; in_plane && i < end; ++i) {
      forces[i].y() = 0.0;
      torques[i].x() = torques[i].z() = 0.0;
    }
  });
  if (params_.spin > 0.0 && !in_plane) addSpinTorques(state, torques);
}

// tau = -dE/d(angle about the normal) of E = alpha x^2 z psi / a [Szeliski 1991, eq. 14] or alpha x^2 z^2 psi / a^2 [eq. 15] in
// the particle's frame, a the spacing. It acts along the normal, on the one particle alone: the surface is not moved by it.
void OrientedParticles::addSpinTorques(const State& state, Points& torques) const {
  const double spacing = lattice_.spacing, scale = params_.spin * lattice_.spin_scale;
  const bool is_signed = params_.principal == PrincipalDirection::kSigned;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Mat3 frame = state.orientations[i].toRotationMatrix();
      double sum = 0.0;
      forEachNear(i, lattice_.pair.cutoff, [&](Index j, double d) {
        const double both = packed_.normal(i)[3] * packed_.normal(j)[3];
        const double strength = std::min(packed_.place(i)[3], packed_.place(j)[3]);
        const Vec3 local = frame.transpose() * (state.positions[j] - state.positions[i]);
        double psi, slope;
        weighByDistance(lattice_.pair, d * d, psi, slope);
        const double height = local.z() / spacing;
        sum -= 2.0 * both * strength * psi * local.x() * local.y() * (is_signed ? height : height * height);
      });
      torques[i] += scale * sum * frame.col(2);
    }
  });
}

double OrientedParticles::elasticEnergy(const State& state) const {
  if (!prepare(state)) return kNotANumber;
  const double energy = parallelSum(state.size(), kBlock, [&](Index begin, Index end) {
    return gatherEnergy(lattice_.pair, lists_, packed_, begin, end);
  });
  return energy - state.size() * lattice_.energy_per_particle;
}

double OrientedParticles::findStableStep(const State& state) const {
  if (!prepare(state)) return std::numeric_limits<double>::infinity();  // the first sub-step shows what is wrong
  const double mass = mass_, inertia = lattice_.inertia_by_mass * mass_, both = std::sqrt(mass * inertia);
  const Index n = state.size(), num_blocks = (n + kBlock - 1) / kBlock;
  row_maxima_.assign(num_blocks, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    double largest = 0.0;
    for (Index i = begin; i < end; ++i) {
      double move = 0.0, turn = 0.0;
      forEachNear(i, lattice_.pair.cutoff, [&](Index j, double) {
        const PairStiffness k = boundStiffness(lattice_.pair, packed_, i, j);
        move += 2.0 * (k.x / mass + k.y / both);
        turn += 2.0 * k.y / both + k.z / inertia;
      });
      largest = std::max({largest, move, turn});
    }
    row_maxima_[begin / kBlock] = largest;
  });
  double largest = 0.0;
  for (double row : row_maxima_) largest = std::max(largest, row);
  return largest > 0.0 ? 2.0 / std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

void OrientedParticles::addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  if (!prepare(state)) return;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      forEachNear(i, lattice_.pair.cutoff,
                  [&](Index j, double) { stiffness[i] += 2.0 * boundStiffness(lattice_.pair, packed_, i, j).x; });
  });
}

void OrientedParticles::refreshDisplay(const State& state) const {
  links_.clear();
  triangles_.clear();
  if (!prepare(state)) return;
  Points normals;
  normals.reserve(state.orientations.size());
  for (const Quaternion& q : state.orientations) normals.push_back(normalOf(q));
  const double longest = kLongestEdge * lattice_.spacing;
  if (params_.mode == ParticleMode::kPlane) {
    links_ = linkChains(state.positions, normals, longest);
    return;
  }
  triangles_ = triangulateParticles(state.positions, normals, longest);
  for (Index i = 0; i < state.size(); ++i)
    forEachNear(i, kLinkLength * lattice_.spacing, [&](Index j, double) {
      if (i < j) links_.emplace_back(i, j);
    });
}

void OrientedParticles::computeAreaVectors(const State& state, Points& area_vectors) const {
  area_vectors.resize(state.positions.size());
  for (std::size_t i = 0; i < area_vectors.size(); ++i)
    area_vectors[i] = lattice_.area_per_particle * normalOf(state.orientations[i]);
}

double OrientedParticles::enclosedVolume(const State& state) const {
  double sum = 0.0;
  for (Index i = 0; i < state.size(); ++i) sum += state.positions[i].dot(normalOf(state.orientations[i]));
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
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      forEachNear(i, kLinkLength * lattice_.spacing,
                  [&](Index, double d) { strain[i] = std::max(strain[i], std::abs(d / lattice_.spacing - 1.0)); });
  });
}

std::size_t OrientedParticles::bytes() const {
  std::size_t numbers = packed_.places.capacity() + packed_.normals.capacity() + masses_.capacity() + inertias_.capacity();
  numbers += strain_.capacity() + 3 * (torques_.capacity() + normals_.capacity());
  return lists_.bytes() + numbers * sizeof(double);
}

}  // namespace deformable_surface::model
