#include "deformable_surface/model/oriented_particles/kept_bonds.h"

#include "deformable_surface/base/parallel.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace deformable_surface::model {
namespace {

using Bond = KeptBonds::Bond;
using Triangle = KeptBonds::Triangle;

constexpr Index kBlock = 256, kGone = -1;

bool isBefore(const KeptBonds::Close& a, const KeptBonds::Close& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); }

// C of plane stress: stiffness is E h, or D (1 - nu^2).
Mat3 findPlaneStress(double stiffness, double poisson) {
  Mat3 c = Mat3::Zero();
  c(0, 0) = c(1, 1) = 1.0;
  c(0, 1) = c(1, 0) = poisson;
  c(2, 2) = 0.5 * (1.0 - poisson);
  return stiffness / (1.0 - poisson * poisson) * c;
}

// The strength of a triangle or bond: that of its weakest particle, and whether all are smooth.
template <std::size_t kCount>
void findStrength(const PackedParticles& particles, const Index (&corners)[kCount], double& strength, double& smooth) {
  strength = smooth = 1.0;
  for (const Index i : corners) {
    strength = std::min(strength, particles.place(i)[3]);
    smooth *= particles.normal(i)[3];
  }
  smooth *= strength;
}

}  // namespace

KeptBonds::KeptBonds(const State& rest, const std::vector<WeightedTriangle>& corners, std::vector<double> given_areas,
                     const MaterialParams& material, const OrientedParticlesParams& params)
    : areas(std::move(given_areas)), inertia_by_mass(material.thickness * material.thickness / 12.0) {
  const Points& x = rest.positions;
  const double poisson = material.bendingPoissonRatio(), weight = 0.5 * (params.co_planarity + params.co_normality);
  const double beam = weight * material.bendingRigidity() * (1.0 - poisson * poisson);
  const double membrane = params.lennard_jones * material.young_modulus * material.thickness;
  const Mat3 stretching = findPlaneStress(membrane, material.poisson_ratio), bending = findPlaneStress(beam, poisson);
  std::map<std::pair<Index, Index>, Index> numbers;
  for (const WeightedTriangle& t : corners) {
    Triangle triangle;
    triangle.corners = t;
    const Vec3 first = x[t.corner[1]] - x[t.corner[0]], across = first.cross(x[t.corner[2]] - x[t.corner[0]]);
    const Vec3 along = first.normalized(), up = across.normalized().cross(along);
    const double area = 0.5 * t.weight * across.norm();
    Mat3 directions;
    for (int a = 0; a < 3; ++a) {
      const auto ends = std::minmax(t.corner[a], t.corner[(a + 1) % 3]);
      const auto [found, is_new] = numbers.try_emplace(ends, static_cast<Index>(bonds.size()));
      const Vec3 r = x[ends.second] - x[ends.first];
      const double l = r.norm(), c = r.dot(along) / l, s = r.dot(up) / l;
      directions.row(a) << c * c, s * s, c * s;
      triangle.bond[a] = found->second;
      if (is_new) {
        const double ui = r.dot(rest.orientations[ends.first] * Vec3::UnitZ());
        const double uj = r.dot(rest.orientations[ends.second] * Vec3::UnitZ());
        bonds.push_back({ends.first, ends.second, l, 0.0, uj - ui, 0.5 * (ui + uj)});
      }
      bonds[found->second].shearing += 12.0 * beam * area / (l * l * l * l);
      // Of an even lattice.
      const double turning = 8.0 * beam / (l * l), moving = membrane + 12.0 * beam / (l * l);
      if (moving > 0.0) inertia_by_mass = std::max(inertia_by_mass, turning * l * l / moving);
    }
    const Mat3 to_tensor = directions.inverse();
    triangle.stretching = area * to_tensor.transpose() * stretching * to_tensor;
    triangle.bending = area * to_tensor.transpose() * bending * to_tensor;
    triangles.push_back(triangle);
  }
}

