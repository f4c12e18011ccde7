#include "deformable_surface/model/mass_spring/springs.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 2048;  // elements per parallel block: large enough that handing it out costs nothing

}  // namespace

Springs::Springs(std::vector<std::pair<Index, Index>> links, const Points& rest, std::vector<double> stiffness)
    : links_(std::move(links)), stiffness_(std::move(stiffness)), tension_(links_.size()) {
  std::vector<std::pair<Index, Index>> ends;
  ends.reserve(2 * links_.size());
  rest_length_.reserve(links_.size());
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const auto [i, j] = links_[s];
    rest_length_.push_back((rest[j] - rest[i]).norm());
    ends.emplace_back(i, static_cast<Index>(s));
    ends.emplace_back(j, ~static_cast<Index>(s));
  }
  incidence_ = groupByPoint(static_cast<Index>(rest.size()), ends);
}

Vec3 Springs::direction(std::size_t s, const State& state, double& length) const {
  const auto [i, j] = links_[s];
  const Vec3 difference = state.positions[j] - state.positions[i];
  length = difference.norm();
  if (length > 0.0) return difference / length;
  return fixedDirection(i, j);
}

void Springs::addForces(const State& state, bool elastic, double beta, Points& forces) const {
  const double elasticity = elastic ? 1.0 : 0.0;
  // The tension of every spring.
  parallelFor(static_cast<Index>(links_.size()), kBlock, [&](Index begin, Index end) {
    for (Index s = begin; s < end; ++s) {
      const auto [i, j] = links_[s];
      double length;
      const Vec3 d = direction(s, state, length);
      const double rate = (state.velocities[j] - state.velocities[i]).dot(d);
      tension_[s] = stiffness_[s] * (elasticity * (length - rest_length_[s]) + beta * rate) * d;
    }
  });
  // Gathered by the points.
  parallelFor(incidence_.size(), kBlock, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      for (const Index* s = incidence_.begin(p); s != incidence_.end(p); ++s) {
        if (*s >= 0) {
          sum += tension_[*s];
        } else {
          sum -= tension_[~*s];
        }
      }
      forces[p] += sum;
    }
  });
}

void Springs::addRelativeDamping(const State& state, double beta, Points& forces) const {
  parallelFor(incidence_.size(), kBlock, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      for (const Index* e = incidence_.begin(p); e != incidence_.end(p); ++e) {
        const Index s = *e >= 0 ? *e : ~*e, other = *e >= 0 ? links_[s].second : links_[s].first;
        sum += stiffness_[s] * (state.velocities[other] - state.velocities[p]);
      }
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
  double worst = 0.0;
  for (std::size_t s = 0; s < links_.size(); ++s) {
    const double length = (state.positions[links_[s].second] - state.positions[links_[s].first]).norm();
    worst = std::max(worst, std::abs(length / rest_length_[s] - 1.0));
  }
  return worst;
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
