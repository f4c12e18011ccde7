// The path of the static solver to an equilibrium far from its start.
#include "statics.h"

#include <algorithm>

namespace deformable_surface::test {
namespace {

// A chain of stiff springs, level and held at one end. It swings down by a quarter turn, and every large step stretches it.
struct LevelChain {
  LevelChain() : chain(makeLevel(), 1e6, 0.01), gravity(chain.masses(), Vec3(0.0, 0.0, -9.81)), held(chain.masses().size(), 0) {
    held[0] = 1;
  }

  static Points makeLevel() {
    Points points;
    for (Index i = 0; i <= 20; ++i) points.emplace_back(0.05 * i, 0.0, 0.0);
    return points;
  }

  solve::SolveReport solve(Index max_iterations) {
    solve::IntegratorParams params;
    params.max_iterations = max_iterations;
    state = {makeLevel(), Points(held.size(), Vec3::Zero())};
    return solve::makeIntegrator(solve::IntegratorType::kStatic, params)->advance(system, 0.0, 0.01, 1.0, state);
  }

  Chain chain;
  simulation::GravityLoad gravity;
  std::vector<const solve::ExternalLoad*> loads{&gravity};
  std::vector<char> held;
  solve::System system{chain, loads, held, 0.0};
  State state;
};

TEST(StaticSolver, SwingsAStiffChainDownInFewIterations) {
  LevelChain level;
  const solve::SolveReport report = level.solve(1000);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(level.state.positions.back().z(), -1.0, 1e-4);
  // Half as many again as it needs. A solver that never lets the energy rise needs three times as many.
  EXPECT_LT(report.iterations, 80);
}

TEST(StaticSolver, WhereverItIsStoppedTheEnergyIsNoHigherThanBefore) {
  LevelChain level;
  const Index enough = level.solve(1000).iterations;
  double before = level.system.potentialEnergy(0.0, {LevelChain::makeLevel(), {}});
  for (Index k = 1; k < enough; ++k) {
    const solve::SolveReport report = level.solve(k);
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, k);
    const double energy = level.system.potentialEnergy(0.0, level.state);
    EXPECT_LE(energy, before) << k;
    before = energy;
    Points forces;
    level.system.computeForces(0.0, level.state, forces);
    double largest = 0.0;
    for (const Vec3& force : forces) largest = std::max(largest, force.norm());
    EXPECT_DOUBLE_EQ(report.residual, largest) << k;
  }
}

}  // namespace
}  // namespace deformable_surface::test