void PresentBonds::update(const KeptBonds& kept, const std::vector<ParticleTraits>& traits, const ParticleCuts& cuts) {
  const Index n = static_cast<Index>(traits.size()), most = static_cast<Index>(kept.areas.size());
  std::vector<Index> index_of_id(most, kGone), number_of_bond(kept.bonds.size(), kGone);
  for (Index i = 0; i < n; ++i)
    if (traits[i].id < most) index_of_id[traits[i].id] = i;
  const auto isWhole = [&](Index k) {
    const Bond& b = kept.bonds[k];
    return index_of_id[b.i] != kGone && index_of_id[b.j] != kGone && !cuts.isSevered(b.i, b.j);
  };
  bonds_.clear();
  triangles_.clear();
  begins_.assign(n + 1, 0);
  for (const Triangle& given : kept.triangles) {
    if (!std::all_of(given.bond, given.bond + 3, isWhole)) continue;
    Triangle t = given;
    for (Index& corner : t.corners.corner) corner = index_of_id[corner];
    for (Index& k : t.bond) {
      Index& number = number_of_bond[k];
      if (number == kGone) {
        number = static_cast<Index>(bonds_.size());
        bonds_.push_back(kept.bonds[k]);
        Bond& b = bonds_.back();
        b.i = index_of_id[b.i];
        b.j = index_of_id[b.j];
        ++begins_[b.i + 1];
        ++begins_[b.j + 1];
      }
      k = number;
    }
    triangles_.push_back(t);
  }
  unbound_.clear();
  const auto separate = [&](Index id, Index other, double distance) {
    const auto [i, j] = std::minmax(index_of_id[id], index_of_id[other]);
    if (i != kGone) unbound_.push_back({i, j, distance});
  };
  for (std::size_t k = 0; k < kept.bonds.size(); ++k)
    if (number_of_bond[k] == kGone) separate(kept.bonds[k].i, kept.bonds[k].j, kept.bonds[k].length);
  for (const KeptBonds::Close& pair : kept.close) separate(pair.i, pair.j, pair.distance);
  std::sort(unbound_.begin(), unbound_.end(), isBefore);
  for (Index i = 0; i < n; ++i) begins_[i + 1] += begins_[i];
  others_.resize(2 * bonds_.size());
  numbers_.resize(others_.size());
  std::vector<Index> next(begins_.begin(), begins_.end() - 1);
  side_begins_.assign(bonds_.size() + 1, 0);
  for (Index k = 0; k < static_cast<Index>(bonds_.size()); ++k)
    for (const auto& [i, j] : {std::pair(bonds_[k].i, bonds_[k].j), std::pair(bonds_[k].j, bonds_[k].i)}) {
      others_[next[i]] = j;
      numbers_[next[i]++] = k;
    }
  for (const Triangle& t : triangles_)
    for (const Index k : t.bond) ++side_begins_[k + 1];
  for (std::size_t k = 0; k < bonds_.size(); ++k) side_begins_[k + 1] += side_begins_[k];
  sides_.resize(3 * triangles_.size());
  next.assign(side_begins_.begin(), side_begins_.end() - 1);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (int a = 0; a < 3; ++a) sides_[next[triangles_[t].bond[a]]++] = static_cast<Index>(3 * t + a);
  deformed_.resize(bonds_.size());
  slopes_.resize(triangles_.size());
}

std::vector<WeightedTriangle> PresentBonds::triangles() const {
  std::vector<WeightedTriangle> all;
  all.reserve(triangles_.size());
  for (const Triangle& t : triangles_) all.push_back(t.corners);
  return all;
}

bool PresentBonds::areBound(Index i, Index j) const { return std::find(begin(i), end(i), j) != end(i); }

double PresentBonds::restDistance(Index i, Index j) const {
  const KeptBonds::Close wanted{std::min(i, j), std::max(i, j), 0.0};
  const auto found = std::lower_bound(unbound_.begin(), unbound_.end(), wanted, isBefore);
  const bool is_listed = found != unbound_.end() && !isBefore(wanted, *found);
  return is_listed ? found->distance : std::numeric_limits<double>::infinity();
}

