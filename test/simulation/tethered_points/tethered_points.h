// The smallest model of a user's program: each point is on a spring to its rest position. The mechanics.
#pragma once

#include "deformable_surface/model/deformable_model.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::test {

/// Force on point i: -stiffness (x_i - X_i). Points do not affect each other.
class TetheredPoints : public model::DeformableModel, public model::StiffnessMatrix, public model::Partition {
 public:
  /// rest: (n x 3) m; mass: kg of each point; stiffness: N/m.
  TetheredPoints(Points rest, double mass, double stiffness)
      : rest_(std::move(rest)), masses_(rest_.size(), mass), stiffness_(stiffness) {}

  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<TetheredPoints>(*this); }
  const std::vector<double>& masses() const override { return masses_; }
  const model::StiffnessMatrix* stiffnessMatrix() const override { return this; }
  const model::Partition* partition() const override { return this; }
  bool forcesReadVelocities() const override { return false; }
  void addForces(const model::State& state, Points& forces) const override {
    for (std::size_t i = 0; i < rest_.size(); ++i) forces[i] -= stiffness_ * (state.positions[i] - rest_[i]);
  }
  double elasticEnergy(const model::State& state) const override {
    double energy = 0.0;
    for (std::size_t i = 0; i < rest_.size(); ++i) energy += 0.5 * stiffness_ * (state.positions[i] - rest_[i]).squaredNorm();
    return energy;
  }
  void addStiffness(const model::State&, double, model::Hessian, BlockSparse& stiffness) const override {
    for (Index i = 0; i < static_cast<Index>(rest_.size()); ++i) stiffness.add(i, i, stiffness_ * Mat3::Identity());
  }
  void addRowBounds(const model::State&, std::vector<double>& stiffness, std::vector<double>&) const override {
    for (double& bound : stiffness) bound += stiffness_;
  }
  bool markPartners(const std::vector<Index>& points, std::vector<char>& marked) const override {
    for (const Index i : points) marked[i] = 1;
    return true;
  }
  Part makePart(const std::vector<char>& wanted) const override {
    Part part;
    Points rest;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      if (!wanted[i]) continue;
      part.points.push_back(static_cast<Index>(i));
      rest.push_back(rest_[i]);
    }
    part.model = std::make_unique<TetheredPoints>(std::move(rest), masses_.empty() ? 0.0 : masses_[0], stiffness_);
    return part;
  }

 private:
  Points rest_;
  std::vector<double> masses_;
  double stiffness_;
};

}  // namespace deformable_surface::test
