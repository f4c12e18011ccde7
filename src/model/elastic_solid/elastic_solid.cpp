#include "deformable_surface/model/elastic_solid/elastic_solid.h"

#include "deformable_surface/base/disjoint_sets.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/linear/lanczos.h"
#include "deformable_surface/model/elastic_solid/point_volumes.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;          // points a task, a multiple of four: some ten microseconds of work
constexpr double kLeastVolume = 1e-3;  // of the median: a point with an empty cell still needs a mass
constexpr double kReach = 2.0;         // of the local spacing: some thirty neighbours, and no more than one layer beyond the next
constexpr double kNearReach = 1.6;     // of the neighbours that motions from point to point are compared with: half as many
constexpr double kLeastCoupling = 0.15;  // of the largest weight: some seven neighbours are left, and factors stay small
constexpr Index kLinks = 6;              // nearest neighbours that are drawn, as on a cubic lattice

double findMu(const MaterialParams& m) { return m.young_modulus / (2.0 * (1.0 + m.poisson_ratio)); }

// Of a thin plate that bears no stress across it, or of a body.
double findLambda(const MaterialParams& m, bool is_plate) {
  const double nu = m.poisson_ratio;
  return is_plate ? m.young_modulus * nu / (1.0 - nu * nu) : m.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
}

// s = stiffness sum_i V_i / sum_i (tr K'_i / d): a deviation as large as a strain costs as much energy as the strain.
double findStabilization(const PairFit& near, const Points& points, const std::vector<double>& volumes, double stiffness,
                         int dimension) {
  double volume = 0.0, spread = 0.0;
  for (Index i = 0; i < near.size(); ++i) {
    volume += volumes[i];
    for (Index k = near.pairs.offsets[i]; k < near.pairs.offsets[i + 1]; ++k)
      spread +=
          Eigen::Map<const Vec3>(near.m.data() + 4 * static_cast<std::size_t>(k)).dot(points[near.pairs.items[k]] - points[i]);
  }
  return spread > 0.0 ? stiffness * volume * dimension / spread : 0.0;
}

StressLaw toStressLaw(SolidLaw law) {
  if (law == SolidLaw::kLinear) return StressLaw::kLinear;
  return law == SolidLaw::kNeoHookean ? StressLaw::kNeoHookean : StressLaw::kCorotated;
}

// In a planar solid, displacements across the plane are no strain.
Points flatten(Points points, const Vec3& across) {
  for (Vec3& p : points) p -= across.dot(p) * across;
  return points;
}

// Puts the pairs of the narrow fit, all of which are in the wide one, first in it, in order, so that one loop runs over both.
void putNearFirst(SolidRest& rest) {
  PairFit& fit = rest.fit;
  for (Index i = 0; i < fit.size(); ++i) {
    Index next = fit.pairs.offsets[i];
    for (const Index* j = rest.near.pairs.begin(i); j != rest.near.pairs.end(i); ++j, ++next) {
      // Both ascend: entries in between move up by one place.
      Index k = next;
      while (fit.pairs.items[k] != *j) ++k;
      const auto rotate = [next, k](auto& values, Index width) {
        std::rotate(values.begin() + std::ptrdiff_t{width} * next, values.begin() + std::ptrdiff_t{width} * k,
                    values.begin() + std::ptrdiff_t{width} * (k + 1));
      };
      rotate(fit.pairs.items, 1);
      rotate(rest.gradients.row, 3);
    }
  }
}

SolidRest makeRest(const Points& given, const Lists& neighbors, const std::vector<double>& detours, const Vec3& across,
                   const MaterialParams& material, const ElasticSolidParams& params, Outline outline,
                   const std::vector<double>& around) {
  const bool is_planar = !across.isZero(0.0);
  const Points points = flatten(given, across);
  PointCells cells = findPointCells(points, neighbors, across, outline);
  std::vector<double> sorted = cells.volume;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  for (double& v : cells.volume) v = std::max(v, kLeastVolume * sorted[sorted.size() / 2]);
  SolidRest rest;
  rest.fit = fitPairs(points, neighbors, detours, kReach);
  rest.gradients = makeConsistent(points, rest.fit, cells);
  rest.near = fitPairs(points, neighbors, detours, kNearReach);
  rest.fit.m = std::vector<double>();  // strain is measured by the gradients made of it
  putNearFirst(rest);
  rest.volumes = cells.volume;
  if (!around.empty()) fillCells(around, neighbors, rest.volumes);
  if (is_planar)
    for (double& v : rest.volumes) v *= material.thickness;
  rest.mu = findMu(material);
  rest.lambda = findLambda(material, is_planar && params.plane == PlaneKind::kStress);
  rest.stabilization =
      findStabilization(rest.near, points, rest.volumes, params.stabilization * material.young_modulus, is_planar ? 2 : 3);
  rest.across = across;
  return rest;
}

}  // namespace