// Strains of bonds, slopes of triangles, then slopes of bonds.
void PresentBonds::deform(const PackedParticles& particles) const {
  const Index num_bonds = static_cast<Index>(bonds_.size()), num_triangles = static_cast<Index>(triangles_.size());
  parallelFor(num_bonds, kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const Bond& b = bonds_[k];
      Deformed& d = deformed_[k];
      d.r = Eigen::Map<const Vec3>(particles.place(b.j)) - Eigen::Map<const Vec3>(particles.place(b.i));
      d.ni = Eigen::Map<const Vec3>(particles.normal(b.i));
      d.nj = Eigen::Map<const Vec3>(particles.normal(b.j));
      const double ui = d.ni.dot(d.r), uj = d.nj.dot(d.r);
      d.distance = d.r.norm();
      d.strain = d.distance / b.length - 1.0;
      d.curvature = (uj - ui - b.curve) / (b.length * b.length);
      d.shear = 0.5 * (ui + uj) - b.height;
      const Index ends[2] = {b.i, b.j};
      findStrength(particles, ends, d.strength, d.smooth);
    }
  });
  parallelFor(num_triangles, kBlock, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t) {
      const Triangle& triangle = triangles_[t];
      const Deformed &a = deformed_[triangle.bond[0]], &b = deformed_[triangle.bond[1]], &c = deformed_[triangle.bond[2]];
      double strength, smooth;
      findStrength(particles, triangle.corners.corner, strength, smooth);
      Eigen::Map<Vec3>(slopes_[t].by_strain) = strength * (triangle.stretching * Vec3(a.strain, b.strain, c.strain));
      Eigen::Map<Vec3>(slopes_[t].by_curvature) = smooth * (triangle.bending * Vec3(a.curvature, b.curvature, c.curvature));
    }
  });
  parallelFor(num_bonds, kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const Bond& b = bonds_[k];
      Deformed& d = deformed_[k];
      double by_strain = 0.0, by_curvature = 0.0;
      for (Index side = side_begins_[k]; side < side_begins_[k + 1]; ++side) {
        by_strain += slopes_[sides_[side] / 3].by_strain[sides_[side] % 3];
        by_curvature += slopes_[sides_[side] / 3].by_curvature[sides_[side] % 3];
      }
      const double bent = by_curvature / (b.length * b.length), sheared = 0.5 * d.smooth * b.shearing * d.shear;
      d.by_ui = sheared - bent;
      d.by_uj = sheared + bent;
      const double pull = d.distance > 0.0 ? by_strain / (b.length * d.distance) : 0.0;
      d.by_r = pull * d.r + d.by_ui * d.ni + d.by_uj * d.nj;
    }
  });
}

void PresentBonds::addForces(const PackedParticles& particles, Points& forces, Points& torques) const {
  deform(particles);
  parallelFor(static_cast<Index>(forces.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      for (Index k = begins_[i]; k < begins_[i + 1]; ++k) {
        const Deformed& d = deformed_[numbers_[k]];
        if (bonds_[numbers_[k]].i == i) {
          forces[i] += d.by_r;
          torques[i] += d.by_ui * d.r.cross(d.ni);
        } else {
          forces[i] -= d.by_r;
          torques[i] += d.by_uj * d.r.cross(d.nj);
        }
      }
  });
}

double PresentBonds::findEnergy(const PackedParticles& particles) const {
  deform(particles);
  const double in_triangles = parallelSum(static_cast<Index>(triangles_.size()), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index t = begin; t < end; ++t)
      for (int a = 0; a < 3; ++a) {
        const Deformed& d = deformed_[triangles_[t].bond[a]];
        sum += 0.5 * (slopes_[t].by_strain[a] * d.strain + slopes_[t].by_curvature[a] * d.curvature);
      }
    return sum;
  });
  return in_triangles + parallelSum(static_cast<Index>(bonds_.size()), kBlock, [&](Index begin, Index end) {
           double sum = 0.0;
           for (Index k = begin; k < end; ++k)
             sum += 0.5 * deformed_[k].smooth * bonds_[k].shearing * deformed_[k].shear * deformed_[k].shear;
           return sum;
         });
}

