// Points that a rest surface keeps for loads, and where simplification.density: adaptive makes points denser.
#include "../../src/simulation/wanted_spacing.h"

#include "clouds.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::RestSurface;
using simulation::SceneParams;

constexpr Index kWanted = 400;
// Of the patch that is held, m; the sheet lies between -0.5 and 0.5.
const Vec3 kMiddle(-0.2, 0.0, 0.0);
constexpr double kRadius = 0.08;

// A square plate, clamped at a small patch, on which a force acts at a point.
SceneParams makeScene() {
  SceneParams p;
  p.cloud.shape = simulation::CloudParams::Shape::kSheet;
  p.cloud.points = 5000;
  p.cloud.jitter = 0.3;
  p.simplification.target_points = kWanted;
  p.simplification.density = cloud::PointDensity::kAdaptive;
  simulation::PinParams pin;
  pin.region.kind = geometry::Region::Kind::kSphere;
  pin.region.center = kMiddle;
  pin.region.radius = kRadius;
  p.pins.push_back(pin);
  simulation::ForceParams force;
  force.id = "pull";
  force.point = Vec3(0.3, 0.1, 0.0);
  force.force = Vec3(0.0, 0.0, 1.0);
  p.forces.push_back(force);
  return p;
}

RestSurface build(const SceneParams& p, Index coarsest = simulation::kMaxIndex) {
  return simulation::buildRestSurface(p, io::makeShape(p.cloud), coarsest);
}

// Mean distance to the nearest other simulation point, of those in a ring about the pin.
double measureSpacing(const RestSurface& s, double low, double high) {
  const Lists nearest = cloud::nearestNeighbors(s.points, 1);
  double sum = 0.0;
  int count = 0;
  for (Index i = 0; i < nearest.size(); ++i) {
    const double from_middle = (s.points[i] - kMiddle).norm();
    if (from_middle < low || from_middle > high) continue;
    sum += (s.points[*nearest.begin(i)] - s.points[i]).norm();
    ++count;
  }
  return sum / count;
}

struct Dense {
  RestSurface surface;
  std::vector<char> is_boundary;
};

// The part of a rest surface from which the spacing is computed.
Dense makeDense(const SceneParams& p) {
  Dense dense;
  RestSurface& s = dense.surface;
  s.dense = cloud::clean(io::makeShape(p.cloud));
  s.dense.normals.assign(s.dense.positions.size(), Vec3::UnitZ());
  s.dense_neighbors = cloud::nearestNeighbors(s.dense.positions, 2 * p.neighbors.k);
  dense.is_boundary = cloud::findBoundary(s.dense.positions, s.dense.normals, s.dense_neighbors, p.neighbors.k).is_boundary;
  return dense;
}

// The nearest of the simulation points to a place.
bool holds(const RestSurface& s, const Vec3& place) {
  return std::any_of(s.points.begin(), s.points.end(), [&](const Vec3& p) { return p == place; });
}

// The point of the cloud nearest to a place.
Vec3 nearestOf(const SceneParams& p, const Vec3& place) {
  const cloud::PointCloud cloud = io::makeShape(p.cloud);
  return *std::min_element(cloud.positions.begin(), cloud.positions.end(),
                           [&](const Vec3& a, const Vec3& b) { return (a - place).squaredNorm() < (b - place).squaredNorm(); });
}

