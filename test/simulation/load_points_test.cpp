// Forces with a radius act on the points of the cloud within it.
#include "deformable_surface/simulation/load_points.h"
#include "../../src/simulation/points_between.h"
#include "clouds.h"
#include "deformable_surface/simulation/loads.h"
#include "repeats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::test {
namespace {

using simulation::NamedForces;
using simulation::SceneParams;
using simulation::Simulation;

constexpr Index kAll = 1000;  // more than a cell has

struct Sheet {
  SceneParams params = hangingSheet();
  cloud::PointCloud cloud = sheetCloud(50);
  simulation::RestSurface rest = simulation::buildRestSurface(params, cloud);
  NamedForces forces{rest.model->masses()};
  model::State state{rest.points, Points(rest.points.size(), Vec3::Zero())};

  explicit Sheet(Index most) { forces.setLoadPoints(simulation::chooseLoadPoints(params, rest.dense, rest, most)); }

  const NamedForces::Named& put(const Vec3& point, double radius) {
    forces.set({"a", point, Vec3::UnitZ(), radius, 0.0, 1e300});
    notice = forces.update(0.0, state, std::vector<char>(rest.points.size(), 0)).notice;
    return forces.all().front();
  }
  std::string notice;
};

TEST(LoadPoints, StandForAllOfTheMassOfTheirCells) {
  const Sheet sheet(4);
  const simulation::LoadPoints& load = *sheet.forces.loadPoints();
  for (Index i = 0; i < static_cast<Index>(load.own_share.size()); ++i) {
    double sum = load.own_share[i];
    for (Index s = load.between->begin(i); s < load.between->end(i); ++s) {
      EXPECT_GT(load.share[s], 0.0);
      sum += load.share[s];
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_LE(load.between->end(i) - load.between->begin(i), 4);
  }
}

TEST(LoadPoints, AreNoneWhereEveryPointIsSimulated) {
  SceneParams p = hangingSheet();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(12));
  EXPECT_FALSE(simulation::chooseLoadPoints(p, rest.dense, rest, kAll));
}

// To a spacing of the cloud, 0.02 m. Simulation points are 0.08 m apart.
TEST(LoadPoints, AForceActsInTheMiddleOfThePatchWhateverSimulationPointsItHolds) {
  for (const Index most : {kAll, simulation::kMostLoadPoints, Index{8}}) {
    Sheet sheet(most);
    for (double radius = 0.08; radius < 0.25; radius += 0.017)
      for (double x = 0.3; x < 0.7; x += 0.053) {
        const Vec3 point(x, 0.07, 0.0);
        const NamedForces::Named& force = sheet.put(point, radius);
        EXPECT_NEAR(std::accumulate(force.shares.begin(), force.shares.end(), 0.0), 1.0, 1e-6);
        EXPECT_TRUE(std::is_sorted(force.points.begin(), force.points.end()));
        EXPECT_LT((sheet.forces.active(sheet.state).front().first - point).norm(), 0.02) << x << " " << radius;
      }
  }
}

TEST(LoadPoints, AForceOnAPatchWithoutSimulationPointsActsThere) {
  Sheet sheet(kAll);
  // A place between simulation points.
  Vec3 place(0.5, 0.0, 0.0);
  const auto gap = [&](const Vec3& p) {
    double squared = 1.0;
    for (const Vec3& q : sheet.rest.points) squared = std::min(squared, (q - p).squaredNorm());
    return std::sqrt(squared);
  };
  for (const Vec3& p : sheet.cloud.positions)
    if ((p - Vec3(0.5, 0.0, 0.0)).norm() < 0.2 && gap(p) > gap(place)) place = p;
  ASSERT_GT(gap(place), 0.035);
  const NamedForces::Named& force = sheet.put(place, 0.03);
  EXPECT_EQ(sheet.notice, "");
  EXPECT_GT(force.points.size(), 3u);
  EXPECT_LT((sheet.forces.active(sheet.state).front().first - place).norm(), 0.01);
}

TEST(LoadPoints, AForceBesideACutStaysOnItsSide) {
  Sheet sheet(kAll);
  auto links = sheet.rest.model->links()->stretchLinks();
  const Points& rest = sheet.rest.points;
  const auto across = [&](const NamedForces::Named& force) {
    double sum = 0.0;
    for (std::size_t k = 0; k < force.points.size(); ++k)
      if (rest[force.points[k]].x() > 0.5) sum += std::abs(force.shares[k]);
    return sum;
  };
  // The patch ends before the points beyond the cut, but some of its points follow these.
  double right = 1.0;
  for (const Vec3& p : rest)
    if (p.x() > 0.5) right = std::min(right, p.x());
  const NamedForces::Named& force = sheet.put(Vec3(right - 0.2, 0.0, 0.0), 0.195);
  EXPECT_GT(across(force), 1e-4);
  const auto crosses = [&](const std::pair<Index, Index>& link) {
    return (rest[link.first].x() > 0.5) != (rest[link.second].x() > 0.5);
  };
  links.erase(std::remove_if(links.begin(), links.end(), crosses), links.end());
  const simulation::LoadPoints& load = *sheet.forces.loadPoints();
  sheet.forces.setSevered(simulation::findSevered(*load.between, links, static_cast<Index>(rest.size())));
  sheet.forces.followCut();
  // Points of the cloud that lie nearer to a simulation point beyond the cut belong to it.
  double beyond = 0.0;
  for (const NamedForces::Named::Carrier& carrier : *sheet.forces.all().front().carriers) {
    const Index s = carrier.point - static_cast<Index>(rest.size());
    if (rest[s < 0 ? carrier.point : load.between->cellOf(s)].x() > 0.5) beyond += carrier.share;
  }
  EXPECT_NEAR(across(sheet.forces.all().front()), beyond, 1e-6);
}

// A strip that is clamped at one end and loaded between a place and the other end: the end moves as that of a beam.
TEST(LoadPoints, AStripBendsAsABeamWhereverTheLoadedPatchEnds) {
  constexpr double kLength = 1.0, kWidth = 0.25, kClamp = 0.2, kFar = 20.0, kForce = 1e-4;
  const cloud::PointCloud strip = asCloud(makeSheet(121, 26, kClamp + kLength, kWidth, 0.3).points);
  double left = 1.0, low = 1.0, high = -1.0;
  for (const Vec3& p : strip.positions) {
    left = std::min(left, p.x());
    low = std::min(low, p.y());
    high = std::max(high, p.y());
  }
  const double middle = 0.5 * (low + high);
  std::vector<double> errors;
  for (const double edge : {0.61, 0.643, 0.71, 0.757, 0.83, 0.871}) {
    SceneParams p;
    p.material.young_modulus = 1e8;
    p.material.poisson_ratio = 0.0;
    p.material.thickness = 0.02;
    p.integrator.type = solve::IntegratorType::kStatic;
    p.gravity.setZero();
    p.accuracy.estimate = false;
    p.simplification.target_points = 200;
    simulation::PinParams pin;
    pin.region.min = Vec3(-10.0, -10.0, -10.0);
    pin.region.max = Vec3(left + kClamp, 10.0, 10.0);
    p.pins = {pin};
    p.forces = {{"load", Vec3(left + kClamp + edge + kFar, middle, 0.0), Vec3(0.0, 0.0, kForce), kFar, 0.0, 1e300}};
    Simulation s(p, strip);
    run(s, 1);
    const Points now = s.surface(false).positions;
    double deflection = 0.0, count = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i)
      if (strip.positions[i].x() > left + kClamp + kLength - 1e-6) {
        deflection += now[i].z();
        count += 1.0;
      }
    // Integral over the loaded length of x^2 (3 L - x) / 6 EI.
    const auto integral = [&](double x) { return kLength * x * x * x / 6.0 - x * x * x * x / 24.0; };
    const double exact =
        kForce / (kLength - edge) * (integral(kLength) - integral(edge)) / (p.material.bendingRigidity() * kWidth);
    errors.push_back(deflection / count / exact - 1.0);
  }
  const auto [least, most] = std::minmax_element(errors.begin(), errors.end());
  EXPECT_LT(*most - *least, 0.006);
  EXPECT_LT(std::max(-*least, *most), 0.02);
}

TEST(LoadPoints, ForksAndSnapshotsGoOnBitForBit) {
  SceneParams p = hangingSheet();
  p.forces = {{"pull", Vec3(0.9, 0.1, 0.0), Vec3(0.1, 0.0, 0.4), 0.11, 0.25, 0.6}};
  expectToGoOnBitForBit(p, sheetCloud(50), 40);
}

}  // namespace
}  // namespace deformable_surface::test
