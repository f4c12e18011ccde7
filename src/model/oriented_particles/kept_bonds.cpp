#include "deformable_surface/model/oriented_particles/kept_bonds.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace deformable_surface::model {
namespace {

using Bond = KeptBonds::Bond;
using Triangle = KeptBonds::Triangle;

constexpr Index kGone = -1;

bool isBefore(const KeptBonds::Close& a, const KeptBonds::Close& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); }

// C of plane stress: stiffness is E h, or D (1 - nu^2).
Mat3 findPlaneStress(double stiffness, double poisson) {
  Mat3 c = Mat3::Zero();
  c(0, 0) = c(1, 1) = 1.0;
  c(0, 1) = c(1, 0) = poisson;
  c(2, 2) = 0.5 * (1.0 - poisson);
  return stiffness / (1.0 - poisson * poisson) * c;
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
  corner_begins_.assign(n + 1, 0);
  std::vector<Triangle> present;
  std::vector<double> num_sides;
  for (const Triangle& given : kept.triangles) {
    if (!std::all_of(given.bond, given.bond + 3, isWhole)) continue;
    Triangle t = given;
    for (Index& corner : t.corners.corner) {
      corner = index_of_id[corner];
      ++corner_begins_[corner + 1];
    }
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
        num_sides.push_back(0.0);
      }
      k = number;
      ++num_sides[k];
    }
    triangles_.push_back(t.corners);
    present.push_back(t);
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
  for (std::vector<Index>* begins : {&begins_, &corner_begins_})
    for (Index i = 0; i < n; ++i) (*begins)[i + 1] += (*begins)[i];
  others_.resize(2 * bonds_.size());
  std::vector<Index> next(begins_.begin(), begins_.end() - 1);
  for (const Bond& b : bonds_) {
    others_[next[b.i]++] = b.j;
    others_[next[b.j]++] = b.i;
  }
  corners_.resize(3 * present.size());
  next.assign(corner_begins_.begin(), corner_begins_.end() - 1);
  for (Index t = 0; t < static_cast<Index>(present.size()); ++t)
    for (Index a = 0; a < 3; ++a) corners_[next[triangles_[t].corner[a]]++] = 3 * t + a;
  arrange(present, num_sides);
}

// Fours are filled up with triangles without stiffness.
void PresentBonds::arrange(const std::vector<Triangle>& triangles, const std::vector<double>& num_sides) {
  constexpr int kRows[6] = {0, 1, 2, 1, 0, 0}, kColumns[6] = {0, 1, 2, 2, 2, 1};
  FourTriangles none{};
  for (auto& lengths : none.length) std::fill_n(lengths, 4, 1.0);
  fours_.assign((triangles.size() + 3) / 4, none);
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const Triangle& t = triangles[k];
    FourTriangles& four = fours_[k / 4];
    const std::size_t lane = k % 4;
    for (int a = 0; a < 3; ++a) {
      const Bond& b = bonds_[t.bond[a]];
      four.corner[a][lane] = t.corners.corner[a];
      four.length[a][lane] = b.length;
      four.curve[a][lane] = b.curve;
      four.height[a][lane] = b.i == t.corners.corner[a] ? b.height : -b.height;
      four.shearing[a][lane] = b.shearing / num_sides[t.bond[a]];
    }
    for (int m = 0; m < 6; ++m) {
      const double lengths = bonds_[t.bond[kRows[m]]].length * bonds_[t.bond[kColumns[m]]].length;
      four.stretching[m][lane] = t.stretching(kRows[m], kColumns[m]) / lengths;
      four.bending[m][lane] = t.bending(kRows[m], kColumns[m]) / (lengths * lengths);
    }
  }
  constexpr std::size_t kPush = 20;
  pushes_.resize(4 * kPush * fours_.size());
  triangle_bounds_.resize(4 * fours_.size());
}

bool PresentBonds::areBound(Index i, Index j) const { return std::find(begin(i), end(i), j) != end(i); }

double PresentBonds::restDistance(Index i, Index j) const {
  const KeptBonds::Close wanted{std::min(i, j), std::max(i, j), 0.0};
  const auto found = std::lower_bound(unbound_.begin(), unbound_.end(), wanted, isBefore);
  const bool is_listed = found != unbound_.end() && !isBefore(wanted, *found);
  return is_listed ? found->distance : std::numeric_limits<double>::infinity();
}

std::size_t KeptBonds::bytes() const {
  return bonds.capacity() * sizeof(Bond) + triangles.capacity() * sizeof(Triangle) + close.capacity() * sizeof(Close) +
         areas.capacity() * sizeof(double);
}

std::size_t PresentBonds::bytes() const {
  const std::size_t indices = begins_.capacity() + others_.capacity() + corner_begins_.capacity() + corners_.capacity();
  return bonds_.capacity() * sizeof(Bond) + triangles_.capacity() * sizeof(WeightedTriangle) +
         fours_.capacity() * sizeof(FourTriangles) + unbound_.capacity() * sizeof(KeptBonds::Close) + indices * sizeof(Index) +
         (pushes_.capacity() + triangle_bounds_.capacity()) * sizeof(double);
}

}  // namespace deformable_surface::model
