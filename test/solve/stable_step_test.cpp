// The stable step against oscillators, whose frequencies are known.
#include "deformable_surface/solve/stable_step.h"

#include <gtest/gtest.h>

#include <cmath>

#include "oscillators.h"

namespace deformable_surface::test {
namespace {

// A spring to its present place on the first point.
class Spring : public solve::ExternalLoad {
 public:
  void addForces(double, const State&, Points&) const override {}
  void addStiffness(double, const State&, double, BlockSparse& matrix) const override {
    matrix.add(0, 0, stiffness * Mat3::Identity());
  }
  void addRowBounds(double, const State&, std::vector<double>& bounds, std::vector<double>&) const override {
    bounds[0] += stiffness;
  }

  double stiffness = 0.0;  // N/m
};

struct Setting {
  explicit Setting(double viscosity = 0.0)
      : model({4.0, 900.0, 100.0}, 0.25, viscosity), system(model, loads, held, 0.0), state{Points(3), Points(3, Vec3::Zero())} {
    state.positions.assign(3, Vec3::Zero());
  }
  double find(bool splits = false) { return solve::StableStep().estimate(0.0, state, system, splits); }

  Oscillators model;  // frequencies 4, 60, 20 1/s
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0, 0, 0};
  solve::System system;
  State state;
};

constexpr double kBound = 1e-2;  // of Lanczos's bound, which makes the step shorter, never longer

TEST(StableStep, IsTwoOverTheHighestFrequencyOfWhatIsFree) {
  Setting s;
  EXPECT_LE(s.find(), 2.0 / 60.0 * (1.0 + 1e-12));
  EXPECT_GE(s.find(), 2.0 / 60.0 * (1.0 - kBound));
  s.held[1] = 1;
  EXPECT_LE(s.find(), 2.0 / 20.0 * (1.0 + 1e-12));
  EXPECT_GE(s.find(), 2.0 / 20.0 * (1.0 - kBound));
  s.held = {1, 1, 1};
  EXPECT_TRUE(std::isinf(s.find()));
}

TEST(StableStep, CountsTheStiffnessOfLoads) {
  Setting s;
  Spring spring;
  spring.stiffness = 2496.0;  // with the 4 N/m of the model 100 1/s
  s.loads.push_back(&spring);
  EXPECT_LE(s.find(), 2.0 / 100.0 * (1.0 + 1e-12));
  EXPECT_GE(s.find(), 2.0 / 100.0 * (1.0 - kBound));
}

TEST(StableStep, IsShorterByDampingThatReadsPredictedVelocities) {
  const double viscosity = 6.0, rate = viscosity / 0.25, z = rate / 60.0;
  Setting s(viscosity);
  const double expected = 2.0 / 60.0 * (std::sqrt(1.0 + z * z) - z);
  EXPECT_LE(s.find(), expected * (1.0 + 1e-12));
  EXPECT_GE(s.find(), expected * (1.0 - kBound));
}

TEST(StableStep, EndsAtTwoOverTheRateOfDampersThatAreSplitOff) {
  for (const double rate : {6.0, 59.0, 61.0, 600.0}) {
    Setting s;
    const SplitDamper damper(0.25 * rate);
    s.loads.push_back(&damper);
    const double expected = 2.0 / std::max(60.0, rate), whole = s.find(true), shortened = s.find(false), z = rate / 60.0;
    EXPECT_LE(whole, expected * (1.0 + 1e-12)) << rate;
    EXPECT_GE(whole, expected * (1.0 - kBound)) << rate;
    EXPECT_LE(shortened, 2.0 / 60.0 * (std::sqrt(1.0 + z * z) - z) * (1.0 + 1e-12)) << rate;
  }
}

TEST(StableStep, CountsTheStiffnessOfLoadsThatAreSplitOff) {
  Setting s;
  const SplitDamper damper(0.1, 0.25 * 6400.0);
  s.loads.push_back(&damper);
  EXPECT_LE(s.find(true), 2.0 / 100.0 * (1.0 + 1e-12));
  EXPECT_GE(s.find(true), 2.0 / 100.0 * (1.0 - kBound));
}

// Slow springs to the origin, whose stiffness counts, and a bound of theirs that is too high.
class Slowed : public SlowerOscillators {
 public:
  Slowed(double slow, double bound) : SlowerOscillators({4.0, 900.0, 100.0}, slow, 0.25), slow_(slow), bound_(bound) {}
  void addStiffness(const State& s, double step, model::Hessian hessian, BlockSparse& k) const override {
    addFastStiffness(s, step, hessian, k);
    ++slow_matrices;
    for (Index i = 0; i < s.size(); ++i) k.add(i, i, slow_ * Mat3::Identity());
  }
  double boundSlowRate(const State&) const override { return bound_ * slow_ / 0.25; }

  mutable int slow_matrices = 0;

 private:
  double slow_, bound_;
};

TEST(StableStep, BoundsSlowForcesWhereTheyAreFaintAndMeasuresThemElsewhere) {
  Spring spring;  // on the softest point
  spring.stiffness = 4000.0;
  // Beside a load with a stiffness on a free point they are measured, too.
  for (const bool is_loaded : {false, true})
    for (const double slow : {1.0, 35.9, 36.1, 900.0})
      for (const double bound : {1.0, 3.0}) {
        const Slowed model(slow, bound);
        std::vector<const solve::ExternalLoad*> loads;
        if (is_loaded) loads.push_back(&spring);
        std::vector<char> held{0, 0, 0};
        const solve::System system(model, loads, held, 0.0);
        const State state{Points(3, Vec3::Zero()), Points(3, Vec3::Zero())};
        const auto findExpected = [&](double fast) { return 2.0 / std::sqrt((fast + slow) / 0.25); };
        solve::StableStep estimator;
        for (const double fast : {is_loaded ? 4004.0 : 900.0, 100.0}) {
          const double step = estimator.estimate(0.0, state, system);
          EXPECT_LE(step, findExpected(fast) * (1.0 + 1e-12)) << slow;
          EXPECT_GE(step, findExpected(fast) * (1.0 - kBound)) << slow;
          model.slow_matrices = 0;
          EXPECT_EQ(estimator.estimate(0.0, state, system), step);
          EXPECT_EQ(model.slow_matrices, !(is_loaded && fast > 900.0) && bound * slow <= 0.04 * fast ? 0 : 1) << slow;
          held = {1, 1, 0};  // points that are held do not count
        }
      }
}

// For chained oscillators a bound and a measurement would differ. These are diagonal, so the bound is exact.
class WithoutMatrix : public Oscillators {
 public:
  using Oscillators::Oscillators;
  const model::StiffnessMatrix* stiffnessMatrix() const override { return nullptr; }
};

TEST(StableStep, ComesFromRowBoundsWithoutAStiffnessMatrix) {
  const WithoutMatrix model({4.0, 900.0, 100.0}, 0.25);
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0, 0, 0};
  const solve::System system(model, loads, held, 0.0);
  const State state{Points(3, Vec3::Zero()), Points(3, Vec3::Zero())};
  EXPECT_DOUBLE_EQ(solve::StableStep().estimate(0.0, state, system), 2.0 / 60.0);
  Spring spring;
  spring.stiffness = 2496.0;  // with the 4 N/m of the model 100 1/s
  loads.push_back(&spring);
  EXPECT_DOUBLE_EQ(solve::StableStep().estimate(0.0, state, system), 2.0 / 100.0);
  held = {1, 1, 0};
  EXPECT_DOUBLE_EQ(solve::StableStep().estimate(0.0, state, system), 2.0 / 20.0);
}

}  // namespace
}  // namespace deformable_surface::test