bool isTold(const RestSurface& s, const std::string& words) {
  return std::any_of(s.notes.begin(), s.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

simulation::ForceParams pullAt(const Vec3& point, const std::string& id) {
  return {id, point, Vec3(0.0, 0.0, 1.0), 0.0, 0.0, 1e300};
}

// A force and an anchor at places where even spacing has no point.
SceneParams makeLoadedScene() {
  SceneParams p = makeScene();
  simulation::AnchorParams anchor;
  anchor.point = anchor.target = Vec3(0.1, -0.33, 0.0);
  anchor.stiffness = 10.0;
  p.anchors.push_back(anchor);
  return p;
}

TEST(WantedSpacing, PointsWhereLoadsActAreSimulatedWithEitherDensity) {
  SceneParams p = makeLoadedScene();
  const Vec3 pulled = nearestOf(p, p.forces[0].point), anchored = nearestOf(p, p.anchors[0].point);
  for (const auto density : {cloud::PointDensity::kUniform, cloud::PointDensity::kAdaptive}) {
    p.simplification.density = density;
    for (const Index points : {60, 100, 200, 400}) {
      p.simplification.target_points = points;
      const RestSurface s = build(p);
      EXPECT_EQ(static_cast<Index>(s.points.size()), points);
      EXPECT_TRUE(holds(s, pulled)) << points;
      EXPECT_TRUE(holds(s, anchored)) << points;
    }
    p.simplification.target_points = 0;
    p.simplification.threshold.is_auto = false;
    p.simplification.threshold.value = 0.2;
    const RestSurface by_threshold = build(p);
    EXPECT_TRUE(holds(by_threshold, pulled));
    EXPECT_TRUE(holds(by_threshold, anchored));
    p.simplification.threshold.is_auto = true;
  }
}

TEST(WantedSpacing, CoarserCopiesKeepLoadedPointsAlsoWhereAllPointsAreSimulated) {
  SceneParams p = makeLoadedScene();
  p.simplification = cloud::SimplificationParams{};
  const Vec3 pulled = nearestOf(p, p.forces[0].point), anchored = nearestOf(p, p.anchors[0].point);
  for (const auto method : {cloud::SimplificationMethod::kDelaunay, cloud::SimplificationMethod::kNone}) {
    p.simplification.method = method;
    const RestSurface fine = build(p, 40);
    for (const Index points : {600, 160, 40}) {
      const RestSurface coarse = simulation::buildCoarser(p, fine, points);
      EXPECT_EQ(static_cast<Index>(coarse.points.size()), points);
      EXPECT_TRUE(holds(coarse, pulled)) << points;
      EXPECT_TRUE(holds(coarse, anchored)) << points;
    }
  }
}

TEST(WantedSpacing, LoadsAtOnePlaceKeepOnePoint) {
  SceneParams p = makeLoadedScene();
  const Points dense = io::makeShape(p.cloud).positions;
  const std::vector<Index> once = simulation::chooseLoadedPoints(p, dense);
  ASSERT_EQ(once.size(), 2u);
  p.forces.push_back(pullAt(p.forces[0].point, "again"));
  p.forces.push_back(pullAt(p.forces[0].point + Vec3(0.0, 0.0, 0.5), "from above"));
  p.anchors.push_back(p.anchors[0]);
  EXPECT_EQ(simulation::chooseLoadedPoints(p, dense), once);
}

TEST(WantedSpacing, LoadsThatActOnNoSinglePointKeepNone) {
  SceneParams p = makeScene();
  p.simplification.density = cloud::PointDensity::kUniform;
  p.forces.clear();
  const RestSurface without = build(p);
  simulation::ForceParams wide = pullAt(Vec3(0.3, 0.1, 0.0), "wide"), none = wide, over = wide;
  wide.radius = 0.1;
  none.id = "none";
  none.force.setZero();
  over.id = "over";
  over.start = -2.0;
  over.end = 0.0;
  p.forces = {wide, none, over};
  simulation::AnchorParams slack;
  slack.point = Vec3(0.1, -0.33, 0.0);
  p.anchors.push_back(slack);
  EXPECT_EQ(build(p).order.removed, without.order.removed);
}

TEST(WantedSpacing, MoreLoadsThanATenthOfThePointsKeepNoneAndThatIsTold) {
  SceneParams p = makeScene();
  p.simplification.density = cloud::PointDensity::kUniform;
  p.simplification.target_points = 60;
  p.forces.clear();
  const RestSurface without = build(p);
  const char* const kTold = "loads act on the nearest of these";
  for (int f = 0; f < 7; ++f) p.forces.push_back(pullAt(Vec3(0.4 - 0.1 * f, 0.27, 0.0), "f" + std::to_string(f)));
  const RestSurface many = build(p);
  EXPECT_EQ(many.order.removed, without.order.removed);
  EXPECT_TRUE(isTold(many, kTold));
  p.forces.pop_back();
  const RestSurface fewer = build(p);
  EXPECT_FALSE(isTold(fewer, kTold));
  for (const simulation::ForceParams& force : p.forces) EXPECT_TRUE(holds(fewer, nearestOf(p, force.point)));
  // For a threshold it is the number of points that remain: here about as many.
  p.forces.push_back(pullAt(Vec3(-0.3, 0.27, 0.0), "last"));
  p.simplification.target_points = 0;
  p.simplification.threshold.is_auto = false;
  for (const double threshold : {0.35, 0.15}) {
    p.simplification.threshold.value = threshold;
    const RestSurface s = build(p);
    EXPECT_EQ(isTold(s, kTold), s.points.size() < 70) << s.points.size();
  }
  // An accuracy target tries few points first, and its copies have fewer.
  p.simplification = cloud::SimplificationParams{};
  for (int f = 0; f < 7; ++f) p.forces.push_back(pullAt(Vec3(0.4 - 0.1 * f, -0.27, 0.0), "g" + std::to_string(f)));
  EXPECT_FALSE(isTold(build(p), kTold));
  p.accuracy.position_error = 1e-3;
  EXPECT_TRUE(isTold(build(p), kTold));
}

TEST(WantedSpacing, ParticlesKeepNoneForLoads) {
  SceneParams p = makeScene();
  p.model = "oriented_particles";
  p.cloud.points = 1000;
  p.simplification.target_points = 100;
  p.simplification.density = cloud::PointDensity::kUniform;
  const RestSurface loaded = build(p);
  p.forces.clear();
  EXPECT_EQ(loaded.order.removed, build(p).order.removed);
}

TEST(WantedSpacing, StaysWithinItsBoundsAndGrowsGently) {
  const SceneParams p = makeScene();
  const Dense dense = makeDense(p);
  const Points& x = dense.surface.dense.positions;
  const Lists& neighbors = dense.surface.dense_neighbors;
  for (const Index target : {60, 400, 2000}) {
    const std::vector<double> wanted = simulation::findWantedSpacing(p, dense.is_boundary, target, dense.surface);
    ASSERT_EQ(wanted.size(), x.size());
    const double mean_spacing = std::sqrt(1.0 / target);
    double needed = 0.0;
    for (Index i = 0; i < neighbors.size(); ++i) {
      EXPECT_GE(wanted[i], simulation::kFinestWanted);
      EXPECT_LE(wanted[i], simulation::kCoarsestWanted);
      needed += 1.0 / (wanted[i] * wanted[i] * static_cast<double>(x.size()));
      for (const Index* j = neighbors.begin(i); j != neighbors.begin(i) + 6; ++j) {
        if (p.pins[0].region.contains(x[i]) || p.pins[0].region.contains(x[*j])) continue;
        // Within a tenth: the area that determines the mean spacing is estimated from the points.
        EXPECT_LE(wanted[*j] - wanted[i], 1.1 * simulation::kWantedGrowth * (x[*j] - x[i]).norm() / mean_spacing);
      }
    }
    EXPECT_NEAR(needed, 1.0, 0.03) << target;  // the points of a jittered sheet represent unequal areas
  }
}

TEST(WantedSpacing, KeepsExactlyAsManyPointsAsAreAskedForAndCrowdsThemAtTheClamp) {
  SceneParams p = makeScene();
  const RestSurface adaptive = build(p);
  EXPECT_EQ(static_cast<Index>(adaptive.points.size()), kWanted);
  EXPECT_LT(measureSpacing(adaptive, 0.0, 2.0 * kRadius), 0.8 * measureSpacing(adaptive, 0.3, 0.4));
  p.simplification.density = cloud::PointDensity::kUniform;
  const RestSurface uniform = build(p);
  EXPECT_LT(measureSpacing(adaptive, 0.0, 2.0 * kRadius), 0.9 * measureSpacing(uniform, 0.0, 1.0));
}

TEST(WantedSpacing, CoarserCopiesAreGradedPartsOfTheFiner) {
  const SceneParams p = makeScene();
  const RestSurface fine = build(p, kWanted / 4);
  const RestSurface coarse = simulation::buildCoarser(p, fine, kWanted / 4);
  EXPECT_EQ(static_cast<Index>(coarse.points.size()), kWanted / 4);
  const std::vector<Index>&few = coarse.dense_index, &many = fine.dense_index;
  EXPECT_TRUE(std::includes(many.begin(), many.end(), few.begin(), few.end()));
  EXPECT_LT(measureSpacing(coarse, 0.0, 2.5 * kRadius), 0.9 * measureSpacing(coarse, 0.3, 0.5));
}

TEST(WantedSpacing, HasTheSameBitsForEveryNumberOfThreads) {
  const SceneParams p = makeScene();
  setNumThreads(1);
  const RestSurface one = build(p);
  setNumThreads(3);
  const RestSurface three = build(p);
  setNumThreads(0);
  EXPECT_EQ(one.order.removed, three.order.removed);
  EXPECT_EQ(one.order.diameter, three.order.diameter);
}

// A row of held points is a hinge. A clamp along a whole side bends the surface evenly along that side.
TEST(WantedSpacing, IsEvenToTheBitWhereNoSmallPinClampsAndNoForceActsOnAPoint) {
  SceneParams p = makeScene();
  p.forces[0].radius = 0.3;
  p.pins.resize(2);
  p.pins[0].region.kind = p.pins[1].region.kind = geometry::Region::Kind::kBox;
  p.pins[0].region.min = p.pins[1].region.min = Vec3(-1.0, -1.0, -1.0);
  p.pins[0].region.max = Vec3(-0.4, 1.0, 1.0);
  p.pins[1].region.min.x() = 0.499;
  p.pins[1].region.max = Vec3(1.0, 1.0, 1.0);
  const RestSurface adaptive = build(p);
  p.simplification.density = cloud::PointDensity::kUniform;
  const RestSurface uniform = build(p);
  EXPECT_EQ(adaptive.order.removed, uniform.order.removed);
  EXPECT_EQ(adaptive.order.diameter, uniform.order.diameter);
  EXPECT_EQ(adaptive.points, uniform.points);
  EXPECT_TRUE(isTold(adaptive, "points are spaced evenly"));
  EXPECT_EQ(adaptive.notes.size(), uniform.notes.size() + 1);
}

}  // namespace
}  // namespace deformable_surface::test
