// Errors of elastic solids at rest under small loads, on irregular points, against fields of the theory of elasticity.
#include "model_checks.h"
#include "solids.h"

#include <gtest/gtest.h>

#include <functional>

namespace deformable_surface::test {
namespace {

using model::ElasticSolid;

// Small displacements (n x 3) under forces, with some coordinates (3 n) given. Conjugate gradients on the stiffness at rest, with
// products from differences of forces.
Points solveSmall(const ElasticSolid& solid, const Points& rest, const std::vector<char>& is_given, Points displacement,
                  const Points& load, double size) {
  const Index n = static_cast<Index>(rest.size());
  const auto respond = [&](const Eigen::VectorXd& v) {
    const double scale = 1e-5 * size / std::max(v.lpNorm<Eigen::Infinity>(), 1e-300);
    Points ahead = rest, behind = rest;
    for (Index i = 0; i < n; ++i) {
      ahead[i] += scale * v.segment<3>(3 * i);
      behind[i] -= scale * v.segment<3>(3 * i);
    }
    const Points f = forcesAt(solid, stateAt(ahead)), g = forcesAt(solid, stateAt(behind));
    Eigen::VectorXd product(3 * n);
    for (Index c = 0; c < 3 * n; ++c) product[c] = (g[c / 3][c % 3] - f[c / 3][c % 3]) / (2.0 * scale);
    return product;
  };
  const auto free = [&](Eigen::VectorXd v) {
    for (Index c = 0; c < 3 * n; ++c)
      if (is_given[c]) v[c] = 0.0;
    return v;
  };
  Eigen::VectorXd x(3 * n), b(3 * n);
  for (Index c = 0; c < 3 * n; ++c) {
    x[c] = is_given[c] ? displacement[c / 3][c % 3] : 0.0;
    b[c] = load[c / 3][c % 3];
  }
  Eigen::VectorXd r = free(b - (x.isZero(0.0) ? Eigen::VectorXd(Eigen::VectorXd::Zero(3 * n)) : respond(x))), p = r;
  double squared = r.squaredNorm();
  const double enough = 1e-16 * squared;
  for (int k = 0; k < 5000 && squared > enough; ++k) {
    const Eigen::VectorXd q = free(respond(p));
    const double step = squared / p.dot(q);
    x += step * p;
    r -= step * q;
    const double next = r.squaredNorm();
    p = r + next / squared * p;
    squared = next;
  }
  for (Index i = 0; i < n; ++i) displacement[i] = x.segment<3>(3 * i);
  return displacement;
}

constexpr double kYoung = 1e5, kPoisson = 0.3;

// The surface of a jittered block is moved by a linear field. The inside follows it. Differences of forces are accurate to ten
// digits.
TEST(ElasticSolidStatics, PassesThePatchTestOnJitteredPoints) {
  Mat3 strain;
  strain << 1.0, 0.4, -0.2, 0.1, -0.5, 0.3, 0.2, 0.6, 0.7;
  for (const bool is_planar : {false, true}) {
    const Index n = is_planar ? 12 : 7;
    const Points rest = makeBox(n, n, is_planar ? 1 : n, 0.1, 0.3);
    const ElasticSolid solid = is_planar ? makePlanarSolid(rest) : makeSolid(rest);
    if (is_planar) strain.row(2).setZero(), strain.col(2).setZero();
    std::vector<char> is_given(3 * rest.size(), 0);
    Points field;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      field.push_back(1e-5 * strain * rest[i]);
      bool is_outside = false;
      for (int c = 0; c < (is_planar ? 2 : 3); ++c) is_outside = is_outside || rest[i][c] == 0.0 || rest[i][c] == 0.1 * (n - 1);
      for (int c = 0; c < 3; ++c) is_given[3 * i + c] = is_outside || (is_planar && c == 2);
    }
    const Points found = solveSmall(solid, rest, is_given, field, Points(rest.size(), Vec3::Zero()), 0.1);
    double worst = 0.0;
    for (std::size_t i = 0; i < rest.size(); ++i) worst = std::max(worst, (found[i] - field[i]).norm());
    EXPECT_LT(worst, 1e-7 * largest(field)) << is_planar;
  }
}

// Pulled at one end, on rollers at three faces: length and lateral contraction, place of each point.
TEST(ElasticSolidStatics, AStretchedBarContractsAcross) {
  const Index nx = 13, nt = 5;
  const double a = 0.05, length = a * (nx - 1), stretch = 1e-4;
  const Points rest = makeBox(nx, nt, nt, a, 0.2);
  const ElasticSolid solid = makeSolid(rest);
  const Points outside = model::findPointCells(rest, cloud::nearestNeighbors(rest, 32), Vec3::Zero()).outside;
  std::vector<char> is_given(3 * rest.size(), 0);
  Points load(rest.size(), Vec3::Zero());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    for (int c = 0; c < 3; ++c) is_given[3 * i + c] = rest[i][c] == 0.0;
    if (rest[i].x() == length) load[i].x() = kYoung * stretch * outside[i].x();
  }
  const Points found = solveSmall(solid, rest, is_given, Points(rest.size(), Vec3::Zero()), load, a);
  double worst = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i)
    worst = std::max(worst, (found[i] - stretch * Vec3(rest[i].x(), -kPoisson * rest[i].y(), -kPoisson * rest[i].z())).norm());
  // Loads by the area of each point's facet are not quite in balance with uniform stress on jittered points.
  EXPECT_LT(worst, 1e-3 * stretch * length);
}

