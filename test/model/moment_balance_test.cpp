// The patch test of bending: a constant moment is in balance on any points, so that these bend as stiffly as the plate.
#include "plates.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::CurvatureBending;

constexpr double kLength = 1.0, kWidth = 0.25;

class ConstantMoment : public testing::TestWithParam<Scatter> {
 protected:
  // Points within so many rings of points around which the triangles do not close: on edges, and where stars disagree by a few
  // per cent of a triangle because five points lie nearly on a circle.
  static std::vector<char> markInner(const Surface& s, int rings) {
    Points outward(s.points.size(), Vec3::Zero());
    for (const cloud::Triangle& t : s.rings.triangles)
      for (int c = 0; c < 3; ++c)
        outward[t.corner[c]] += t.weight * s.normals[0].cross(s.points[t.corner[(c + 2) % 3]] - s.points[t.corner[(c + 1) % 3]]);
    std::vector<char> is_inner;
    for (const Vec3& o : outward) is_inner.push_back(o.norm() < 1e-9);
    for (int r = 0; r < rings; ++r) {
      const std::vector<char> before = is_inner;
      for (Index i = 0; i < s.rings.ring.size(); ++i)
        for (const Index* j = s.rings.ring.begin(i); j != s.rings.ring.end(i); ++j)
          if (!before[*j]) is_inner[i] = 0;
    }
    return is_inner;
  }

  // How much more a strip bends than a plate of its area, between two couples at its ends.
  static double bendFree(Index along, unsigned seed) {
    const Surface s = makeScattered(GetParam(), along, kLength, kWidth, seed);
    const SparseMatrix stiffness = stiffnessAcross(s, CurvatureBending(plateOf(s, 1.0, 0.0)));
    const Index n = static_cast<Index>(s.points.size());
    Eigen::VectorXd forces = Eigen::VectorXd::Zero(n);
    const auto load = [&](double from, double to, double total) {
      double area = 0.0;
      for (Index i = 0; i < n; ++i)
        if (s.points[i].x() >= from && s.points[i].x() <= to) area += s.rings.area[i];
      for (Index i = 0; i < n; ++i)
        if (s.points[i].x() >= from && s.points[i].x() <= to) forces[i] += total * s.rings.area[i] / area;
    };
    load(0.0, 0.06, 1.0);
    load(0.14, 0.2, -1.0);
    load(0.8, 0.86, -1.0);
    load(0.94, 1.0, 1.0);
    // The two couples are equal, and nothing remains across.
    double couples[2] = {};
    for (Index i = 0; i < n; ++i) couples[s.points[i].x() > 0.5] += forces[i] * (s.points[i].x() - 0.5);
    for (Index i = 0; i < n; ++i)
      if (s.points[i].x() > 0.5) forces[i] *= -couples[0] / couples[1];
    Eigen::MatrixXd rigid(n, 3);
    for (Index i = 0; i < n; ++i) rigid.row(i) << 1.0, s.points[i].x(), s.points[i].y();
    forces -= rigid * (rigid.transpose() * rigid).ldlt().solve(rigid.transpose() * forces);
    double moment = 0.0;
    for (Index i = 0; i < n; ++i)
      if (s.points[i].x() < 0.5) moment += forces[i] * (s.points[i].x() - 0.5);
    // Three corners are held. They carry no load.
    std::vector<char> held(n, 0);
    for (const Vec3& corner : {Vec3(0.0, -0.5 * kWidth, 0.0), Vec3(kLength, -0.5 * kWidth, 0.0), Vec3(0.0, 0.5 * kWidth, 0.0)}) {
      const auto nearest = std::min_element(s.points.begin(), s.points.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - corner).squaredNorm() < (b - corner).squaredNorm();
      });
      held[nearest - s.points.begin()] = 1;
    }
    // With few points the sides are ragged. The width of a strip is that of its triangles.
    const auto isInMiddle = [](const Vec3& p) { return p.x() > 0.35 && p.x() < 0.65; };
    const Eigen::VectorXd fit = fitQuadratic(s, solveHeld(stiffness, held, forces), Vec3(0.5 * kLength, 0.0, 0.0), isInMiddle);
    return std::abs(fit[3] / moment) * s.area / kLength - 1.0;
  }
};

