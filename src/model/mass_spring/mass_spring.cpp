#include "deformable_surface/model/mass_spring/mass_spring.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr double kSmallestMass = 1e-3;  // of the median: a ring of no area must not give infinite acceleration

using Link = MassSpring::Link;

Link ordered(Index i, Index j) { return i < j ? Link(i, j) : Link(j, i); }

// Each pair of ring neighbours once.
std::vector<Link> stretchingLinks(const cloud::Rings& rings) {
  std::vector<Link> links;
  for (Index i = 0; i < rings.ring.size(); ++i)
    for (const Index* j = rings.ring.begin(i); j != rings.ring.end(i); ++j)
      if (i < *j) links.emplace_back(i, *j);
  std::sort(links.begin(), links.end());
  return links;
}

// r to r + 2 across every ring, each pair once and none that is a stretching link.
std::vector<Link> bendingLinks(const cloud::Rings& rings, const std::vector<Link>& stretching) {
  std::vector<Link> links;
  for (Index i = 0; i < rings.ring.size(); ++i) {
    const Index m = rings.ring.count(i);
    const Index* r = rings.ring.begin(i);
    const Index last = rings.open[i] ? m - 2 : (m > 2 ? m : 0);
    for (Index a = 0; a < last; ++a) {
      const Link link = ordered(r[a], r[(a + 2) % m]);
      if (link.first != link.second && !std::binary_search(stretching.begin(), stretching.end(), link)) links.push_back(link);
    }
  }
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return links;
}

double triangleArea(const WeightedTriangle& t, const Points& x) {
  return 0.5 * (x[t.corner[1]] - x[t.corner[0]]).cross(x[t.corner[2]] - x[t.corner[0]]).norm();
}

Vec3 meanOf(const Points& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

double sumOfSquares(const std::vector<Link>& links, const std::vector<double>& k, const Points& x) {
  double sum = 0.0;
  for (std::size_t s = 0; s < links.size(); ++s) sum += k[s] * (x[links[s].second] - x[links[s].first]).squaredNorm();
  return sum;
}

}  // namespace

