// Newton's direction from products alone, against the equations that it must satisfy.
#include "../../src/solve/product_solver.h"

#include <gtest/gtest.h>

#include "oscillators.h"

namespace deformable_surface::test {
namespace {

// A row of points with a spring between neighbours, the same in every direction. Only products with the stiffness are available.
class Row : public Oscillators, public model::StiffnessProducts {
 public:
  Row(Index n, double stiffness) : Oscillators(std::vector<double>(n, 0.0), 1.0) {
    for (Index i = 0; i + 1 < n; ++i) couplings_.push_back({i, i + 1, stiffness});
  }
  const model::StiffnessMatrix* stiffnessMatrix() const override { return nullptr; }
  const model::StiffnessProducts* stiffnessProducts() const override { return this; }
  void prepareStiffness(const State&, model::Hessian) const override {}
  void addStiffnessProduct(const Points& v, Points& product) const override {
    for (const model::Coupling& c : couplings_) {
      product[c.i] += sign * c.stiffness * (v[c.i] - v[c.j]);
      product[c.j] += sign * c.stiffness * (v[c.j] - v[c.i]);
    }
  }
  const std::vector<model::Coupling>& couplings() const override { return couplings_; }

  double sign = 1.0;

 private:
  std::vector<model::Coupling> couplings_;
};

struct Setting {
  explicit Setting(double sign = 1.0) {
    row.sign = sign;
    held[0] = held[kPoints - 1] = 1;
    for (Index i = 0; i < kPoints; ++i) gradient.emplace_back(std::sin(0.7 * i), 1.0, 0.1 * i);
    solver.prepare(system, 0.0, state, 0.0, model::Hessian::kExact, weight);
  }
  // (K + W) d + g on a free point.
  Vec3 residual(Index i) const {
    return 50.0 * (2.0 * direction[i] - direction[i - 1] - direction[i + 1]) + weight[i] * direction[i] + gradient[i];
  }

  static constexpr Index kPoints = 40;
  Row row{kPoints, 50.0};
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held = std::vector<char>(kPoints, 0);
  solve::System system{row, loads, held, 0.0};
  State state{Points(kPoints, Vec3::Zero()), Points(kPoints, Vec3::Zero())};
  std::vector<double> weight = std::vector<double>(kPoints, 3.0);
  Points gradient, direction;
  solve::ProductSolver solver;
};

TEST(ProductSolver, LeavesNoMoreThanWasAllowedOnAnyFreePoint) {
  for (const double enough : {1e-1, 1e-6}) {
    Setting s;
    ASSERT_TRUE(s.solver.solve(s.system, s.gradient, enough, nullptr, s.direction));
    for (Index i = 1; i + 1 < Setting::kPoints; ++i) EXPECT_LE(s.residual(i).norm(), enough * 1.01) << i;
    EXPECT_TRUE(s.direction.front().isZero(0.0));
    EXPECT_TRUE(s.direction.back().isZero(0.0));
  }
}

TEST(ProductSolver, TellsWhereTheMatrixIsNotPositiveAndStillGoesDownhill) {
  Setting s(-1.0);
  EXPECT_FALSE(s.solver.solve(s.system, s.gradient, 1e-6, nullptr, s.direction));
  double slope = 0.0;
  for (Index i = 0; i < Setting::kPoints; ++i) slope += s.direction[i].dot(s.gradient[i]);
  EXPECT_LT(slope, 0.0);
}

TEST(ProductSolver, StopsWhenInterrupted) {
  Setting s;
  const std::atomic<bool> stop{true};
  EXPECT_TRUE(s.solver.solve(s.system, s.gradient, 1e-6, &stop, s.direction));
  for (const Vec3& d : s.direction) EXPECT_TRUE(d.isZero(0.0));
}

}  // namespace
}  // namespace deformable_surface::test
