// Clamps end where their region ends: cantilevers and clamped plates whose edges lie anywhere between scattered points.
#include "../../src/simulation/clamp_edges.h"

#include "../model/plates.h"
#include "clouds.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::test {
namespace {

using simulation::ClampEdges;
using simulation::Contains;

struct Held {
  std::vector<char> held;
  ClampEdges edges;
};

Held holdInside(const Surface& s, const Contains& contains) {
  Held result;
  for (const Vec3& p : s.points) result.held.push_back(contains(p));
  const std::vector<model::WeightedTriangle> triangles = plateOf(s, 1.0, 0.0).triangles;
  result.edges = simulation::findClampEdges({s.points, s.points, s.rings.ring, s.rings.open, triangles}, result.held, contains);
  for (const Index i : result.edges.riding) result.held[i] = 1;
  return result;
}

Eigen::VectorXd sagHeld(const Surface& s, const Held& held, double poisson_ratio) {
  const model::CurvatureBending bending(plateOf(s, 1.0, poisson_ratio), held.held, held.edges.edges);
  const Eigen::VectorXd weight = Eigen::Map<const Eigen::VectorXd>(s.rings.area.data(), s.rings.area.size());
  return solveHeld(stiffnessAcross(s, bending), held.held, weight);
}

class ClampEdge : public testing::TestWithParam<Scatter> {};

// The tip of a cantilever under its weight, whose clamp ends so many spacings behind a row of points.
double errorOfCantilever(Scatter scatter, Index along, double behind, unsigned seed) {
  const double h = 1.0 / along, length = 1.0 + 5.0 * h, edge = (5.0 + behind) * h;
  const Surface s = makeScattered(scatter, along + 5, length, 0.25, seed);
  const Held held = holdInside(s, [&](const Vec3& p) { return p.x() <= edge; });
  const Eigen::VectorXd fit =
      fitQuadratic(s, sagHeld(s, held, 0.0), Vec3(length, 0.0, 0.0), [&](const Vec3& p) { return p.x() > length - 4.5 * h; });
  return fit[0] / (std::pow(length - edge, 4) / 8.0 * s.area / (0.25 * length)) - 1.0;
}

TEST_P(ClampEdge, BetweenPointsIsThatOfABeam) {
  // Simplified points have ragged ends, which make the beam longer or shorter.
  const double ragged = GetParam() == Scatter::kSimplified ? 5.0 : 1.0;
  for (const double behind : {0.0, 0.21, 0.48, 0.77}) {
    double errors[3] = {};
    const Index along[] = {20, 40, 80};
    for (int level = 0; level < 3; ++level)
      for (const unsigned seed : {1u, 2u})
        errors[level] = std::max(errors[level], std::abs(errorOfCantilever(GetParam(), along[level], behind, seed)));
    EXPECT_LT(errors[0], 0.008 * ragged) << behind;
    EXPECT_LT(errors[1], 0.002 * ragged) << behind;
    EXPECT_LT(errors[2], 0.0006 * ragged) << behind;
    EXPECT_GT(std::log2(errors[0] / errors[2]) / 2.0, GetParam() == Scatter::kSimplified ? 1.0 : 1.8) << behind;
  }
}

TEST_P(ClampEdge, OfASquareIsThatOfAPlate) {
  double errors[2] = {};
  const Index across[] = {16, 32};
  for (int level = 0; level < 2; ++level) {
    const double h = 1.0 / across[level], begin = 3.3 * h, end = begin + 1.0, size = 1.0 + 7.0 * h;
    const Surface s = makeScattered(GetParam(), across[level] + 7, size, size, 1);
    const Vec3 middle(0.5 * (begin + end), 0.5 * (begin + end) - 0.5 * size, 0.0);
    const Held held =
        holdInside(s, [&](const Vec3& p) { return std::abs(p.x() - middle.x()) >= 0.5 || std::abs(p.y() - middle.y()) >= 0.5; });
    const Eigen::VectorXd fit = fitQuadratic(s, sagHeld(s, held, 0.3), middle,
                                             [&](const Vec3& p) { return (p - middle).norm() < std::max(0.06, 2.2 * h); });
    errors[level] = std::abs(fit[0] / 0.00126532 - 1.0);  // of q a^4 / D [Timoshenko and Woinowsky-Krieger 1959, table 35]
  }
  EXPECT_LT(errors[0], 0.08);
  EXPECT_LT(errors[1], GetParam() == Scatter::kGrid ? 0.02 : 0.023);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.7);
}

