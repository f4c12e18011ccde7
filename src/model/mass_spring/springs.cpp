#include "deformable_surface/model/mass_spring/springs.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;  // elements per parallel block: large enough for negligible overhead

// From four points padded to four numbers each to x, y and z of the four.
DEFORMABLE_SURFACE_INLINE void loadDifferences(const double* points, const Index* ends, Double4* difference) {
  for (int lane = 0; lane < 4; ++lane) {
    Double4 from;
    load(points + 4 * ends[lane], from);
    load(points + 4 * ends[4 + lane], difference[lane]);
    difference[lane] -= from;
  }
  transpose(difference[0], difference[1], difference[2], difference[3]);
}

// Tension over length of the groups of four springs from begin to end: k (1 - l0 / l), if elastic, plus beta k (dl/dt) / l.
// Springs without length get zero. velocities: null = no damping. Returns true if a spring has no length.
DEFORMABLE_SURFACE_WIDE bool computePull(Index begin, Index end, const Index* ends, const double* constants,
                                         const double* positions, const double* velocities, double elasticity, double beta,
                                         double* pull) {
  using Flags = long long __attribute__((vector_size(4 * sizeof(long long))));
  Flags collapsed{};
  for (Index g = begin; g < end; ++g) {
    Double4 d[4], stiffness, rest_length;
    loadDifferences(positions, ends + 8 * g, d);
    load(constants + 8 * g, stiffness);
    load(constants + 8 * g + 4, rest_length);
    const Double4 square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    Double4 length = square;
    takeRoots(length);
    const Flags none = length == 0.0;
    collapsed |= none;
    Double4 relative = elasticity * (1.0 - rest_length / length);
    if (velocities) {
      Double4 v[4];
      loadDifferences(velocities, ends + 8 * g, v);
      relative += beta * (v[0] * d[0] + v[1] * d[1] + v[2] * d[2]) / square;
    }
    store(none ? Double4{} : stiffness * relative, pull + 4 * g);
  }
  return collapsed[0] || collapsed[1] || collapsed[2] || collapsed[3];
}

// Adds to each point the pull of its springs. incidence: two items a spring; forces: (n x 3).
DEFORMABLE_SURFACE_WIDE void gatherPull(Index begin, Index end, const Index* offsets, const Index* incidence, const double* pull,
                                        const double* positions, double* forces) {
  for (Index i = begin; i < end; ++i) {
    Double4 here, sum{};
    load(positions + 4 * i, here);
    for (Index k = offsets[i]; k < offsets[i + 1]; k += 2) {
      Double4 there;
      load(positions + 4 * incidence[k + 1], there);
      sum += pull[incidence[k]] * (there - here);
    }
    for (int c = 0; c < 3; ++c) forces[3 * i + c] += sum[c];
  }
}

}  // namespace

Springs::Springs(std::vector<std::pair<Index, Index>> links, const Points& rest, std::vector<double> stiffness)
    : links_(std::move(links)), stiffness_(std::move(stiffness)) {
  rest_length_.reserve(links_.size());
  for (const auto& [i, j] : links_) rest_length_.push_back((rest[j] - rest[i]).norm());
  prepareForceLoop(static_cast<Index>(rest.size()));
}

void Springs::prepareForceLoop(Index num_points) {
  std::vector<std::pair<Index, Index>> ends;
  ends.reserve(4 * links_.size());
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const auto [i, j] = links_[s];
    for (const auto& [here, there] : {std::pair(i, j), std::pair(j, i)}) {
      ends.emplace_back(here, static_cast<Index>(s));
      ends.emplace_back(here, there);
    }
  }
  incidence_ = groupByPoint(num_points, ends);
  // The same constants once more for the force loop.
  const std::size_t groups = (links_.size() + 3) / 4;
  pull_.resize(4 * groups);
  group_ends_.reserve(8 * groups);
  group_constants_.reserve(8 * groups);
  for (std::size_t k = 0; k < 8 * groups; ++k) {
    const std::size_t s = std::min(k / 8 * 4 + k % 4, links_.size() - 1);
    group_ends_.push_back(k / 4 % 2 == 0 ? links_[s].first : links_[s].second);
    group_constants_.push_back(k / 4 % 2 == 0 ? stiffness_[s] : rest_length_[s]);
  }
}

Vec3 Springs::direction(std::size_t s, const State& state, double& length) const {
  const auto [i, j] = links_[s];
  const Vec3 difference = state.positions[j] - state.positions[i];
  length = difference.norm();
  if (length > 0.0) return difference / length;
  return fixedDirection(i, j);
}

