// Newton's descent where the path is known: one iteration on a quadratic energy, and out of a region of negative curvature.
#include "../../src/solve/newton.h"

#include <gtest/gtest.h>

#include "oscillators.h"

namespace deformable_surface::test {
namespace {

struct Descent {
  Descent(const model::DeformableModel& model, std::vector<const solve::ExternalLoad*> acting, Points start)
      : loads(std::move(acting)),
        held(start.size(), 0),
        system(model, loads, held, 0.0),
        state{start, Points(start.size(), Vec3::Zero())},
        before(std::move(start)),
        weight(before.size(), 0.0) {
    newton.begin(nullptr);
  }
  solve::NewtonDescent::Problem problem() const { return {system, 0.0, 0.0, before, before, weight, rounding}; }
  double evaluate() { return newton.evaluate(problem(), state); }
  solve::NewtonDescent::Step descend() { return newton.descend(problem(), state); }

  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held;
  solve::System system;
  State state;
  Points before;
  std::vector<double> weight;                                         // N/m
  std::vector<double> rounding = std::vector<double>(weight.size());  // N
  solve::NewtonDescent newton;
};

TEST(NewtonDescent, EndsAQuadraticInOneWholeStep) {
  const Oscillators model({4.0, 900.0}, 0.25);
  const ConstantField field(model.masses(), Vec3(0.0, 0.0, -8.0));
  Descent d(model, {&field}, Points(2, Vec3::Zero()));
  EXPECT_DOUBLE_EQ(d.evaluate(), 2.0);  // 0.25 kg in the field
  const solve::NewtonDescent::Step step = d.descend();
  EXPECT_EQ(step.fraction, 1.0);
  EXPECT_FALSE(step.raised);
  // Without weights a billionth of the largest stiffness keeps the matrix regular.
  EXPECT_NEAR(d.evaluate(), 0.0, 1e-6);
  EXPECT_NEAR(d.state.positions[0].z(), -2.0 / 4.0, 1e-6);
  EXPECT_NEAR(d.state.positions[1].z(), -2.0 / 900.0, 1e-9);
}

// A force without a potential: the rate (N/m) times the distance from the z axis, around it.
class Swirl : public solve::ExternalLoad {
 public:
  explicit Swirl(double rate) : rate_(rate) {}
  void addForces(double, const State& state, Points& forces) const override {
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += rate_ * Vec3::UnitZ().cross(state.positions[i]);
  }
  void addSkewProduct(double, const State&, const Points& v, Points& product) const override {
    for (std::size_t i = 0; i < v.size(); ++i) product[i] -= rate_ * Vec3::UnitZ().cross(v[i]);
  }
  bool hasSkewStiffness() const override { return true; }

 private:
  double rate_;
};

TEST(NewtonDescent, EndsInOneStepUnderALinearForceWithoutAPotential) {
  const Oscillators model({4.0, 8.0}, 0.25);
  const ConstantField field(model.masses(), Vec3(8.0, 0.0, 0.0));
  const Swirl swirl(12.0);
  Descent d(model, {&field, &swirl}, Points(2, Vec3::Zero()));
  const double before = d.evaluate();
  EXPECT_EQ(d.descend().fraction, 1.0);
  EXPECT_LT(d.evaluate(), 1e-2 * before);
  EXPECT_LT((d.state.positions[0] - 2.0 / 160.0 * Vec3(4.0, 12.0, 0.0)).norm(), 1e-3);
}

TEST(NewtonDescent, IsHeldBackByTheWeights) {
  const Oscillators model({4.0}, 0.25);
  Descent d(model, {}, {Vec3(1.0, 0.0, 0.0)});
  d.weight[0] = 12.0;  // to where it starts: a quarter of the distance remains for the spring
  d.evaluate();
  d.descend();
  EXPECT_NEAR(d.state.positions[0].x(), 0.75, 1e-8);
}

TEST(NewtonDescent, LeavesHeldPointsWhereTheyAre) {
  const Oscillators model({4.0, 4.0}, 0.25);
  Descent d(model, {}, Points(2, Vec3::UnitX()));
  d.held[1] = 1;
  EXPECT_DOUBLE_EQ(d.evaluate(), 4.0);
  d.descend();
  EXPECT_NEAR(d.state.positions[0].x(), 0.0, 1e-8);
  EXPECT_EQ(d.state.positions[1], Vec3::UnitX());
}

// E = (|x|^2 - 1)^2 / 4: smallest on the unit sphere, with negative curvature within.
class Hollow : public Oscillators {
 public:
  Hollow() : Oscillators({1.0}, 1.0) {}
  void addForces(const State& s, Points& forces) const override {
    forces[0] -= (s.positions[0].squaredNorm() - 1.0) * s.positions[0];
  }
  double elasticEnergy(const State& s) const override { return 0.25 * std::pow(s.positions[0].squaredNorm() - 1.0, 2); }
  void addStiffness(const State& s, double, model::Hessian hessian, BlockSparse& k) const override {
    const Vec3& x = s.positions[0];
    const double around = x.squaredNorm() - 1.0;
    const bool is_raised = hessian == model::Hessian::kPositive && around < 0.0;
    k.add(0, 0, (is_raised ? 0.0 : around) * Mat3::Identity() + 2.0 * x * x.transpose() + 1e-3 * Mat3::Identity());
  }
};

TEST(NewtonDescent, GoesDownEveryStepWhereTheExactMatrixIsNotDefinite) {
  const Hollow model;
  Descent d(model, {}, {Vec3(0.1, 0.02, 0.0)});
  double energy = model.elasticEnergy(d.state);
  for (int k = 0; k < 30 && d.evaluate() > 1e-9; ++k) {
    ASSERT_GT(d.descend().fraction, 0.0) << k;
    const double lower = model.elasticEnergy(d.state);
    EXPECT_LT(lower, energy) << k;
    energy = lower;
  }
  EXPECT_NEAR(d.state.positions[0].norm(), 1.0, 1e-6);
}

}  // namespace
}  // namespace deformable_surface::test