// Products of the gradients of strains, and slopes times second derivatives. The largest of the inverse masses of a triangle or
// bond stands for each.
void PresentBonds::addRowBounds(const PackedParticles& particles, const std::vector<double>& masses,
                                const std::vector<double>& inertias, std::vector<double>& moves,
                                std::vector<double>& turns) const {
  deform(particles);
  for (const Triangle& t : triangles_) {
    double by_mass = 0.0, by_inertia = 0.0, strength, smooth;
    for (const Index i : t.corners.corner) {
      by_mass = std::max(by_mass, 1.0 / masses[i]);
      by_inertia = std::max(by_inertia, 1.0 / inertias[i]);
    }
    findStrength(particles, t.corners.corner, strength, smooth);
    const double by_both = std::sqrt(by_mass * by_inertia);
    for (int a = 0; a < 3; ++a) {
      double move = 0.0, turn = 0.0;
      const Bond& mine = bonds_[t.bond[a]];
      const Deformed& d = deformed_[t.bond[a]];
      const double square = mine.length * mine.length, differ = (d.nj - d.ni).norm() / square, lever = d.distance / square;
      for (int b = 0; b < 3; ++b) {
        const Bond& other = bonds_[t.bond[b]];
        const Deformed& o = deformed_[t.bond[b]];
        const double other_square = other.length * other.length;
        const double other_differ = (o.nj - o.ni).norm() / other_square, other_lever = o.distance / other_square;
        const double bend = 2.0 * smooth * std::abs(t.bending(a, b));
        move += 2.0 * strength * std::abs(t.stretching(a, b)) / (mine.length * other.length) * by_mass +
                bend * differ * (other_differ * by_mass + other_lever * by_both);
        turn += bend * lever * (other_lever * by_inertia + other_differ * by_both);
      }
      for (const Index i : {mine.i, mine.j}) {
        moves[i] += move;
        turns[i] += turn;
      }
    }
  }
  for (std::size_t k = 0; k < bonds_.size(); ++k) {
    const Bond& b = bonds_[k];
    const Deformed& d = deformed_[k];
    const double by_mass = std::max(1.0 / masses[b.i], 1.0 / masses[b.j]);
    const double by_inertia = std::max(1.0 / inertias[b.i], 1.0 / inertias[b.j]), by_both = std::sqrt(by_mass * by_inertia);
    const double shear = d.smooth * b.shearing, slope = std::abs(d.by_ui) + std::abs(d.by_uj);
    const double pull = d.distance > 0.0 ? (d.by_r.norm() + slope) / d.distance : 0.0;
    for (const Index i : {b.i, b.j}) {
      moves[i] += 2.0 * (shear + pull) * by_mass + (shear * d.distance + slope) * by_both;
      turns[i] += (0.5 * shear * d.distance + slope) * d.distance * by_inertia + (shear * d.distance + 2.0 * slope) * by_both;
    }
  }
}

std::size_t KeptBonds::bytes() const {
  return bonds.capacity() * sizeof(Bond) + triangles.capacity() * sizeof(Triangle) + close.capacity() * sizeof(Close) +
         areas.capacity() * sizeof(double);
}

std::size_t PresentBonds::bytes() const {
  const std::size_t indices =
      begins_.capacity() + others_.capacity() + numbers_.capacity() + side_begins_.capacity() + sides_.capacity();
  return bonds_.capacity() * sizeof(KeptBonds::Bond) + triangles_.capacity() * sizeof(KeptBonds::Triangle) +
         unbound_.capacity() * sizeof(KeptBonds::Close) + indices * sizeof(Index) + deformed_.capacity() * sizeof(Deformed) +
         slopes_.capacity() * sizeof(Slopes);
}

}  // namespace deformable_surface::model