ElasticSolid::ElasticSolid(const Points& rest, const Lists& neighbors, const std::vector<double>& detours, const Vec3& across,
                           const MaterialParams& material, const ElasticSolidParams& params, Outline outline,
                           const std::vector<double>& around)
    : law_(toStressLaw(params.law)),
      is_plate_(!across.isZero(0.0) && params.plane == PlaneKind::kStress),
      passes_(makeRest(rest, neighbors, detours, across, material, params, outline, around)) {
  if (params.plasticity.isOn()) plasticity_.emplace(passes_.rest, params.plasticity);
  for (double volume : passes_.rest.volumes) masses_.push_back(material.density * volume);
  const char full = isPlanar() ? 2 : 3;
  for (char rank : passes_.rest.fit.rank) num_deficient_ += rank < full;
  for (Index i = 0; i < neighbors.size(); ++i)
    for (const Index* j = neighbors.begin(i); j != neighbors.begin(i) + std::min(kLinks, neighbors.count(i)); ++j) {
      const Index* end = neighbors.begin(*j) + std::min(kLinks, neighbors.count(*j));
      if (!(i < *j) || std::find(neighbors.begin(*j), end, i) == end) continue;
      links_.emplace_back(i, *j);
    }
  joinLinks();
  for (const auto& [i, j] : links_) lengths_.push_back((rest[j] - rest[i]).norm());
  findRowBounds();
  findCouplings();
  boundStableStep();
}

// A point beside a denser part may be among nobody's nearest, though forces hold it.
void ElasticSolid::joinLinks() {
  std::vector<Index> sets;
  makeSingleSets(passes_.size(), sets);
  for (const auto& [i, j] : links_) joinSets(sets, i, j);
  const Lists& pairs = passes_.rest.fit.pairs;
  for (Index i = 0; i < passes_.size(); ++i)
    for (const Index* j = pairs.begin(i); j != pairs.end(i); ++j)
      if (joinSets(sets, i, *j)) links_.emplace_back(std::min(i, *j), std::max(i, *j));
}

void ElasticSolid::beginAtRest(State& state) {
  state.dissipated = 0.0;
  state.plastic.assign(plasticity_ ? state.positions.size() : 0, Mat3::Identity());
  adopt(state);
}

void ElasticSolid::adopt(const State& state) {
  energy_at_.clear();
  if (plasticity_) plasticity_->apply(state.plastic, passes_);
}

bool ElasticSolid::flow(double dt, State& state) {
  if (!plasticity_) return false;
  energy_at_.clear();
  positions_.assign(state.positions);
  return plasticity_->flow(dt, positions_.data(), passes_, state);
}

// Sums of the norms of the blocks of a row of kBound's stiffness: E is a sum over k of the effect of the neighbours i and j of k
// on F_k and F'_k.
void ElasticSolid::findRowBounds() {
  const SolidRest& rest = passes_.rest;
  const Index n = passes_.size();
  const double stiffness = 2.0 * rest.mu + 3.0 * std::abs(rest.lambda), s = rest.stabilization;
  row_bounds_.assign(n, 0.0);
  for (Index i = 0; i < n; ++i) {
    double sum = rest.gradients.own[i].norm(), near_sum = 0.0, weights = 0.0;
    const auto gradientAt = [&](Index k) {
      return Eigen::Map<const Vec3>(rest.gradients.row.data() + 3 * static_cast<std::size_t>(k)).norm();
    };
    const auto near = [&](Index k) { return rest.near.m.data() + 4 * static_cast<std::size_t>(k); };
    const Mat3 inverse = rest.near.inverseAt(i);
    for (Index k = rest.fit.pairs.offsets[i]; k < rest.fit.pairs.offsets[i + 1]; ++k) sum += gradientAt(k);
    for (Index k = rest.near.pairs.offsets[i]; k < rest.near.pairs.offsets[i + 1]; ++k) {
      near_sum += 2.0 * (inverse * Eigen::Map<const Vec3>(near(k))).norm();
      weights += near(k)[3];
    }
    const double strained = rest.volumes[i] * stiffness * sum, deviated = s * near_sum;
    row_bounds_[i] += strained * rest.gradients.own[i].norm() + 4.0 * s * weights;
    for (Index k = rest.fit.pairs.offsets[i]; k < rest.fit.pairs.offsets[i + 1]; ++k)
      row_bounds_[rest.fit.pairs.items[k]] += strained * gradientAt(k);
    for (Index k = rest.near.pairs.offsets[i]; k < rest.near.pairs.offsets[i + 1]; ++k) {
      const double part = deviated * Eigen::Map<const Vec3>(near(k)).norm();
      row_bounds_[rest.near.pairs.items[k]] += part;
      row_bounds_[i] += part;
    }
  }
}