INSTANTIATE_TEST_SUITE_P(Points, ClampEdge,
                         testing::Values(Scatter::kGrid, Scatter::kJittered, Scatter::kPoisson, Scatter::kSimplified));

TEST(MarkClamping, ARowIsAHingeAndTwoAreAClamp) {
  const Surface s = makeSheet(11, 6, 1.0, 0.5, 0.2);
  const auto count = [&](double to) {
    std::vector<char> inside;
    for (const Vec3& p : s.points) inside.push_back(p.x() <= to);
    const std::vector<char> clamping = simulation::markClamping(s.points, s.rings.ring, inside, 0.1);
    return std::count(clamping.begin(), clamping.end(), 1);
  };
  EXPECT_EQ(count(0.05), 0);
  EXPECT_EQ(count(0.14), 12);
}

// Round a corner or a curve a row is as wide as a band.
TEST(MarkClamping, ARowAlongTheRimIsAHingeRoundItsCornersToo) {
  for (const double jitter : {0.0, 0.2, 0.3}) {
    const Surface s = makeSheet(11, 11, 1.0, 1.0, jitter);
    const Lists neighbors = cloud::nearestNeighbors(s.points, 16);
    const auto count = [&](double wide) {
      std::vector<char> inside;
      for (const Vec3& p : s.points) inside.push_back(std::max(std::abs(p.x() - 0.5), std::abs(p.y())) > 0.5 - wide);
      const std::vector<char> clamping = simulation::markClamping(s.points, neighbors, inside, 0.1);
      return std::count(clamping.begin(), clamping.end(), 1);
    };
    EXPECT_EQ(count(0.05), 0) << jitter;
    EXPECT_EQ(count(0.15), 40 + 32) << jitter;
  }
}

TEST(MarkClamping, TwoRowsOfANarrowStripAreAClamp) {
  for (const Index across : {2, 3, 4, 5, 6, 8})
    for (const Index k : {8, 16, 32}) {
      const Surface s = makeSheet(31, across, 3.0, 0.1 * (across - 1), 0.2);
      std::vector<char> inside;
      for (const Vec3& p : s.points) inside.push_back(p.x() <= 0.14);
      const std::vector<char> clamping = simulation::markClamping(s.points, cloud::nearestNeighbors(s.points, k), inside, 0.1);
      EXPECT_EQ(std::count(clamping.begin(), clamping.end(), 1), std::count(inside.begin(), inside.end(), 1))
          << across << ' ' << k;
    }
}

// Of the outermost rings of points of a disc, one is a hinge and two are a clamp.
TEST(MarkClamping, TheRimOfADiscIsAHinge) {
  for (const Index rings : {8, 12, 20}) {
    Points points{Vec3::Zero()};
    for (Index r = 1; r <= rings; ++r)
      for (Index k = 0; k < 6 * r; ++k)
        points.emplace_back(0.1 * r * std::cos(k * M_PI / (3 * r) + 0.5 * r), 0.1 * r * std::sin(k * M_PI / (3 * r) + 0.5 * r),
                            0.0);
    for (const Index held : {1, 2}) {
      std::vector<char> inside;
      for (const Vec3& p : points) inside.push_back(p.norm() > 0.1 * (rings - held) + 0.05);
      for (const Index k : {16, 32}) {
        const std::vector<char> clamping = simulation::markClamping(points, cloud::nearestNeighbors(points, k), inside, 0.1);
        EXPECT_EQ(std::count(clamping.begin(), clamping.end(), 1), held == 1 ? 0 : 6 * (2 * rings - 1)) << rings << ' ' << k;
      }
    }
  }
}