MassSpring::MassSpring(const Points& rest, const Points& normals, const cloud::Rings& rings, double surface_area, bool closed,
                       const MaterialParams& material, const MassSpringParams& params, const std::vector<char>& held,
                       const std::vector<ClampEdge>& edges)
    : membrane_(params.membrane == Membrane::kAuto ? Membrane::kTriangles : params.membrane),
      along_damping_(params.damping == Damping::kAlongSpring ? material.spring_damping : 0.0),
      relative_damping_(params.damping == Damping::kRelativeVelocity ? material.spring_damping : 0.0),
      closed_(closed),
      volume_stiffness_(params.volume_stiffness) {
  made_.points = rest;
  const Index n = static_cast<Index>(rest.size());
  for (const cloud::Triangle& t : rings.triangles) triangles_.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  groupTriangles();

  // Masses by each point's share of the area [Su 2007, eq. 1], scaled to the mass of the full surface.
  const double ring_area = std::accumulate(rings.area.begin(), rings.area.end(), 0.0);
  masses_.resize(n);
  for (Index i = 0; i < n; ++i) masses_[i] = rings.area[i] / ring_area;
  std::vector<double> sorted = masses_;
  std::nth_element(sorted.begin(), sorted.begin() + n / 2, sorted.end());
  for (double& mass : masses_)
    if (!(mass >= kSmallestMass * sorted[n / 2])) {
      mass = kSmallestMass * sorted[n / 2];
      ++num_mass_raised_;
    }
  const double total = std::accumulate(masses_.begin(), masses_.end(), 0.0);
  for (double& mass : masses_) mass *= material.arealDensity() * surface_area / total;

  // The edges of few points are ragged and lie within those of the full surface: the missing area counts in bending and
  // stretching as it does in mass.
  const double whole = !closed && ring_area > 0.0 ? surface_area / ring_area : 1.0;
  const double membrane_stiffness = whole * material.young_modulus * material.thickness;
  made_.membrane_stiffness = membrane_stiffness;
  made_.poisson_ratio = material.poisson_ratio;
  // Spring stiffness from the triangles at each spring.
  const std::vector<Link> stretching = stretchingLinks(rings);
  std::vector<double> k(stretching.size(), 0.0);
  for (const WeightedTriangle& t : triangles_) {
    const double share = membrane_stiffness * t.weight * triangleArea(t, rest);
    for (int c = 0; c < 3; ++c) {
      const Link link = ordered(t.corner[c], t.corner[(c + 1) % 3]);
      const auto s = std::lower_bound(stretching.begin(), stretching.end(), link);
      if (s != stretching.end() && *s == link)
        k[s - stretching.begin()] += share / (rest[link.second] - rest[link.first]).squaredNorm();
    }
  }
  const double mean = stretching.empty() ? 0.0 : std::accumulate(k.begin(), k.end(), 0.0) / k.size();
  for (double& stiffness : k) stiffness = std::max(stiffness, kSmallestMass * mean);  // links at which no triangle was found
  std::vector<Link> across;
  if (params.bending == Bending::kSprings) across = bendingLinks(rings, stretching);
  std::vector<double> k_across(across.size(), params.bending_spring_ratio * mean);
  const double affine =
      sumOfSquares(stretching, k, rest) + (membrane_ == Membrane::kSprings ? sumOfSquares(across, k_across, rest) : 0.0);
  const double scale = affine > 0.0 ? 3.0 * ring_area * membrane_stiffness / affine : 0.0;
  for (double& stiffness : k) stiffness *= scale;
  for (double& stiffness : k_across) stiffness *= scale;
  if (params.stiffness == Stiffness::kUniform) {
    k.assign(k.size(), params.spring_constant);
    k_across.assign(k_across.size(), params.bending_spring_ratio * params.spring_constant);
  }
  stretching_ = Springs(stretching, rest, std::move(k));
  bending_springs_ = Springs(across, rest, std::move(k_across));

  if (membrane_ == Membrane::kTriangles)
    membrane_triangles_ = TriangleMembrane(triangles_, rest, membrane_stiffness, material.poisson_ratio);
  if (params.bending == Bending::kCurvature && material.bendingRigidity() > 0.0) {
    plate_ = {rest, normals, rings.ring, {}, whole * material.bendingRigidity(), material.bendingPoissonRatio()};
    held_ = held.empty() ? std::vector<char>(n, 0) : held;
    edges_ = edges;
    buildBending();
    num_without_bending_ = bending_.numWithoutFit();
  }

  if (volume_stiffness_ > 0.0) {
    if (!closed_)
      throw InputError("mass_spring.volume_stiffness: found " + formatReal(volume_stiffness_) +
                       " on a surface with a boundary; accepted: 0, or a closed surface");
    rest_volume_ = enclosedVolume(State{rest, {}});
    if (!(rest_volume_ > 0.0)) throw InputError("mass_spring.volume_stiffness: the surface encloses no volume; accepted: 0");
  }
}

bool MassSpring::setHeld(const std::vector<char>& held, const std::vector<ClampEdge>& edges) {
  if (plate_.points.empty() || (held == held_ && edges == edges_)) return false;
  held_ = held;
  edges_ = edges;
  whole_.reset();
  buildBending();
  return true;
}

void MassSpring::addForces(const State& state, Points& forces) const {
  addFastForces(state, forces);
  bending_.addForces(positions_, forces);
}

void MassSpring::addSlowForces(const State& state, Points& forces) const {
  positions_.assign(state.positions);
  bending_.addForces(positions_, forces);
}

void MassSpring::addFastForces(const State& state, Points& forces) const {
  const bool springs = membrane_ == Membrane::kSprings;
  positions_.assign(state.positions);
  if (springs || along_damping_ > 0.0) stretching_.addForces(state, positions_, springs, along_damping_, forces);
  if (!bending_springs_.links().empty()) bending_springs_.addForces(state, positions_, true, along_damping_, forces);
  if (relative_damping_ > 0.0) {
    stretching_.addRelativeDamping(state, relative_damping_, forces);
    bending_springs_.addRelativeDamping(state, relative_damping_, forces);
  }
  if (!springs) membrane_triangles_.addForces(state, positions_, forces);
  if (volume_stiffness_ > 0.0) {
    computeVolumeGradient(state, volume_gradient_);
    const double pressure = -volume_stiffness_ * (enclosedVolume(state) - rest_volume_) / rest_volume_;
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += pressure * volume_gradient_[i];
  }
}

double MassSpring::elasticEnergy(const State& state) const {
  double energy = membrane_ == Membrane::kSprings ? stretching_.energy(state) : membrane_triangles_.energy(state);
  positions_.assign(state.positions);
  energy += bending_springs_.energy(state) + bending_.energy(positions_);
  if (volume_stiffness_ > 0.0) {
    const double change = enclosedVolume(state) - rest_volume_;
    energy += 0.5 * volume_stiffness_ * change * change / rest_volume_;
  }
  return energy;
}

