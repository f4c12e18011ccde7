// Points with orientation, against a torsion pendulum, whose motion is known.
#include "../../src/solve/oriented_integrators.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using model::State;

// One point on a spring to the origin, whose turn from the identity is resisted by a torsion spring: torque = -k theta.
class Pendulum : public model::DeformableModel, public model::OrientedPoints {
 public:
  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<Pendulum>(*this); }
  const model::OrientedPoints* orientedPoints() const override { return this; }
  const std::vector<double>& masses() const override { return masses_; }
  const std::vector<double>& inertias() const override { return inertias_; }
  bool forcesReadVelocities() const override { return false; }
  static Vec3 angle(const State& s) {
    const Eigen::AngleAxisd turn(s.orientations[0]);
    return turn.angle() * turn.axis();
  }
  void addForces(const State& s, Points& forces) const override { forces[0] -= kSpring * s.positions[0]; }
  void addForcesAndTorques(const State& s, Points& forces, Points& torques) const override {
    ++evaluations;
    addForces(s, forces);
    torques[0] -= kTorsion * angle(s);
  }
  double elasticEnergy(const State& s) const override {
    return 0.5 * kSpring * s.positions[0].squaredNorm() + 0.5 * kTorsion * angle(s).squaredNorm();
  }
  void addRowBounds(const State&, std::vector<double>& stiffness, std::vector<double>&) const override {
    stiffness[0] += kSpring;
  }

  mutable int evaluations = 0;
  static constexpr double kSpring = 8.0, kTorsion = 0.5;  // N/m, N m: 2 and 5 rad/s

 private:
  std::vector<double> masses_{2.0}, inertias_{0.02};
};

struct Setting {
  State state = [] {
    State s{{Vec3(0.1, 0.0, 0.0)}, {Vec3::Zero()}};
    s.orientations = {Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitZ()))};
    s.spins = {Vec3::Zero()};
    s.traits.resize(1);
    return s;
  }();
  Pendulum model;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0};
  solve::System system{model, loads, held, 0.0};
};

double errorAfterASecond(int steps) {
  Setting s;
  solve::IntegratorParams params;
  const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, params, true);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(verlet->advance(s.system, k * 1.0 / steps, 1.0 / steps, 1.0, s.state).finite);
  EXPECT_NEAR(s.state.positions[0].x(), 0.1 * std::cos(2.0), 0.1 * 16.0 / steps / steps);
  return std::abs(Pendulum::angle(s.state).dot(Vec3::UnitZ()) - 0.3 * std::cos(5.0));
}

TEST(OrientedVerlet, IsOfSecondOrder) {
  const double coarse = errorAfterASecond(100), fine = errorAfterASecond(200);
  EXPECT_LT(coarse, 0.3 * 25.0 / 100 / 100 * 5.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
}

TEST(OrientedVerlet, DoesNotTurnPointsWhoseTurnIsHeld) {
  Setting s;
  s.state.positions[0].setZero();
  s.state.orientations[0] = Quaternion::Identity();
  s.state.spins[0] = Vec3(0.0, 0.3, 0.4);
  std::vector<char> turns{1};
  const solve::System held(s.model, s.loads, s.held, 0.0, &turns);
  solve::IntegratorParams params;
  const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, params, true);
  verlet->advance(held, 0.0, 0.1, 1.0, s.state);
  EXPECT_TRUE(s.state.orientations[0].isApprox(Quaternion::Identity(), 0.0));
}

// A step begins where the last one ended: the model is asked again only if something has changed in between, and the bits are
// the same whether it is or not.
TEST(OrientedVerlet, KnowsTheForcesOfTheStateThatItsStepEndedWithToTheBit) {
  Setting known, asked;
  solve::IntegratorParams params;
  const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, params, true);
  for (int k = 0; k < 5; ++k) {
    known.model.evaluations = 0;
    ASSERT_TRUE(verlet->advance(known.system, 0.1 * k, 0.1, 0.05, known.state).finite);
    EXPECT_EQ(known.model.evaluations, k == 0 ? 5 : 4) << k;
    const auto other = solve::makeIntegrator(solve::IntegratorType::kVerlet, params, true);
    ASSERT_TRUE(other->advance(asked.system, 0.1 * k, 0.1, 0.05, asked.state).finite);
    EXPECT_EQ(known.state.positions, asked.state.positions);
    EXPECT_EQ(known.state.velocities, asked.state.velocities);
    EXPECT_EQ(known.state.spins, asked.state.spins);
    EXPECT_EQ(known.state.orientations[0].coeffs(), asked.state.orientations[0].coeffs());
  }
  Points taken, found;
  ASSERT_TRUE(verlet->takeLastForces(known.system, known.state, taken));
  known.system.computeForcesOnAll(0.5, known.state, found);
  EXPECT_EQ(taken, found);

  const auto countAfter = [&](const auto& change) {
    change();
    known.model.evaluations = 0;
    verlet->advance(known.system, 0.5, 0.1, 0.05, known.state);
    return known.model.evaluations;
  };
  EXPECT_EQ(countAfter([&] { known.state.positions[0].x() += 1e-3; }), 5);
  EXPECT_EQ(countAfter([&] { known.state.orientations[0] = Quaternion::Identity(); }), 5);
  EXPECT_EQ(countAfter([&] { verlet->forgetForces(); }), 5);
  EXPECT_EQ(countAfter([&] { known.state.velocities[0].x() += 1e-3; }), 4);
}

TEST(FireRelaxation, EndsAtRestWhereNothingPullsOrTurns) {
  Setting s;
  solve::IntegratorParams params;
  params.tolerance = 1e-8;
  const auto fire = solve::makeIntegrator(solve::IntegratorType::kStatic, params, true);
  const solve::SolveReport report = fire->advance(s.system, 0.0, 1.0, 2.0 / 5.0, s.state);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(s.state.positions[0].norm(), 1e-8);
  EXPECT_LT(Pendulum::angle(s.state).norm(), 1e-8);
  EXPECT_TRUE(s.state.velocities[0].isZero(0.0));
  EXPECT_TRUE(s.state.spins[0].isZero(0.0));
}

TEST(FireRelaxation, SaysWhenItRanOutOfIterations) {
  Setting s;
  solve::IntegratorParams params;
  params.tolerance = 1e-12;
  params.max_iterations = 1;
  const auto fire = solve::makeIntegrator(solve::IntegratorType::kStatic, params, true);
  const solve::SolveReport report = fire->advance(s.system, 0.0, 1.0, 1e-3, s.state);
  EXPECT_FALSE(report.converged);
  EXPECT_TRUE(report.is_out_of_iterations);
  EXPECT_GT(report.unbalanced, 0.0);
}

}  // namespace
}  // namespace deformable_surface::test
