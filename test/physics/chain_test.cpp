// Springs against closed forms: the hanging column, which is exact, the elastic catenary and the modes of a hanging chain.
#include "deformable_surface/solve/stable_step.h"
#include "statics.h"

#include <cmath>

namespace deformable_surface::test {
namespace {

constexpr double kGravity = 9.81;

TEST(HangingColumn, ExtendsByTheSumOfTheWeightsBelow) {
  // n springs k with masses m at their lower ends: extension m g / k * n (n + 1) / 2. Spring j carries the weight below it.
  const int n = 20;
  const double k = 50.0, m = 0.02, a = 0.05;
  Points rest;
  for (int i = 0; i <= n; ++i) rest.emplace_back(0.0, 0.0, -a * i);
  const Chain chain(rest, k, m);
  std::vector<char> held(rest.size(), 0);
  held[0] = 1;
  const simulation::GravityLoad gravity(chain.masses(), Vec3(0.0, 0.0, -kGravity));
  const Points end = solveStatics(chain, {&gravity}, held, rest, 1e-11);
  EXPECT_NEAR(-end[n].z() - a * n, m * kGravity / k * n * (n + 1) / 2, 1e-9);
  for (int j = 1; j <= n; ++j) EXPECT_NEAR((end[j - 1] - end[j]).norm() - a, (n - j + 1) * m * kGravity / k, 1e-9);
}

// Irvine's elastic catenary between two supports at equal height: position at unstretched arc length s, with horizontal tension
// H.
struct ElasticCatenary {
  double stiffness, weight, length;  // EA (N), total weight (N), unstretched length (m)

  double span(double H) const { return x(length, H); }
  double x(double s, double H) const {
    const double V = 0.5 * weight;
    return H * s / stiffness + H * length / weight * (std::asinh(V / H) - std::asinh((V - weight * s / length) / H));
  }
  double z(double s, double H) const {
    const double V = 0.5 * weight;
    const auto root = [](double q) { return std::sqrt(1.0 + q * q); };
    return weight * s / stiffness * (V / weight - 0.5 * s / length) +
           H * length / weight * (root(V / H) - root((V - weight * s / length) / H));
  }
  double solveTension(double wanted_span) const {
    double low = 1e-6 * weight, high = 1e3 * weight;
    for (int i = 0; i < 200; ++i) {
      const double middle = std::sqrt(low * high);
      (span(middle) < wanted_span ? low : high) = middle;
    }
    return std::sqrt(low * high);
  }
};

TEST(ElasticCatenary, IsApproachedWithTheSquareOfTheSpacing) {
  const double length = 1.2, span = 1.0, weight = 3.0, stiffness = 60.0;
  const ElasticCatenary exact{stiffness, weight, length};
  const double H = exact.solveTension(span);
  std::vector<double> errors;
  for (int n : {16, 32, 64}) {
    Points start, rest;
    for (int i = 0; i <= n; ++i) {
      rest.emplace_back(length * i / n, 0.0, 0.0);
      const double t = static_cast<double>(i) / n;
      start.emplace_back(span * t, 0.0, -1.2 * t * (1.0 - t));
    }
    const Chain chain(rest, stiffness * n / length, weight / kGravity / n);
    std::vector<char> held(rest.size(), 0);
    held.front() = held.back() = 1;
    const simulation::GravityLoad gravity(chain.masses(), Vec3(0.0, 0.0, -kGravity));
    const Points end = solveStatics(chain, {&gravity}, held, start, 1e-9);
    double worst = 0.0;
    for (int i = 0; i <= n; ++i) {
      const double s = length * i / n;
      worst = std::max(worst, std::hypot(end[i].x() - exact.x(s, H), end[i].z() + exact.z(s, H)));
    }
    errors.push_back(worst);
  }
  EXPECT_LT(errors[2], 2e-4);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.15);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2.0, 0.15);
}

TEST(HangingChain, SwingsWithTheFrequencyOfTheBesselRoot) {
  // Lowest mode of an inextensible hanging chain: w = (j01 / 2) sqrt(g / L). [exact; j01 = 2.404825558]
  const int n = 60;
  const double length = 1.0, mass = 0.5 / n, amplitude = 1e-4;
  Points rest;
  for (int i = 0; i <= n; ++i) rest.emplace_back(0.0, 0.0, -length * i / n);
  const Chain chain(rest, 2e4, mass);
  std::vector<char> held(rest.size(), 0);
  held[0] = 1;
  const simulation::GravityLoad gravity(chain.masses(), Vec3(0.0, 0.0, -kGravity));
  const std::vector<const solve::ExternalLoad*> loads{&gravity};
  Points start = solveStatics(chain, loads, held, rest, 1e-10);
  // The mode's shape is J0(j01 sqrt(z / L)) with z from the free end; it vanishes at the support.
  for (int i = 0; i <= n; ++i)
    start[i].x() = amplitude * std::cyl_bessel_j(0.0, 2.404825558 * std::sqrt(static_cast<double>(n - i) / n));
  start[0].x() = 0.0;
  const solve::System system(chain, loads, held, 0.0);
  State state{start, Points(start.size(), Vec3::Zero())};
  solve::StableStep stable;
  const double limit = stable.estimate(0.0, state, system);
  const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, {});
  // Time of the first passage of the free end through zero: a quarter period.
  double time = 0.0, previous = state.positions[n].x();
  const double step = 1e-3;
  while (state.positions[n].x() > 0.0 && time < 2.0) {
    previous = state.positions[n].x();
    verlet->advance(system, time, step, limit, state);
    time += step;
  }
  const double quarter = time - step * (-state.positions[n].x()) / (previous - state.positions[n].x());
  EXPECT_NEAR(0.5 * M_PI / quarter, 1.2024128 * std::sqrt(kGravity / length), 0.02 * 1.2024128 * std::sqrt(kGravity));
}

}  // namespace
}  // namespace deformable_surface::test