TEST_P(ConstantMoment, IsInBalanceInside) {
  for (const Index along : {20, 40}) {
    const Surface s = makeScattered(GetParam(), along, kLength, 3.0 * kWidth);
    const SparseMatrix stiffness = stiffnessAcross(s, CurvatureBending(plateOf(s, 1.0, 0.3)));
    const std::vector<char> is_inner = markInner(s, 3);
    ASSERT_GT(std::count(is_inner.begin(), is_inner.end(), 1), 30);
    for (const Vec3& bent : {Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0)}) {
      Eigen::VectorXd motion(s.points.size());
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        const Vec3& p = s.points[i];
        motion[i] = 0.5 * bent[0] * p.x() * p.x() + bent[1] * p.x() * p.y() + 0.5 * bent[2] * p.y() * p.y();
      }
      const Eigen::VectorXd forces = stiffness * motion;
      // The edges carry the moment. Without the balance the forces inside are a quarter as large.
      double inside = 0.0;
      for (std::size_t i = 0; i < s.points.size(); ++i)
        if (is_inner[i]) inside = std::max(inside, std::abs(forces[i]));
      EXPECT_LT(inside, 1e-7 * forces.cwiseAbs().maxCoeff());
      // The rows are exact.
      const double exact = bent[1] != 0.0 ? 2.0 * (1.0 - 0.3) : 1.0;
      EXPECT_NEAR(motion.dot(forces), exact * s.area, 1e-9 * s.area);
    }
  }
}

TEST_P(ConstantMoment, BendsAsFarAsAPlate) {
  // Sides of simplified points are ragged, so the middle is narrower than the whole.
  const double ragged = GetParam() == Scatter::kSimplified ? 2.0 : 1.0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    EXPECT_LT(std::abs(bendFree(20, seed)), 0.015);
    EXPECT_LT(std::abs(bendFree(40, seed)), 0.003 * ragged);
  }
  EXPECT_LT(std::abs(bendFree(80, 1)), 0.001 * ragged);
}

// Only rigid motions are soft, and no motion is much stiffer: eigenvalues of the balanced rows against those of a grid.
TEST_P(ConstantMoment, ThereAreNoSoftModes) {
  const auto findEigenvalues = [](const Surface& s) -> Eigen::VectorXd {
    Eigen::MatrixXd matrix = stiffnessAcross(s, CurvatureBending(plateOf(s, 1.0, 0.3))).toDense();
    for (Index i = 0; i < matrix.rows(); ++i) {
      matrix.row(i) /= std::sqrt(s.rings.area[i]);
      matrix.col(i) /= std::sqrt(s.rings.area[i]);
    }
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  };
  const Eigen::VectorXd grid = findEigenvalues(makeScattered(Scatter::kGrid, 32, 1.0, 0.5));
  const Eigen::VectorXd found = findEigenvalues(makeScattered(GetParam(), 32, 1.0, 0.5));
  for (Index k = 0; k < 3; ++k) EXPECT_NEAR(found[k], 0.0, 1e-7 * grid[3]);
  for (Index k = 3; k < 20; ++k) EXPECT_NEAR(found[k] / grid[k], 1.0, 0.06) << k;
  EXPECT_LT(found[found.size() - 1], 3.0 * grid[grid.size() - 1]);
}

INSTANTIATE_TEST_SUITE_P(Points, ConstantMoment,
                         testing::Values(Scatter::kGrid, Scatter::kJittered, Scatter::kPoisson, Scatter::kSimplified));

// Rolled to a cylinder: the residual of a constant moment across the surface at inner points falls with the spacing.
TEST(MomentOnACylinder, IsNearlyInBalance) {
  const double radius = 0.5;
  double before = 0.0;
  for (const Index along : {16, 32}) {
    const Surface flat = makeScattered(Scatter::kJittered, along, 1.0, 0.75);
    Points points, normals;
    for (const Vec3& p : flat.points) {
      const double angle = (p.x() - 0.5) / radius;
      normals.emplace_back(std::sin(angle), 0.0, std::cos(angle));
      points.push_back(radius * normals.back() + Vec3(0.0, p.y(), 0.0));
    }
    const Surface s = connect(points, normals);
    const CurvatureBending bending(plateOf(s, 1.0, 0.0));
    BlockSparse stiffness;
    stiffness.begin(static_cast<Index>(s.points.size()));
    bending.addStiffness({s.points, Points(s.points.size(), Vec3::Zero())}, model::Hessian::kPositive, stiffness);
    stiffness.finish();
    // A bend along the axis, which strains nothing: w = y^2 / 2.
    Eigen::VectorXd motion(3 * s.points.size()), forces;
    for (std::size_t i = 0; i < s.points.size(); ++i)
      motion.segment<3>(3 * i) = 0.5 * s.points[i].y() * s.points[i].y() * s.normals[i];
    stiffness.multiply(motion, forces);
    double inside = 0.0, all = 0.0;
    Index count = 0;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      const double force = forces.segment<3>(3 * i).dot(s.normals[i]);
      all = std::max(all, std::abs(force));
      if (std::abs(flat.points[i].x() - 0.5) > 0.2 || std::abs(flat.points[i].y()) > 0.12) continue;
      inside += force * force;
      ++count;
    }
    inside = std::sqrt(inside / count) / all;
    if (before > 0.0) EXPECT_LT(inside, 0.5 * before);
    EXPECT_LT(inside, 0.02);
    before = inside;
  }
}

}  // namespace
}  // namespace deformable_surface::test
