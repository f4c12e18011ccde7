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
  double find() { return solve::StableStep().estimate(0.0, state, system); }

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
  const double viscosity = 6.0, rate = viscosity / 0.25, z = 0.5 * rate / 60.0;
  Setting s(viscosity);
  const double expected = 2.0 / 60.0 * (std::sqrt(1.0 + z * z) - z);
  EXPECT_LE(s.find(), expected * (1.0 + 1e-12));
  EXPECT_GE(s.find(), expected * (1.0 - kBound));
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