// The energy of each point, with |grad u|^2 in place of its strain's, spread over the nearest neighbours with the largest weights
// in its fit: sum_j w'_ij |u_j - u_i|^2 is |grad u|^2 sum_j w'_ij |X_j - X_i|^2 / d for a linear u, averaged over directions.
void ElasticSolid::findCouplings() {
  const SolidRest& rest = passes_.rest;
  const Lists& pairs = rest.near.pairs;
  const auto rowOf = [&](Index k) { return rest.near.m.data() + 4 * static_cast<std::size_t>(k); };
  const Index n = passes_.size();
  std::vector<double> most(n, 0.0), share(n, 0.0);
  for (Index i = 0; i < n; ++i)
    for (Index k = pairs.offsets[i]; k < pairs.offsets[i + 1]; ++k) most[i] = std::max(most[i], rowOf(k)[3]);
  const auto isKept = [&](Index i, Index k) { return rowOf(k)[3] >= kLeastCoupling * std::min(most[i], most[pairs.items[k]]); };
  for (Index i = 0; i < n; ++i) {
    double spread = 0.0;
    for (Index k = pairs.offsets[i]; k < pairs.offsets[i + 1]; ++k)
      if (isKept(i, k)) spread += Eigen::Map<const Vec3>(rowOf(k)).squaredNorm() / rowOf(k)[3];
    if (spread > 0.0) share[i] = (2.0 * rest.mu + rest.lambda) * rest.volumes[i] * (isPlanar() ? 2 : 3) / spread;
  }
  for (Index i = 0; i < n; ++i)
    for (Index k = pairs.offsets[i]; k < pairs.offsets[i + 1]; ++k)
      if (const Index j = pairs.items[k]; i < j && isKept(i, k))
        couplings_.push_back({i, j, 0.5 * (share[i] + share[j]) * rowOf(k)[3]});
}

void ElasticSolid::boundStableStep() {
  const Index n = static_cast<Index>(masses_.size());
  Eigen::VectorXd scale(3 * n);
  for (Index i = 0; i < n; ++i) scale.segment<3>(3 * i).setConstant(1.0 / std::sqrt(masses_[i]));
  Points motion(n), forces(n);
  Lanczos lanczos;
  const double eigenvalue = lanczos.boundLargest(scale, [&](const Eigen::VectorXd& v, Eigen::VectorXd& product) {
    for (Index i = 0; i < n; ++i) motion[i] = scale[3 * i] * v.segment<3>(3 * i);
    positions_.assign(motion);
    forces.assign(n, Vec3::Zero());
    addPassForces(StressLaw::kBound, positions_.data(), forces);
    product.resize(3 * n);
    for (Index i = 0; i < n; ++i) product.segment<3>(3 * i) = -scale[3 * i] * forces[i];
  });
  stable_step_ = eigenvalue > 0.0 ? 2.0 / std::sqrt(eigenvalue) : std::numeric_limits<double>::infinity();
}

// Gradients are those at rest times F_p^-T.
double ElasticSolid::findStableStep(const State& state) const {
  double largest = 1.0;
  for (const Mat3& plastic : state.plastic) {
    Eigen::SelfAdjointEigenSolver<Mat3> squares;
    squares.computeDirect(plastic.transpose() * plastic, Eigen::EigenvaluesOnly);
    largest = std::max(largest, squares.eigenvalues()[2]);
  }
  if (law_ == StressLaw::kNeoHookean) {
    positions_.assign(state.positions);
    largest = std::max(largest, parallelMax(passes_.size(), kBlock, [&](Index begin, Index end) {
                         return passes_.boundStiffening(begin, end, positions_.data());
                       }));
  }
  return stable_step_ / std::sqrt(largest);
}