TEST(MarkWide, ARowClampsWhereTheRegionHoldsMoreOfAFinerCloud) {
  const Surface s = makeSheet(11, 6, 1.0, 0.5, 0.2);
  const std::vector<model::WeightedTriangle> triangles = plateOf(s, 1.0, 0.0).triangles;
  const Contains contains = [](const Vec3& p) { return p.x() <= 0.05; };
  std::vector<char> inside;
  for (const Vec3& p : s.points) inside.push_back(contains(p));
  for (const double spacing : {0.1, 0.05, 0.01}) {
    std::vector<char> clamping(s.points.size(), 0);
    simulation::markWide({s.points, s.points, s.rings.ring, s.rings.open, triangles}, inside, contains, spacing, clamping);
    EXPECT_EQ(std::count(clamping.begin(), clamping.end(), 1), spacing < 0.02 ? 6 : 0) << spacing;
    for (std::size_t i = 0; i < s.points.size(); ++i) EXPECT_LE(clamping[i], inside[i]);
  }
}

// The rim of a hole of four rings. With much jitter it looks like a band at some of its points.
TEST(ClampPins, ANoteTellsWhereAPinIsAHingeAtSomePointsOnly) {
  Index num_mixed = 0;
  for (const double jitter : {0.0, 0.2}) {
    for (unsigned seed = 0; seed < 8; ++seed) {
      std::mt19937 generator(seed);
      std::uniform_real_distribution<double> offset(-jitter, jitter);
      cloud::PointCloud plate;
      for (Index ring = 4; ring < 14; ++ring) {
        const Index count = static_cast<Index>(std::lround(2.0 * M_PI * ring));
        for (Index k = 0; k < count; ++k) {
          const double angle = 2.0 * M_PI * k / count + 0.3 * ring, x = offset(generator), y = offset(generator);
          plate.positions.emplace_back(ring * std::cos(angle) + x, ring * std::sin(angle) + y, 0.0);
        }
      }
      simulation::SceneParams params;
      params.simplification.method = cloud::SimplificationMethod::kNone;
      params.pins.emplace_back();
      params.pins[0].region.kind = geometry::Region::Kind::kSphere;
      params.pins[0].region.radius = 4.5;
      std::string notes;
      for (const std::string& note : simulation::buildRestSurface(params, plate, 3).notes) notes += note + "\n";
      const bool is_mixed = notes.find("pins[0] is a hinge at ") != std::string::npos;
      EXPECT_TRUE(is_mixed || notes.find("pins[0] is a hinge: ") != std::string::npos) << notes;
      if (jitter == 0.0) EXPECT_FALSE(is_mixed) << notes;
      num_mixed += is_mixed;
    }
  }
  EXPECT_GT(num_mixed, 0);
}

// The normals of the crest are the mean of both faces'. A triangle across it stands upright on the surface.
TEST(ClampEdges, PinsAcrossASharpCrestHoldIt) {
  constexpr double kSpacing = 0.01;
  for (const double degrees : {70.0, 60.0, 50.0, 40.0, 30.0, 20.0}) {
    const double half = 0.5 * degrees * M_PI / 180.0;
    cloud::PointCloud roof;
    for (Index row = -7; row <= 7; ++row)
      for (Index k = 0; k < 20; ++k) {
        const double side = row < 0 ? -1.0 : row > 0 ? 1.0 : 0.0, away = std::abs(row) * kSpacing;
        roof.positions.emplace_back(side * away * std::sin(half), k * kSpacing, -away * std::cos(half));
        roof.normals.push_back(side == 0.0 ? Vec3(0.0, 0.0, 1.0) : Vec3(side * std::cos(half), 0.0, std::sin(half)));
      }
    simulation::SceneParams scene;
    scene.simplification.method = cloud::SimplificationMethod::kNone;
    scene.accuracy.estimate = false;
    simulation::PinParams pin;
    pin.region.min = Vec3(-9.0, -0.001, -9.0);
    pin.region.max = Vec3(9.0, 1.01 * kSpacing, 9.0);
    scene.pins.push_back(pin);
    simulation::Simulation s(scene, roof);
    for (int k = 0; k < 3; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << degrees << ": " << outcome.problem;
    }
    EXPECT_LT(s.statistics().max_speed, 1.0) << degrees;  // in free fall about a half
  }
}

}  // namespace
}  // namespace deformable_surface::test
