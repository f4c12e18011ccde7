// Equilibria by quasi-Newton steps: those of Newton's method, or none with nothing moved. And their initial springs.
#include "../../src/solve/quasi_newton.h"

#include "../physics/statics.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>

namespace deformable_surface::test {
namespace {

constexpr double kTolerance = 1e-6;

// A jittered sheet under its weight, held on both edges across x or on the first.
struct Sheet {
  Sheet(double young_modulus, bool is_held_twice, double thickness = 0.002, Surface sheet = makeSheet(12, 12, 1.0, 1.0, 0.2))
      : surface(std::move(sheet)) {
    material.young_modulus = young_modulus;
    material.thickness = thickness;
    model = std::make_unique<model::MassSpring>(surface.points, surface.normals, surface.rings, surface.area, false, material,
                                                model::MassSpringParams{});
    for (const Vec3& p : surface.points) held.push_back(p.x() < 1e-9 || (is_held_twice && p.x() > 1.0 - 1e-9));
    model->setHeld(held, {});
    gravity = std::make_unique<simulation::GravityLoad>(model->masses(), Vec3(0.0, 0.0, -9.81));
    loads.push_back(gravity.get());
  }
  solve::System system() const { return {*model, loads, held, 0.0}; }
  State flat() const { return {surface.points, Points(surface.points.size(), Vec3::Zero())}; }

