// One triangle, whose energy, forces and springs in plane stress are known in closed form.
#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "../support/dense.h"
#include "../support/surfaces.h"
#include "model_checks.h"

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {
namespace {

constexpr double kStiffness = 120.0, kPoisson = 0.25, kArea = 0.5, kWeight = 0.5;                    // E h in N/m
constexpr double kMu = kStiffness / (2.0 * 1.25), kLambda = kStiffness * kPoisson / (1.0 - 0.0625);  // N/m

const Points kRest{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};

model::TriangleMembrane makeTriangle() { return {{{{0, 1, 2}, kWeight}}, kRest, kStiffness, kPoisson}; }

model::State at(const Points& positions) { return {positions, Points(positions.size(), Vec3::Zero())}; }

Points forcesOf(const model::TriangleMembrane& membrane, const Points& points) {
  PaddedPoints positions;
  positions.assign(points);
  Points forces(points.size(), Vec3::Zero());
  membrane.addForces(at(points), positions, forces);
  return forces;
}

// Stretched by a along x, then by b along y, then turned.
Points stretch(double a, double b, const Mat3& turn = Mat3::Identity()) {
  Points points = kRest;
  for (Vec3& p : points) p = turn * Vec3(a * p.x(), b * p.y(), 0.0);
  return points;
}

TEST(TriangleMembrane, StoresTheEnergyOfPlaneStressHoweverItIsTurned) {
  const model::TriangleMembrane membrane = makeTriangle();
  EXPECT_NEAR(membrane.energy(at(stretch(1.0, 1.0, someRotation()))), 0.0, 1e-15);
  const double expected = kWeight * kArea * (kMu * (0.01 + 0.04) + 0.5 * kLambda * 0.01);
  EXPECT_NEAR(membrane.energy(at(stretch(1.1, 0.8))), expected, 1e-12);
  EXPECT_NEAR(membrane.energy(at(stretch(1.1, 0.8, someRotation()))), expected, 1e-12);
}

// The stress along x acts on the edges, with half of the force of each edge at either end.
TEST(TriangleMembrane, PullsByItsStressOverTheEdges) {
  const double along = 2.0 * kMu * 0.1 + kLambda * 0.1, across = kLambda * 0.1;  // N/m, by F = diag(1.1, 1)
  const Points forces = forcesOf(makeTriangle(), stretch(1.1, 1.0));
  const double share = kWeight * kArea;
  EXPECT_LT((forces[1] - Vec3(-share * along, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((forces[2] - Vec3(0.0, -share * across, 0.0)).norm(), 1e-12);
  EXPECT_LT((forces[0] + forces[1] + forces[2]).norm(), 1e-12);
}

TEST(TriangleMembrane, ProjectsItsStiffnessToPositiveWhereItIsPressed) {
  const model::TriangleMembrane membrane = makeTriangle();
  for (const bool is_positive : {false, true}) {
    BlockSparse stiffness;
    stiffness.begin(3);
    membrane.addStiffness(at(stretch(0.7, 0.7)), is_positive ? model::Hessian::kPositive : model::Hessian::kExact, stiffness);
    stiffness.finish();
    const Eigen::MatrixXd dense = makeDense(stiffness);
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvalues()[0];
    EXPECT_EQ(least > -1e-10 * dense.norm(), is_positive) << least;
  }
}

TEST(TriangleMembrane, RecoversFromACollapseIntoALine) {
  Points line = kRest;
  line[2] = Vec3(0.5, 0.0, 0.0);
  const Points forces = forcesOf(makeTriangle(), line);
  for (const Vec3& f : forces) EXPECT_TRUE(f.allFinite());
  EXPECT_GT(forces[2].norm(), 0.0);
}

TEST(TriangleMembrane, LeavesOutTrianglesWithoutArea) {
  const model::TriangleMembrane membrane({{{0, 1, 2}, 1.0}}, {Vec3::Zero(), Vec3::UnitX(), Vec3(2.0, 0.0, 0.0)}, kStiffness,
                                         kPoisson);
  EXPECT_EQ(membrane.energy(at(kRest)), 0.0);
  EXPECT_TRUE(membrane.findEdges().empty());
}

TEST(TriangleMembrane, HasNoSpringsAcrossWithoutTension) {
  const model::TriangleMembrane membrane = makeTriangle();
  EXPECT_EQ(membrane.findEdges(), (std::vector<std::pair<Index, Index>>{{0, 1}, {1, 2}, {0, 2}}));
  std::vector<double> along, across, tense;
  membrane.computeSpringsAlong(along);
  membrane.computeSpringsAcross(at(kRest), across);
  membrane.computeSpringsAcross(at(stretch(1.2, 1.2)), tense);
  ASSERT_EQ(across.size(), 3u);
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(across[k], 0.0, 1e-12);
    sum += tense[k];
  }
  EXPECT_GT(sum, 0.0);
  EXPECT_GT(along[0] + along[1] + along[2], 0.0);
}

// Triangles that share their four points act as one. Each alone is the reference.
struct Patches {
  const char* name;
  Points rest;
  std::vector<model::WeightedTriangle> triangles;
};

std::vector<Patches> makePatches() {
  Points pentagon;
  for (int k = 0; k < 5; ++k) pentagon.emplace_back(std::cos(0.4 * k * M_PI), std::sin(0.4 * k * M_PI), 0.0);
  std::vector<model::WeightedTriangle> all_of_five;
  for (Index i = 0; i < 5; ++i)
    for (Index j = i + 1; j < 5; ++j)
      for (Index k = j + 1; k < 5; ++k) all_of_five.push_back({{k, i, j}, 0.3});
  std::vector<Patches> patches{{"five cocircular points", pentagon, all_of_five}};
  // A grid with both diagonals of every cell, one with a single diagonal, and one that mixes them. In the last one the corners
  // stand in other orders, and a triangle hangs on one point.
  const auto placeOf = [](Index i, Index j) { return 5 * i + j; };
  for (const int kind : {0, 1, 2}) {
    Patches grid{kind == 0 ? "fours" : kind == 1 ? "pairs" : "mixed", {}, {}};
    for (Index i = 0; i < 5; ++i)
      for (Index j = 0; j < 5; ++j) grid.rest.emplace_back(0.1 * i + 0.02 * std::sin(3.0 * j), 0.1 * j, 0.03 * std::cos(2.0 * i));
    for (Index i = 0; i < 4; ++i)
      for (Index j = 0; j < 4; ++j) {
        const Index a = placeOf(i, j), b = placeOf(i + 1, j), c = placeOf(i + 1, j + 1), d = placeOf(i, j + 1);
        const bool is_four = kind == 0 || (kind == 2 && (i + j) % 3 == 0);
        const double weight = is_four ? 0.5 : 1.0;
        if (kind == 2 && j % 2 == 1) {
          grid.triangles.push_back({{c, a, b}, weight});
          grid.triangles.push_back({{d, c, a}, weight});
        } else {
          grid.triangles.push_back({{a, b, c}, weight});
          grid.triangles.push_back({{a, c, d}, weight});
        }
        if (!is_four) continue;
        grid.triangles.push_back({{b, c, d}, weight});
        grid.triangles.push_back({{d, a, b}, weight});
      }
    if (kind == 2) {
      grid.rest.emplace_back(0.9, 0.0, 0.0);
      grid.rest.emplace_back(0.9, 0.2, 0.0);
      grid.triangles.push_back({{26, 24, 25}, 0.7});
    }
    patches.push_back(grid);
  }
  return patches;
}

void expectSumOfTriangles(const Patches& patches, const Points& positions, const model::TriangleMembrane* whole = nullptr) {
  const Points forces = forcesOf({patches.triangles, patches.rest, kStiffness, kPoisson, whole}, positions);
  Points sum(positions.size(), Vec3::Zero());
  double largest = 0.0;
  for (const model::WeightedTriangle& t : patches.triangles) {
    const Points alone = forcesOf({{t}, patches.rest, kStiffness, kPoisson}, positions);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += alone[i];
  }
  for (const Vec3& f : sum) largest = std::max(largest, f.norm());
  for (std::size_t i = 0; i < sum.size(); ++i)
    EXPECT_LT((forces[i] - sum[i]).norm(), 1e-12 * largest) << patches.name << ", point " << i;
}

TEST(TriangleMembrane, ActsLikeTheSumOfItsTriangles) {
  for (const Patches& patches : makePatches()) {
    expectSumOfTriangles(patches, perturb(patches.rest, 0.05));
    Points flat = perturb(patches.rest, 0.05);  // pressed together along x
    for (Vec3& x : flat) x.x() *= 0.01;
    expectSumOfTriangles(patches, flat);
  }
}

TEST(TriangleMembrane, ActsLikeTheSumOfWhatIsLeftOfAWholeOne) {
  for (Patches patches : makePatches()) {
    const model::TriangleMembrane whole(patches.triangles, patches.rest, kStiffness, kPoisson);
    std::mt19937 generator(3);
    for (int round = 0; round < 3; ++round) {
      std::vector<model::WeightedTriangle>& left = patches.triangles;
      left.erase(std::remove_if(left.begin(), left.end(), [&](const auto&) { return uniform(generator) > 0.4; }), left.end());
      ASSERT_FALSE(left.empty()) << patches.name;
      expectSumOfTriangles(patches, perturb(patches.rest, 0.05), &whole);
    }
  }
}

TEST(TriangleMembrane, ActsLikeTheSumOfItsTrianglesWhereSomeAreCollapsed) {
  for (const Patches& patches : makePatches())
    for (const Index at : {0, 3}) {
      // Three points on a line, all of their differences exact.
      Points positions = perturb(patches.rest, 0.05);
      const auto& corner = patches.triangles[at].corner;
      positions[corner[0]] = Vec3(0.25, 0.5, 0.125);
      positions[corner[1]] = Vec3(0.5, 0.5, 0.125);
      positions[corner[2]] = Vec3(0.375, 0.5, 0.125);
      const Points forces = forcesOf({patches.triangles, patches.rest, kStiffness, kPoisson}, positions);
      Vec3 sum = Vec3::Zero();
      for (const Vec3& f : forces) {
        EXPECT_TRUE(f.allFinite()) << patches.name;
        sum += f;
      }
      EXPECT_LT(sum.norm(), 1e-11) << patches.name;
    }
}

}  // namespace
}  // namespace deformable_surface::test
