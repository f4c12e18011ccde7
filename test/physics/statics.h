// Equilibria of a model under loads, for tests against closed forms; and a chain of springs as a model of its own.
#pragma once

#include "../support/surfaces.h"
#include "deformable_surface/model/mass_spring/springs.h"
#include "deformable_surface/simulation/loads.h"
#include "deformable_surface/solve/integrator.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {

using model::State;

/// The equilibrium under the loads, from the given positions; fails the test if the solver does not converge.
inline Points solveStatics(const model::DeformableModel& model, const std::vector<const solve::ExternalLoad*>& loads,
                           const std::vector<char>& held, const Points& start, double tolerance = 1e-8) {
  const solve::System system(model, loads, held, 0.0);
  solve::IntegratorParams params;
  params.tolerance = tolerance;
  params.max_iterations = 1000;
  State state{start, Points(start.size(), Vec3::Zero())};
  const auto report = solve::makeIntegrator(solve::IntegratorType::kStatic, params)->advance(system, 0.0, 0.01, 1.0, state);
  EXPECT_TRUE(report.converged) << "residual " << report.residual << " N after " << report.iterations << " iterations";
  return state.positions;
}

/// Springs between consecutive points, all of one stiffness.
class Chain : public model::DeformableModel, public model::StiffnessMatrix {
 public:
  Chain(const Points& rest, double stiffness, double mass_per_point) : masses_(rest.size(), mass_per_point) {
    std::vector<std::pair<Index, Index>> links;
    for (Index i = 0; i + 1 < static_cast<Index>(rest.size()); ++i) links.emplace_back(i, i + 1);
    const std::vector<double> k(links.size(), stiffness);
    springs_ = model::Springs(links, rest, k);
  }
  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<Chain>(*this); }
  const model::StiffnessMatrix* stiffnessMatrix() const override { return this; }
  const std::vector<double>& masses() const override { return masses_; }
  void addForces(const State& s, Points& forces) const override {
    PaddedPoints positions;
    positions.assign(s.positions);
    springs_.addForces(s, positions, true, 0.0, forces);
  }
  double elasticEnergy(const State& s) const override { return springs_.energy(s); }
  void addStiffness(const State& s, double step, model::Hessian hessian, BlockSparse& k) const override {
    springs_.addStiffness(s, true, 0.0, step, hessian, k);
  }
  void addRowBounds(const State&, std::vector<double>& k, std::vector<double>& c) const override {
    springs_.addRowBounds(true, 0.0, k, c);
  }

 private:
  std::vector<double> masses_;
  model::Springs springs_;
};

}  // namespace deformable_surface::test