  Surface surface;
  model::MaterialParams material;
  std::unique_ptr<model::MassSpring> model;
  std::unique_ptr<simulation::GravityLoad> gravity;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held;
};

std::vector<double> noRounding(const State& state) { return std::vector<double>(state.positions.size(), 0.0); }

double measureLargest(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// The same surface without known springs: the static solver has to take Newton steps.
class Secretive : public model::MassSpring {
 public:
  explicit Secretive(const model::MassSpring& of) : model::MassSpring(of) {}
  bool findCouplings(const State&, double, std::vector<model::Coupling>&, std::vector<model::Coupling>&) const override {
    return false;
  }
};

// There an iteration of Newton's method costs as much as hundreds of these.
TEST(QuasiNewton, IsNotGivenUpOnManyPointsForForcesThatRiseBeforeTheyFall) {
  const Sheet sheet(1e10, true, 0.001, makeSheet(75, 75, 1.0, 1.0, 0.2));
  const solve::System system = sheet.system();
  solve::QuasiNewton quasi_newton;
  solve::SolveReport report;
  State state = sheet.flat();
  ASSERT_TRUE(quasi_newton.solve(system, 0.0, kTolerance, noRounding(state), nullptr, state, report));
  EXPECT_GT(report.iterations, 30);
  EXPECT_LT(report.iterations, 200);
}

TEST(QuasiNewton, FindsTheEquilibriumThatNewtonFindsHoweverStiffTheSheet) {
  for (const double young_modulus : {1e5, 1e7, 1e9}) {
    const Sheet sheet(young_modulus, true);
    const solve::System system = sheet.system();
    solve::QuasiNewton quasi_newton;
    solve::SolveReport report;
    State state = sheet.flat();
    ASSERT_TRUE(quasi_newton.solve(system, 0.0, kTolerance, noRounding(state), nullptr, state, report)) << young_modulus;
    Points forces;
    system.computeForces(0.0, state, forces);
    double largest = 0.0;
    for (const Vec3& force : forces) largest = std::max(largest, force.norm());
    EXPECT_DOUBLE_EQ(report.residual, largest);
    Points again;
    EXPECT_EQ(system.computeForcesAndLargest(0.0, state, again), system.largestForce(0.0, state));
    EXPECT_EQ(again, forces);
    EXPECT_GT(system.largestForce(0.0, state), largest);  // a load that the material carries is no imbalance
    EXPECT_LE(largest, kTolerance * system.largestForce(0.0, state)) << young_modulus;
    EXPECT_LT(report.iterations, 100) << young_modulus;
    const Points expected = solveStatics(Secretive(*sheet.model), sheet.loads, sheet.held, sheet.surface.points);
    EXPECT_LT(measureLargest(state.positions, expected), 1e-5 * measureLargest(expected, sheet.surface.points)) << young_modulus;
    // It is already in equilibrium.
    const Index iterations = report.iterations;
    EXPECT_TRUE(quasi_newton.solve(system, 0.0, kTolerance, noRounding(state), nullptr, state, report));
    EXPECT_EQ(report.iterations, iterations);
  }
}

// At rest it counts as a membrane, in its equilibrium as a plate. The springs of the two join different pairs.
TEST(QuasiNewton, FindsThatOfAPlateToo) {
  const Sheet plate(1e9, true, 0.05);
  const solve::System system = plate.system();
  solve::QuasiNewton quasi_newton;
  solve::SolveReport report;
  State state = plate.flat();
  ASSERT_TRUE(quasi_newton.solve(system, 0.0, kTolerance, noRounding(state), nullptr, state, report));
  EXPECT_LT(report.iterations, 60);
  std::vector<solve::System::Coupling> along, across;
  ASSERT_TRUE(system.findCouplings(state, 1.0, along, across));
  EXPECT_GT(across.size(), along.size());
  const Points expected = solveStatics(Secretive(*plate.model), plate.loads, plate.held, plate.surface.points);
  EXPECT_LT(measureLargest(state.positions, expected), 1e-4 * measureLargest(expected, plate.surface.points));
}

TEST(QuasiNewton, GivesTheSameBitsAgainWhateverItSolvedBefore) {
  const Sheet sheet(1e6, true), other(1e8, true);
  solve::QuasiNewton fresh, used;
  solve::SolveReport report;
  State first = sheet.flat(), second = sheet.flat(), third = other.flat();
  ASSERT_TRUE(used.solve(other.system(), 0.0, kTolerance, noRounding(third), nullptr, third, report));
  ASSERT_TRUE(used.solve(sheet.system(), 0.0, kTolerance, noRounding(first), nullptr, first, report));
  ASSERT_TRUE(fresh.solve(sheet.system(), 0.0, kTolerance, noRounding(second), nullptr, second, report));
  EXPECT_EQ(first.positions, second.positions);
}

TEST(QuasiNewton, MovesNothingWhereItLeadsNowhereAndTheStaticSolverGoesOn) {
  const Sheet sheet(1e9, false);  // it swings down by a quarter turn
  const solve::System system = sheet.system();
  solve::QuasiNewton quasi_newton;
  solve::SolveReport report;
  State state = sheet.flat();
  EXPECT_FALSE(quasi_newton.solve(system, 0.0, kTolerance, noRounding(state), nullptr, state, report));
  EXPECT_EQ(state.positions, sheet.surface.points);
  EXPECT_EQ(report.iterations, 0);
  const Points hanging = solveStatics(*sheet.model, sheet.loads, sheet.held, sheet.surface.points, kTolerance);
  for (const Vec3& p : hanging) EXPECT_LT(std::abs(p.x()), 0.05);
}

TEST(QuasiNewton, EndsUnmovedWhenItIsInterrupted) {
  const Sheet sheet(1e6, true);
  const std::atomic<bool> interrupt{true};
  solve::QuasiNewton quasi_newton;
  solve::SolveReport report;
  State state = sheet.flat();
  EXPECT_FALSE(quasi_newton.solve(sheet.system(), 0.0, kTolerance, noRounding(state), &interrupt, state, report));
  EXPECT_EQ(state.positions, sheet.surface.points);
}

// sum k (w_i - w_j)^2
double sumSprings(const std::vector<solve::System::Coupling>& springs, const Points& w) {
  double sum = 0.0;
  for (const auto& spring : springs) sum += spring.stiffness * (w[spring.i] - w[spring.j]).squaredNorm();
  return sum;
}

double sumStiffness(const solve::System& system, const State& state, const Points& w) {
  BlockSparse stiffness;
  stiffness.begin(system.size());
  system.addStiffness(0.0, state, 0.0, model::Hessian::kPositive, stiffness);
  stiffness.finish();
  const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(w.data()->data(), 3 * system.size());
  Eigen::VectorXd product;
  stiffness.multiply(x, product);
  return x.dot(product);
}

TEST(Couplings, ResistAsTheStiffnessDoes) {
  Sheet sheet(1e6, true);
  const solve::System system = sheet.system();
  State state = sheet.flat();
  const Index n = state.size();
  std::mt19937 generator(2);
  Points across(n), along(n);
  for (Index i = 0; i < n; ++i) {
    across[i] = Vec3(0.0, 0.0, uniform(generator));
    along[i] = Vec3(uniform(generator), uniform(generator), 0.0);
  }
  std::vector<solve::System::Coupling> springs_along, springs_across;
  // At rest it counts as the membrane that it will become when it sags.
  ASSERT_TRUE(system.findCouplings(state, 1.0, springs_along, springs_across));
  EXPECT_NEAR(sumSprings(springs_across, across) / sumSprings(springs_along, across), 1.0, 1e-5);
  // With almost no tension it only bends; the rest is almost nothing.
  const double flat = sumStiffness(system, state, across);
  State taut = state;
  for (Vec3& p : taut.positions) p *= 1.0 + 1e-8;
  ASSERT_TRUE(system.findCouplings(taut, 1.0, springs_along, springs_across));
  EXPECT_NEAR(sumSprings(springs_across, across), flat + 1e-6 * sumSprings(springs_along, across),
              1e-7 * sumSprings(springs_along, across));
  // The springs resist motion along it 0.6 to 1.6 times as much, for every wave.
  EXPECT_NEAR(sumSprings(springs_along, along) / sumStiffness(system, state, along), 1.0, 0.6);
  // The tension of an even stretch counts twice: once as it is and once as its mean.
  for (Vec3& p : state.positions) p *= 1.1;
  const double stretched = sumStiffness(system, state, across);
  ASSERT_TRUE(system.findCouplings(state, 1.0, springs_along, springs_across));
  EXPECT_NEAR(sumSprings(springs_across, across), 2.0 * stretched, 0.1 * stretched);
  EXPECT_EQ(springs_across.size(), springs_along.size());  // bending is next to nothing beside it
  // Less of the mean on demand.
  const double full = sumSprings(springs_across, across);
  ASSERT_TRUE(system.findCouplings(state, 0.3, springs_along, springs_across));
  EXPECT_NEAR(sumSprings(springs_across, across), 0.65 * full, 1e-3 * full);
  // Twice the stiffness of the material, twice that of the springs.
  sheet.model->setMaterial(std::vector<model::PointMaterial>(n, {2.0, 2.0, 1.0}));
  ASSERT_TRUE(system.findCouplings(state, 1.0, springs_along, springs_across));
  EXPECT_NEAR(sumSprings(springs_across, across), 2.0 * full, 1e-9 * full);
}

}  // namespace
}  // namespace deformable_surface::test