void MassSpring::addStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const {
  addFastStiffness(state, step, hessian, stiffness);
  bending_.addStiffness(state, hessian, stiffness);
}

// Of the volume term the change of its gradient is omitted: it is small beside the rank-one part while the volume is kept.
void MassSpring::addFastStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const {
  const bool springs = membrane_ == Membrane::kSprings;
  if (springs || along_damping_ > 0.0) stretching_.addStiffness(state, springs, along_damping_, step, hessian, stiffness);
  if (!bending_springs_.links().empty()) bending_springs_.addStiffness(state, true, along_damping_, step, hessian, stiffness);
  if (relative_damping_ > 0.0 && step > 0.0) {
    stretching_.addRelativeDampingMatrix(relative_damping_, step, stiffness);
    bending_springs_.addRelativeDampingMatrix(relative_damping_, step, stiffness);
  }
  if (!springs) membrane_triangles_.addStiffness(state, hessian, stiffness);
}

double MassSpring::rankOneStiffness(const State& state, Points& v) const {
  if (!(volume_stiffness_ > 0.0)) return 0.0;
  computeVolumeGradient(state, v);
  return volume_stiffness_ / rest_volume_;
}

void MassSpring::addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const {
  const bool springs = membrane_ == Membrane::kSprings;
  stretching_.addRowBounds(springs, along_damping_ + relative_damping_, stiffness, damping);
  bending_springs_.addRowBounds(true, along_damping_ + relative_damping_, stiffness, damping);
  if (!springs) membrane_triangles_.addRowBounds(stiffness);
  bending_.addRowBounds(stiffness);
  if (volume_stiffness_ > 0.0) {
    computeVolumeGradient(state, volume_gradient_);
    double sum = 0.0;
    for (const Vec3& a : volume_gradient_) sum += a.norm();
    for (std::size_t i = 0; i < stiffness.size(); ++i)
      stiffness[i] += volume_stiffness_ / rest_volume_ * volume_gradient_[i].norm() * sum;
  }
}

void MassSpring::computeAreaVectors(const State& state, Points& area_vectors) const {
  const Index n = triangle_corners_.size(), num_triangles = static_cast<Index>(triangles_.size());
  triangle_shares_.resize(triangles_.size());
  parallelFor(num_triangles, kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const WeightedTriangle& t = triangles_[k];
      const Vec3& origin = state.positions[t.corner[0]];
      triangle_shares_[k] = t.weight / 6.0 * (state.positions[t.corner[1]] - origin).cross(state.positions[t.corner[2]] - origin);
    }
  });
  area_vectors.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (const Index* c = triangle_corners_.begin(i); c != triangle_corners_.end(i); ++c) sum += triangle_shares_[*c / 3];
      area_vectors[i] = sum;
    }
  });
}

// The volume is measured from the mean of the points. Where Delaunay stars disagree and the triangles do not quite close, rigid
// motion still does not change it, and its gradient keeps momentum.
double MassSpring::enclosedVolume(const State& state) const {
  const Vec3 apex = meanOf(state.positions);
  return parallelSum(static_cast<Index>(triangles_.size()), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index t = begin; t < end; ++t) {
      const WeightedTriangle& w = triangles_[t];
      sum += w.weight / 6.0 *
             (state.positions[w.corner[0]] - apex)
                 .dot((state.positions[w.corner[1]] - apex).cross(state.positions[w.corner[2]] - apex));
    }
    return sum;
  });
}

void MassSpring::computeVolumeGradient(const State& state, Points& gradient) const {
  const Index n = triangle_corners_.size();
  const Vec3 apex = meanOf(state.positions);
  gradient.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (const Index* c = triangle_corners_.begin(i); c != triangle_corners_.end(i); ++c) {
        const WeightedTriangle& t = triangles_[*c / 3];
        sum += t.weight / 6.0 *
               (state.positions[t.corner[(*c + 1) % 3]] - apex).cross(state.positions[t.corner[(*c + 2) % 3]] - apex);
      }
      gradient[i] = sum;
    }
  });
  // The apex moves with the points.
  const Vec3 mean = meanOf(gradient);
  for (Vec3& g : gradient) g -= mean;
}

void MassSpring::computePointStrain(const State& state, std::vector<double>& strain) const {
  strain.assign(state.positions.size(), 0.0);
  stretching_.raisePointStrain(state, strain);
}

}  // namespace deformable_surface::model