void ElasticSolid::addPassForces(StressLaw law, const double* positions, Points& forces) const {
  const Index n = passes_.size();
  parallelFor(n, PointRooms::kPoints, [&](Index begin, Index end) { passes_.spreadStress(law, begin, end, positions); });
  parallelFor(n, kBlock, [&](Index begin, Index end) { passes_.gatherForces(begin, end, forces.data()->data()); });
}

void ElasticSolid::addForces(const State& state, Points& forces) const {
  positions_.assign(state.positions);
  addPassForces(law_, positions_.data(), forces);
}

void ElasticSolid::prepareStiffness(const State& state, Hessian hessian) const {
  positions_.assign(state.positions);
  passes_.beginTangent();
  parallelFor(passes_.size(), kBlock, [&](Index begin, Index end) {
    passes_.prepareTangent(law_, hessian == Hessian::kPositive, begin, end, positions_.data());
  });
}

void ElasticSolid::addStiffnessProduct(const Points& v, Points& product) const {
  positions_.assign(v);
  product_.assign(v.size(), Vec3::Zero());
  addPassForces(law_ == StressLaw::kNeoHookean ? StressLaw::kNeoHookeanTangent : StressLaw::kTangent, positions_.data(),
                product_);
  for (std::size_t i = 0; i < v.size(); ++i) product[i] -= product_[i];
}

double ElasticSolid::elasticEnergy(const State& state) const {
  if (energy_at_ == state.positions) return energy_;
  positions_.assign(state.positions);
  const double energy = parallelSum(
      passes_.size(), kBlock, [&](Index begin, Index end) { return passes_.sumEnergy(law_, begin, end, positions_.data()); });
  // Last: an interrupt of the sum leaves the energy of before with its positions.
  energy_at_ = state.positions;
  return energy_ = energy;
}

void ElasticSolid::confine(Points& forces) const {
  if (!isPlanar()) return;
  for (Vec3& f : forces) f -= across().dot(f) * across();
}

void ElasticSolid::computePointStress(const State& state, std::vector<double>& stress) const {
  positions_.assign(state.positions);
  stress.resize(state.positions.size());
  parallelFor(passes_.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Mat3 F = passes_.fitGradient(i, positions_.data());
      Mat3 sigma = passes_.findStress(law_, F);
      if (law_ != StressLaw::kLinear) sigma = Mat3(sigma * F.transpose() / F.determinant());
      if (is_plate_) sigma -= across().dot(sigma * across()) * across() * across().transpose();
      sigma -= sigma.trace() / 3.0 * Mat3::Identity();
      stress[i] = std::sqrt(1.5) * sigma.norm();
    }
  });
}

void ElasticSolid::turnNormals(const State& state, const Points& normals, std::vector<Eigen::Vector3f>& turned) const {
  positions_.assign(state.positions);
  turned.resize(normals.size());
  parallelFor(passes_.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Mat3 F = passes_.fitGradient(i, positions_.data());
      if (!state.plastic.empty()) F = Mat3(F * state.plastic[i].inverse());  // of F_e and F_p
      const Vec3 normal = findCofactors(F) * normals[i];
      const double length = normal.norm();
      turned[i] = (length > 0.0 ? Vec3(normal / length) : normals[i]).cast<float>();
    }
  });
}

void ElasticSolid::addRowBounds(const State&, std::vector<double>& stiffness, std::vector<double>&) const {
  for (std::size_t i = 0; i < row_bounds_.size(); ++i) stiffness[i] += row_bounds_[i];
}

double ElasticSolid::maxStretch(const State& state) const {
  double largest = 0.0;
  for (std::size_t k = 0; k < links_.size(); ++k) largest = std::max(largest, stretchOf(k, state));
  return largest;
}

void ElasticSolid::computePointStrain(const State& state, std::vector<double>& strain) const {
  strain.assign(state.positions.size(), 0.0);
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const double stretch = stretchOf(k, state);
    for (const Index i : {links_[k].first, links_[k].second}) strain[i] = std::max(strain[i], stretch);
  }
}

double ElasticSolid::stretchOf(std::size_t link, const State& state) const {
  const auto& [i, j] = links_[link];
  return std::abs((state.positions[j] - state.positions[i]).norm() / lengths_[link] - 1.0);
}

}  // namespace deformable_surface::model