// A cantilever in plane stress under a shear load at its end, exactly [Timoshenko and Goodier 1951, art. 21]: depth points
// across, error of the displacement (rms, over that of the end).
double bendPlate(Index depth, double jitter) {
  const double D = 0.2, L = 1.0, P = 1e-6, h = 0.001, I = h * D * D * D / 12.0, a = D / (depth - 1);
  Points rest = makeBox(5 * (depth - 1) + 1, depth, 1, a, jitter);
  for (Vec3& p : rest) p.y() -= 0.5 * D;
  const ElasticSolid solid = makePlanarSolid(rest);
  const Points outside = model::findPointCells(rest, cloud::nearestNeighbors(rest, 16), Vec3::UnitZ()).outside;
  const auto exact = [&](const Vec3& p) -> Vec3 {
    const double x = p.x(), y = p.y(), nu = kPoisson;
    return Vec3(-y * ((6.0 * L - 3.0 * x) * x + (2.0 + nu) * (y * y - 0.25 * D * D)),
                3.0 * nu * y * y * (L - x) + (4.0 + 5.0 * nu) * D * D * x / 4.0 + (3.0 * L - x) * x * x, 0.0) *
           (P / (6.0 * kYoung * I));
  };
  std::vector<char> is_given(3 * rest.size(), 0);
  Points given(rest.size(), Vec3::Zero()), load = given;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    is_given[3 * i + 2] = 1;
    if (rest[i].x() == 0.0) {
      is_given[3 * i] = is_given[3 * i + 1] = 1;
      given[i] = exact(rest[i]);
    }
    if (std::abs(rest[i].x() - L) < 1e-9)
      load[i].y() = h * outside[i].x() * P / (2.0 * I) * (0.25 * D * D - rest[i].y() * rest[i].y());
  }
  const Points found = solveSmall(solid, rest, is_given, given, load, a);
  double sum = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) sum += (found[i] - exact(rest[i])).squaredNorm();
  return std::sqrt(sum / static_cast<double>(rest.size())) / exact(Vec3(L, 0.0, 0.0)).norm();
}

TEST(ElasticSolidStatics, ACantileverConvergesToTheExactSolution) {
  for (const double jitter : {0.0, 0.2}) {
    const double coarse = bendPlate(5, jitter), middle = bendPlate(9, jitter), fine = bendPlate(17, jitter);
    EXPECT_LT(coarse, 0.08) << jitter;
    EXPECT_LT(middle, 0.03) << jitter;
    EXPECT_LT(fine, 0.01) << jitter;
    const double order = std::log2(coarse / fine) / 2.0;
    EXPECT_GT(order, 1.5) << jitter << ": " << coarse << " " << middle << " " << fine;
    RecordProperty(jitter > 0.0 ? "jittered" : "regular",
                   std::to_string(coarse) + " " + std::to_string(middle) + " " + std::to_string(fine));
    std::printf("cantilever, jitter %.1f: rms error %.4f %.4f %.4f, order %.2f\n", jitter, coarse, middle, fine, order);
  }
}

constexpr double kOuter = 2.0;

