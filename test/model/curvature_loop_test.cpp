// The loop over four fits at a time against the formulas of CurvatureBending, written out here for one fit at a time.
#include "deformable_surface/model/mass_spring/curvature_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace deformable_surface;
using model::CurvatureLoop;
using model::CurvatureRow;

namespace {

constexpr double kPoissonRatio = 0.3;

// Points near a plane with fits of differing sizes. Nine fits, so that the last group of four has only one. Fit 4 is missing.
struct Fits {
  Points positions;
  Lists points;
  std::vector<CurvatureRow> rows;
  std::vector<double> weights;
  std::vector<Vec3> rest;

  Fits() {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> draw(-1.0, 1.0);
    constexpr Index kPoints = 9;
    points.offsets = {0};
    for (Index i = 0; i < kPoints; ++i) {
      positions.push_back({i % 3 + 0.1 * draw(random), i / 3 + 0.1 * draw(random), 0.2 * draw(random)});
      for (Index r = 0; r < 6 + i % 3; ++r) points.items.push_back((i + r) % kPoints);
      points.offsets.push_back(static_cast<Index>(points.items.size()));
      weights.push_back(i == 4 ? 0.0 : 1.0 + 0.5 * draw(random));
      rest.push_back({0.1 * draw(random), 0.1 * draw(random), 0.1 * draw(random)});
    }
    // Rows that give tangents close to unit vectors, with disturbed second derivatives.
    for (Index i = 0; i < kPoints; ++i) {
      Eigen::Matrix<double, Eigen::Dynamic, 3> basis(points.count(i), 3);
      for (Index r = 0; r < points.count(i); ++r) {
        const Vec3 offset = positions[points.begin(i)[r]] - positions[i];
        basis.row(r) << 1.0, offset.x(), offset.y();
      }
      const Eigen::MatrixXd inverse = basis.completeOrthogonalDecomposition().pseudoInverse();
      for (Index r = 0; r < points.count(i); ++r)
        rows.push_back({{inverse(1, r), inverse(2, r)}, {draw(random), draw(random), draw(random)}});
    }
  }

  CurvatureLoop makeLoop() const { return CurvatureLoop(points, rows, weights, rest, kPoissonRatio); }

  double areaOf(Index i) const {
    Vec3 tangents[2] = {Vec3::Zero(), Vec3::Zero()};
    for (Index k = points.offsets[i]; k < points.offsets[i + 1]; ++k)
      for (int c = 0; c < 2; ++c) tangents[c] += rows[k].first[c] * positions[points.items[k]];
    return tangents[0].cross(tangents[1]).norm();
  }

  double findEnergy() const {
    double sum = 0.0;
    for (Index i = 0; i < points.size(); ++i) {
      Vec3 tangents[2] = {Vec3::Zero(), Vec3::Zero()};
      Mat3 second = Mat3::Zero();
      for (Index k = points.offsets[i]; k < points.offsets[i + 1]; ++k) {
        const Vec3& x = positions[points.items[k]];
        for (int c = 0; c < 2; ++c) tangents[c] += rows[k].first[c] * x;
        second += x * rows[k].second.transpose();
      }
      const Vec3 cross = tangents[0].cross(tangents[1]);
      constexpr double kSmall = CurvatureLoop::kCrushed;
      const double length = cross.norm() < kSmall ? (cross.squaredNorm() + kSmall * kSmall) / (2.0 * kSmall) : cross.norm();
      const Vec3 k = second.transpose() * cross / length - rest[i];
      const double squares = k[0] * k[0] + 2.0 * k[1] * k[1] + k[2] * k[2], trace = k[0] + k[2];
      sum += 0.5 * weights[i] * ((1.0 - kPoissonRatio) * squares + kPoissonRatio * trace * trace);
    }
    return sum;
  }
};

PaddedPoints pad(const Points& points) {
  PaddedPoints padded;
  padded.assign(points);
  return padded;
}

}  // namespace

TEST(CurvatureLoop, HasTheEnergyOfItsFits) {
  const Fits fits;
  EXPECT_NEAR(fits.makeLoop().energy(pad(fits.positions)), fits.findEnergy(), 1e-12 * fits.findEnergy());
}

TEST(CurvatureLoop, HasTheForcesOfItsEnergyAlsoForSinglePoints) {
  Fits fits;
  const CurvatureLoop loop = fits.makeLoop();
  ASSERT_FALSE(loop.computeMoments(pad(fits.positions)));
  Points forces(fits.positions.size(), Vec3(1.0, 2.0, 3.0));  // they are added to
  loop.addForces(static_cast<Index>(forces.size()), forces);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Vec3 force = loop.findForce(static_cast<Index>(i));
    EXPECT_LT((forces[i] - Vec3(1.0, 2.0, 3.0) - force).norm(), 1e-12);
    for (int c = 0; c < 3; ++c) {
      constexpr double kStep = 1e-6;
      const double place = fits.positions[i][c];
      fits.positions[i][c] = place + kStep;
      const double more = fits.findEnergy();
      fits.positions[i][c] = place - kStep;
      const double less = fits.findEnergy();
      fits.positions[i][c] = place;
      EXPECT_NEAR(force[c], -(more - less) / (2.0 * kStep), 1e-6) << i << " " << c;
    }
  }
}

TEST(CurvatureLoop, NamesCrushedPointsAndGivesThemNoForce) {
  Fits fits;
  const CurvatureLoop loop = fits.makeLoop();
  for (Vec3& p : fits.positions) p.tail<2>() *= 0.01;
  EXPECT_TRUE(loop.computeMoments(pad(fits.positions)));
  Index num_crushed = 0;
  for (Index i = 0; i < fits.points.size(); ++i) {
    const bool is_crushed = fits.areaOf(i) < CurvatureLoop::kCrushed;
    num_crushed += is_crushed;
    EXPECT_EQ(loop.hasNormal(i), !is_crushed) << i;
  }
  ASSERT_EQ(num_crushed, fits.points.size());
  EXPECT_EQ(loop.findForce(0), Vec3::Zero());
  EXPECT_NEAR(loop.energy(pad(fits.positions)), fits.findEnergy(), 1e-12 * fits.findEnergy());
}

TEST(CurvatureLoop, ListsTheFitsThatUseAPoint) {
  const Fits fits;
  const CurvatureLoop loop = fits.makeLoop();
  for (Index point = 0; point < fits.points.size(); ++point) {
    std::vector<Index> expected, found;
    for (Index i = 0; i < fits.points.size(); ++i)
      if (fits.weights[i] != 0.0 && std::count(fits.points.begin(i), fits.points.end(i), point) > 0) expected.push_back(i);
    for (Index k = loop.users().offsets[point]; k < loop.users().offsets[point + 1]; k += 2) found.push_back(loop.fitOf(k));
    EXPECT_EQ(found, expected) << point;
  }
}