// Four springs at a time; then the points gather. The few springs without length are added one by one.
void Springs::addForces(const State& state, const PaddedPoints& positions, bool elastic, double beta, Points& forces) const {
  const double elasticity = elastic ? 1.0 : 0.0;
  if (beta > 0.0) velocities_.assign(state.velocities);
  std::atomic<bool> collapsed{false};
  parallelFor(static_cast<Index>(pull_.size() / 4), kBlock / 4, [&](Index begin, Index end) {
    if (computePull(begin, end, group_ends_.data(), group_constants_.data(), positions.data(),
                    beta > 0.0 ? velocities_.data() : nullptr, elasticity, beta, pull_.data()))
      collapsed = true;
  });
  parallelFor(incidence_.size(), kBlock, [&](Index begin, Index end) {
    gatherPull(begin, end, incidence_.offsets.data(), incidence_.items.data(), pull_.data(), positions.data(),
               forces.data()->data());
  });
  if (!collapsed) return;
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const auto [i, j] = links_[s];
    double length;
    const Vec3 d = direction(s, state, length);
    if (length > 0.0) continue;
    const Vec3 tension =
        stiffness_[s] * (-elasticity * rest_length_[s] + beta * (state.velocities[j] - state.velocities[i]).dot(d)) * d;
    forces[i] += tension;
    forces[j] -= tension;
  }
}

void Springs::addRelativeDamping(const State& state, double beta, Points& forces) const {
  parallelFor(incidence_.size(), kBlock, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      for (const Index* e = incidence_.begin(p); e != incidence_.end(p); e += 2)
        sum += stiffness_[e[0]] * (state.velocities[e[1]] - state.velocities[p]);
      forces[p] += beta * sum;
    }
  });
}

double Springs::energy(const State& state) const {
  return parallelSum(static_cast<Index>(links_.size()), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index s = begin; s < end; ++s) {
      const double elongation = (state.positions[links_[s].second] - state.positions[links_[s].first]).norm() - rest_length_[s];
      sum += 0.5 * stiffness_[s] * elongation * elongation;
    }
    return sum;
  });
}

void Springs::addStiffness(const State& state, bool elastic, double beta, double step, Hessian hessian,
                           BlockSparse& stiffness) const {
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const auto [i, j] = links_[s];
    double length;
    const Vec3 d = direction(s, state, length);
    const double along = (elastic ? 1.0 : 0.0) + (step > 0.0 ? beta / step : 0.0);
    const bool keeps_across = elastic && length > 0.0 && (hessian == Hessian::kExact || length > rest_length_[s]);
    const double across = keeps_across ? 1.0 - rest_length_[s] / length : 0.0;
    const Mat3 block = stiffness_[s] * ((along - across) * d * d.transpose() + across * Mat3::Identity());
    stiffness.add(i, i, block);
    stiffness.add(j, j, block);
    stiffness.add(i, j, -block);
  }
}

void Springs::addRelativeDampingMatrix(double beta, double step, BlockSparse& stiffness) const {
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const auto [i, j] = links_[s];
    const Mat3 block = beta * stiffness_[s] / step * Mat3::Identity();
    stiffness.add(i, i, block);
    stiffness.add(j, j, block);
    stiffness.add(i, j, -block);
  }
}

void Springs::addRowBounds(bool elastic, double beta, std::vector<double>& stiffness, std::vector<double>& damping) const {
  for (std::size_t s = 0; s < links_.size(); ++s) {
    for (Index p : {links_[s].first, links_[s].second}) {
      if (elastic) stiffness[p] += 2.0 * stiffness_[s];
      damping[p] += 2.0 * beta * stiffness_[s];
    }
  }
}

double Springs::maxStretch(const State& state) const {
  return parallelMax(static_cast<Index>(links_.size()), kBlock, [&](Index begin, Index end) {
    double worst = 0.0;
    for (Index s = begin; s < end; ++s) {
      const double length = (state.positions[links_[s].second] - state.positions[links_[s].first]).norm();
      worst = std::max(worst, std::abs(length / rest_length_[s] - 1.0));
    }
    return worst;
  });
}

void Springs::raisePointStrain(const State& state, std::vector<double>& strain) const {
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const auto [i, j] = links_[s];
    const double stretch = std::abs((state.positions[j] - state.positions[i]).norm() / rest_length_[s] - 1.0);
    strain[i] = std::max(strain[i], stretch);
    strain[j] = std::max(strain[j], stretch);
  }
}

}  // namespace deformable_surface::model