// A long tube under inner pressure, a quarter of its section: error of the mean displacement of the inner circle, exactly
// [Timoshenko and Goodier 1951, art. 28].
double pressTube(Index through, double jitter, unsigned seed, double poisson) {
  const QuarterRing ring = makeQuarterRing(kOuter, through, jitter, seed);
  const double pressure = 1e-6 * kYoung;
  SolidOptions options;
  options.material.poisson_ratio = poisson;
  options.material.thickness = 1.0;
  options.params.plane = model::PlaneKind::kStrain;
  options.material.young_modulus = kYoung;
  const ElasticSolid solid = makePlanarSolid(ring.points, options);
  std::vector<char> is_given(3 * ring.points.size(), 0);
  Points load(ring.points.size(), Vec3::Zero());
  for (std::size_t i = 0; i < ring.points.size(); ++i)
    for (int c = 0; c < 3; ++c) is_given[3 * i + c] = ring.points[i][c] == 0.0;
  for (std::size_t k = 0; k < ring.inner.size(); ++k)
    load[ring.inner[k]] = pressure * ring.length[k] * ring.points[ring.inner[k]];
  const Points found = solveSmall(solid, ring.points, is_given, Points(ring.points.size(), Vec3::Zero()), load, 1.0 / through);
  double mean = 0.0;
  for (std::size_t k = 0; k < ring.inner.size(); ++k)
    mean += ring.length[k] * found[ring.inner[k]].dot(ring.points[ring.inner[k]]) / (0.5 * M_PI);
  const double squared = kOuter * kOuter;
  const double exact = pressure * (1.0 + poisson) / kYoung * (1.0 - 2.0 * poisson + squared) / (squared - 1.0);
  return mean / exact - 1.0;
}

// Twice as many points, a quarter of the error.
TEST(ElasticSolidStatics, ATubeUnderInnerPressureConvergesToTheExactSolution) {
  for (const double poisson : {0.0, 0.3, 0.45})
    for (const double jitter : {0.0, 0.3}) {
      double error[3] = {0.0, 0.0, 0.0};
      const Index through[3] = {4, 8, 16};
      for (int k = 0; k < 3; ++k)
        for (const unsigned seed : {1u, 2u, 3u})
          error[k] = std::max(error[k], std::abs(pressTube(through[k], jitter, seed, poisson)));
      const double order = std::log(error[0] / error[2]) / std::log(15.0 / 3.0);
      std::printf("tube, Poisson's ratio %.2f, jitter %.1f: %.4f %.4f %.4f, order %.2f\n", poisson, jitter, error[0], error[1],
                  error[2], order);
      EXPECT_LT(error[0], 0.1) << poisson << ", " << jitter;
      EXPECT_LT(error[1], 0.01) << poisson << ", " << jitter;
      EXPECT_LT(error[2], 0.004) << poisson << ", " << jitter;
      EXPECT_GT(order, 1.6) << poisson << ", " << jitter;
    }
}

// A bar clamped at one end and loaded at the other, against Timoshenko's beam. The clamp prevents contraction of the end, which
// makes the bar a little stiffer.
TEST(ElasticSolidStatics, ABarBendsAsBeamsDo) {
  const Index depth = 6;
  const double D = 0.2, L = 1.0, a = D / (depth - 1), I = D * D * D * D / 12.0, P = 1e-5 * 3.0 * kYoung * I;
  const Points rest = makeBox(5 * (depth - 1) + 1, depth, depth, a, 0.2);
  const ElasticSolid solid = makeSolid(rest);
  const Points outside = model::findPointCells(rest, cloud::nearestNeighbors(rest, 32), Vec3::Zero()).outside;
  std::vector<char> is_given(3 * rest.size(), 0);
  Points load(rest.size(), Vec3::Zero());
  double area = 0.0, deflection = 0.0;
  const auto isEnd = [&](std::size_t i) { return std::abs(rest[i].x() - L) < 1e-9; };
  for (std::size_t i = 0; i < rest.size(); ++i) area += isEnd(i) ? outside[i].x() : 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    for (int c = 0; c < 3; ++c) is_given[3 * i + c] = rest[i].x() == 0.0;
    if (isEnd(i)) load[i].z() = P * outside[i].x() / area;
  }
  const Points found = solveSmall(solid, rest, is_given, Points(rest.size(), Vec3::Zero()), load, a);
  for (std::size_t i = 0; i < rest.size(); ++i) deflection += isEnd(i) ? found[i].z() * outside[i].x() / area : 0.0;
  const double euler = P * L * L * L / (3.0 * kYoung * I), kappa = 10.0 * (1.0 + kPoisson) / (12.0 + 11.0 * kPoisson);
  const double timoshenko = euler + P * L / (kappa * kYoung / (2.0 * (1.0 + kPoisson)) * D * D);
  EXPECT_NEAR(deflection / timoshenko, 1.0, 0.04);
  std::printf("bar, %d points across: %.4f of Timoshenko's deflection, %.4f of Euler's\n", static_cast<int>(depth),
              deflection / timoshenko, deflection / euler);
}

}  // namespace
}  // namespace deformable_surface::test
