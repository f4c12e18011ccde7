// The figures of the paper on meshfree elasticity with point cloud geodesics. Parts of a body that are close in space move
// separately. They stick together if neighbours are the nearest points in space.
#include "support/figures.h"
#include "../../src/simulation/dynamics.h"

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <map>
#include <set>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kFar = 100.0;  // m, beyond every cloud

Simulation runFigure(SceneParams scene, const OrAuto<double>& geodesic_exponent) {
  scene.neighbors.geodesic_exponent = geodesic_exponent;
  scene.accuracy.estimate = false;
  Simulation s = makeSimulation(scene);
  runScene(s);
  return s;
}

const OrAuto<double> kAuto, kEuclidean(1.0), kPublished(15.0);

class TwoBars : public testing::TestWithParam<const char*> {};

// Figure 8. The bounds in the scene, which the tests of scenes check, are for auto.
TEST_P(TwoBars, TheLowerBarBendsDownUnlessNeighboursAreTheNearestInSpace) {
  SceneParams scene = loadScene(GetParam());
  scene.duration = 0.6;                                      // by then it has done most of its bending
  const Vec3 low(0.9, -kFar, -kFar), high(kFar, kFar, 0.0);  // the tip of the lower bar
  Simulation by_auto = runFigure(scene, kAuto), published = runFigure(scene, kPublished),
             euclidean = runFigure(scene, kEuclidean);
  const double bent = findLargestMotion(by_auto, low, high);
  EXPECT_GT(bent, 0.2);
  // With 15, true links lose a fifth of their weight (docs/geodesics.md), so the bar is softer.
  EXPECT_NEAR(findLargestMotion(published, low, high), bent, 0.3 * bent);
  EXPECT_LT(findLargestMotion(euclidean, low, high), 0.05 * bent);
}

// The table of docs/elastic_solid.md.
TEST(TwoBarsSolid, BendAsFarAsThePageSays) {
  const SceneParams scene = loadScene("two_bars_solid");
  const Vec3 low(0.9, -kFar, -kFar), high(kFar, kFar, 0.0);
  Simulation by_auto = runFigure(scene, kAuto), published = runFigure(scene, kPublished);
  EXPECT_NEAR(findLargestMotion(by_auto, low, high), 0.31, 0.005);
  EXPECT_NEAR(findLargestMotion(published, low, high), 0.38, 0.005);
}

INSTANTIATE_TEST_SUITE_P(, TwoBars, testing::Values("two_bars_solid", "two_bars_block"),
                         [](const auto& info) { return std::string(info.param); });

// Their forces end before the other side of the slit. If the cutoff reaches across it, they pull, though less than bonds do.
TEST(Figures, TheLowerBarOfParticlesBendsDownAndFeelsNothingAcrossTheSlit) {
  SceneParams scene = loadScene("two_bars_particles");
  const Vec3 low(0.9, -kFar, -kFar), high(kFar, kFar, 0.0);
  Simulation by_default = runFigure(scene, kAuto);
  const double bent = findLargestMotion(by_default, low, high);
  EXPECT_GT(bent, 0.15);
  scene.duration = 0.5;
  scene.oriented_particles.cutoff = 1.9;
  Simulation by_auto = runFigure(scene, kAuto), euclidean = runFigure(scene, kEuclidean);
  EXPECT_GT(findLargestMotion(by_auto, low, high), 1.3 * findLargestMotion(euclidean, low, high));
}

// Figure 9.
TEST(Figures, PullingOneLegOfTrousersLeavesTheOtherWhereItIs) {
  const SceneParams scene = loadScene("trousers");
  const Vec3 low(-kFar, -kFar, -kFar), high(-0.01, 0.7, kFar);
  constexpr double kPull = 0.1;
  Simulation by_auto = runFigure(scene, kAuto), published = runFigure(scene, kPublished),
             euclidean = runFigure(scene, kEuclidean);
  EXPECT_LT(findLargestMotion(by_auto, low, high), 0.01 * kPull);
  EXPECT_LT(findLargestMotion(published, low, high), 0.01 * kPull);
  EXPECT_GT(findLargestMotion(euclidean, low, high), 0.1 * kPull);
}

// Figure 10.
TEST(Figures, AnArmOfTheOctopusWavesOnItsOwn) {
  const SceneParams scene = loadScene("octopus");
  const Vec3 low(-kFar, -kFar, -kFar), high(0.115, 0.0, kFar);  // the other five arms
  constexpr double kPull = 0.15;
  Simulation by_auto = runFigure(scene, kAuto), published = runFigure(scene, kPublished),
             euclidean = runFigure(scene, kEuclidean);
  EXPECT_LT(findLargestMotion(by_auto, low, high), 0.01 * kPull);
  EXPECT_LT(findLargestMotion(published, low, high), 0.01 * kPull);
  EXPECT_GT(findLargestMotion(euclidean, low, high), 0.1 * kPull);
}

// The same with outlines from other sources, in units of their diagonal. Skipped where they are missing.
cloud::PointCloud asCloud(const Points& points) {
  cloud::PointCloud cloud;
  cloud.positions = points;
  cloud.width = static_cast<std::uint32_t>(points.size());
  return cloud;
}

const char* const kFlat = R"(
model: elastic_solid
material: {young_modulus: 1.0e5, poisson_ratio: 0.3, thickness: 0.01, density: 300.0, damping: 10.0}
accuracy: {estimate: false}
gravity: [0, 0, 0]
duration: 1.0
)";

TEST(SharedOutlines, PullingOneLegOfTrousersLeavesTheOtherWhereItIs) {
  const Points points = readSharedPoints("seedB_octopus_pants_2d/pants_2d.obj");
  if (points.empty()) GTEST_SKIP() << "no seedB_octopus_pants_2d";
  const SceneParams scene = parseScene(std::string(kFlat) + R"(
pins: [{box: {min: [-1, 0.0, -1], max: [1, 1, 1]}}]
tools: [{id: hand, mode: move, shape: {box: {size: [0.26, 0.06, 0.1]}},
         path: [{position: [0.22, -0.38, 0]}, {time: 0.5, position: [0.27, -0.38, 0]}]}]
)");
  Simulation s(scene, asCloud(points));
  runScene(s);
  EXPECT_NEAR(findLargestMotion(s, Vec3(0.1, -1.0, -1.0), Vec3(1.0, -0.36, 1.0)), 0.05, 0.005);
  EXPECT_LT(findLargestMotion(s, Vec3(-1.0, -1.0, -1.0), Vec3(0.0, 0.0, 1.0)), 0.01 * 0.05);
}

TEST(SharedOutlines, AnArmOfTheOctopusWavesOnItsOwn) {
  const Points points = readSharedPoints("seedB_octopus_pants_2d/octopus_2d.obj");
  if (points.empty()) GTEST_SKIP() << "no seedB_octopus_pants_2d";
  const SceneParams scene = parseScene(std::string(kFlat) + R"(
simplification: {target_points: 1500}
pins: [{box: {min: [-0.13, -0.09, -1], max: [0.16, 0.15, 1]}}]
tools: [{id: hand, mode: move, shape: {box: {size: [0.06, 0.06, 0.1]}},
         path: [{position: [0.38, 0.02, 0]}, {time: 0.5, position: [0.43, 0.07, 0]}]}]
)");
  Simulation s(scene, asCloud(points));
  runScene(s);
  const double pull = 0.05 * std::sqrt(2.0);
  EXPECT_NEAR(findLargestMotion(s, Vec3(0.36, -1.0, -1.0), Vec3(1.0, 0.05, 1.0)), pull, 0.1 * pull);
  // All arms on the left, and those below on the right.
  EXPECT_LT(findLargestMotion(s, Vec3(-1.0, -1.0, -1.0), Vec3(-0.13, 1.0, 1.0)), 0.01 * pull);
  EXPECT_LT(findLargestMotion(s, Vec3(0.0, -1.0, -1.0), Vec3(1.0, -0.06, 1.0)), 0.01 * pull);
}

// Of the faces around every point.
Points findNormals(const Points& points, const std::vector<std::vector<Index>>& faces) {
  Points normals(points.size(), Vec3::Zero());
  for (const std::vector<Index>& face : faces)
    for (const Index corner : face)
      normals[corner] += (points[face[1]] - points[face[0]]).cross(points[face[2]] - points[face[0]]);
  for (Vec3& n : normals) n.normalize();
  return normals;
}

// In space they are cloth, with nothing inside: mass_spring. Where the legs are close, the gap is down to half of the spacing
// along them. Only the mesh's normals separate the sides there (docs/geodesics.md).
TEST(SharedGarments, PullingOneLegOfTrousersInSpaceLeavesTheOtherWhereItIs) {
  struct Case {
    const char* file;
    const char* points;
  };
  const char* const kApart = "trousers_cc0.obj";
  const char* const kClose = "trousers_cc0_legs_close.obj";
  for (const Case& c : {Case{kApart, "1500"}, Case{kClose, "1500"}, Case{kClose, "3881"}}) {
    const std::string file = std::string("trousers_cc0/") + c.file;
    cloud::PointCloud cloud = asCloud(readSharedPoints(file));
    if (cloud.positions.empty()) GTEST_SKIP() << "no trousers_cc0";
    cloud.normals = findNormals(cloud.positions, readSharedFaces(file));
    const SceneParams scene = parseScene(std::string(R"(
model: mass_spring
material: {young_modulus: 1.0e5, thickness: 0.001, density: 300.0, damping: 10.0}
accuracy: {estimate: false}
gravity: [0, 0, 0]
duration: 0.6
pins: [{box: {min: [-1, 0.68, -1], max: [1, 2, 1]}}]
tools: [{id: hand, mode: move, shape: {box: {size: [0.3, 0.08, 0.4]}},
         path: [{position: [0.155, 0, 0]}, {time: 0.4, position: [0.255, 0, 0]}]}]
simplification: {target_points: )") + c.points +
                                         "}");
    Simulation s(scene, cloud);
    runScene(s);
    EXPECT_NEAR(findLargestMotion(s, Vec3(0.005, -1.0, -1.0), Vec3(1.0, 0.03, 1.0)), 0.1, 0.01) << c.file << ' ' << c.points;
    EXPECT_LT(findLargestMotion(s, Vec3(-1.0, -1.0, -1.0), Vec3(-0.005, 0.6, 1.0)), 0.01 * 0.1) << c.file << ' ' << c.points;
    // Points in line beside the gap span no triangles. They would ask for fifteen times as many points.
    EXPECT_LT(s.dynamics().lastSubsteps(), 200) << c.file << ' ' << c.points;
  }
}

// Over the edges of the faces from a point, as far as reach.
std::map<Index, double> measureWays(const std::vector<std::vector<Index>>& edges, const Points& points, Index from,
                                    double reach) {
  std::map<Index, double> ways;
  std::set<std::pair<double, Index>> open{{0.0, from}};
  while (!open.empty()) {
    const auto [way, i] = *open.begin();
    open.erase(open.begin());
    if (!ways.emplace(i, way).second) continue;
    for (const Index j : edges[i])
      if (way + (points[j] - points[i]).norm() < reach) open.emplace(way + (points[j] - points[i]).norm(), j);
  }
  return ways;
}

// Between points that share a face.
std::vector<std::vector<Index>> findEdges(Index num_points, const std::vector<std::vector<Index>>& faces) {
  std::vector<std::vector<Index>> edges(num_points);
  for (const std::vector<Index>& face : faces)
    for (std::size_t c = 0; c < face.size(); ++c) {
      edges[face[c]].push_back(face[(c + 1) % face.size()]);
      edges[face[(c + 1) % face.size()]].push_back(face[c]);
    }
  return edges;
}

// Front and back of the shirt are half a spacing apart. Its faces determine which points are near along the cloth.
TEST(SharedGarments, SpringsOfAShirtThatLiesFlatDoNotJoinItsFrontToItsBack) {
  const char* const kFile = "diffcloth_garments/tshirt1900-flattened.obj";
  const Points points = readSharedPoints(kFile);
  if (points.empty()) GTEST_SKIP() << "no diffcloth_garments";
  const std::vector<std::vector<Index>> edges = findEdges(static_cast<Index>(points.size()), readSharedFaces(kFile));
  double wrong[2];
  for (const bool is_auto : {false, true}) {
    SceneParams scene = parseScene("{model: mass_spring, simplification: {method: none}}");
    if (!is_auto) scene.neighbors.geodesic_exponent = kEuclidean;
    const Simulation s(scene, asCloud(points));
    double far = 0.0, all = 0.0;
    for (const auto& [i, j] : stretchLinksOf(s.model())) {
      const double length = (s.state().positions[j] - s.state().positions[i]).norm();
      far += measureWays(edges, points, i, 3.0 * length).count(j) == 0;
      all += 1.0;
    }
    wrong[is_auto] = far / all;
  }
  EXPECT_GT(wrong[0], 0.02);
  EXPECT_LT(wrong[1], 0.25 * wrong[0]);
}

// The same shirt with neighbours along its faces. Only those count that are hardly nearer in space.
simulation::Dynamics makeTrueShirt(const SceneParams& scene, const cloud::PointCloud& shirt,
                                   const std::vector<std::vector<Index>>& faces) {
  constexpr double kDirect = 1.7;  // beyond it a path along edges is a detour
  constexpr Index kNear = 64, kListed = 16;
  const Points& x = shirt.positions;
  const Index n = shirt.size();
  const std::vector<std::vector<Index>> edges = findEdges(n, faces);
  const Lists near = cloud::nearestNeighbors(x, kNear);
  Lists listed;
  for (Index i = 0; i < n; ++i) {
    const auto lengthTo = [&](Index j) { return (x[j] - x[i]).norm(); };
    const std::map<Index, double> ways = measureWays(edges, x, i, kDirect * lengthTo(near.begin(i)[kNear - 1]));
    Index count = 0;
    for (const Index* j = near.begin(i); j != near.end(i) && count < kListed; ++j) {
      const auto way = ways.find(*j);
      if (way == ways.end() || !(way->second < kDirect * lengthTo(*j))) continue;
      listed.items.push_back(*j);
      ++count;
    }
    listed.offsets.push_back(static_cast<Index>(listed.items.size()));
  }
  simulation::RestSurface s;
  s.points = s.dense.positions = x;
  s.normals = shirt.normals;
  s.rings = cloud::buildRings(s.points, s.normals, listed);
  for (Index i = 0; i < n; ++i) {
    s.area += s.rings.area[i];
    s.dense_index.push_back(i);
    const auto holds = [&](const simulation::PinParams& pin) { return pin.region.contains(x[i]); };
    const auto pin = std::find_if(scene.pins.begin(), scene.pins.end(), holds);
    s.pinned.push_back(pin != scene.pins.end());
    s.pin_of.push_back(s.pinned[i] ? static_cast<Index>(pin - scene.pins.begin()) : -1);
  }
  s.pinned_turns.assign(n, 0);
  s.model = std::make_unique<model::MassSpring>(s.points, s.normals, s.rings, s.area, false, scene.material, scene.mass_spring);
  s.model->clamping()->setHeld(s.pinned, {});
  return simulation::Dynamics(scene, std::move(s));
}

// One point pulls the front away, in space, while collar, hem and sleeves are held. The back, half a spacing away, stays.
TEST(SharedGarments, TheFrontOfAShirtThatLiesFlatLeavesItsBackWhereItIs) {
  const char* const kFile = "diffcloth_garments/tshirt1900-flattened.obj";
  cloud::PointCloud shirt = asCloud(readSharedPoints(kFile));
  if (shirt.positions.empty()) GTEST_SKIP() << "no diffcloth_garments";
  for (Vec3& p : shirt.positions) p *= 0.1;  // decimetres
  const std::vector<std::vector<Index>> faces = readSharedFaces(kFile);
  shirt.normals = findNormals(shirt.positions, faces);
  SceneParams scene = parseScene(R"(
model: mass_spring
material: {young_modulus: 1.0e5, thickness: 0.001, density: 300.0, damping: 10.0}
accuracy: {estimate: false}
simplification: {method: none}
gravity: [0, 0, 0]
duration: 0.6
pins: [{box: {min: [-1, -1, -1], max: [1, 1, -0.275]}}, {box: {min: [-1, -1, 0.271], max: [1, 1, 1]}},
       {box: {min: [-1, -1, -1], max: [-0.15, 1, 1]}}, {box: {min: [0.15, -1, -1], max: [1, 1, 1]}}]
forces: [{id: draw, point: [0.008, -0.151, 0.022], force: [0, 0.3, 0]}]
)");
  simulation::Dynamics true_shirt = makeTrueShirt(scene, shirt, faces);
  const long steps = std::lround(scene.duration / scene.integrator.time_step);
  for (long k = 0; k < steps; ++k) ASSERT_TRUE(true_shirt.step().ok);
  const Points& exact = true_shirt.state().positions;
  double drawn = 0.0;
  for (Index i = 0; i < shirt.size(); ++i) drawn = std::max(drawn, (exact[i] - shirt.positions[i]).norm());
  EXPECT_GT(drawn, 0.05);
  double error[2], back[2];
  for (const bool is_auto : {false, true}) {
    scene.neighbors.geodesic_exponent = is_auto ? kAuto : kEuclidean;
    Simulation s(scene, shirt);
    runScene(s);
    const Points& now = s.surface(false).positions;
    double sum = 0.0;
    back[is_auto] = 0.0;
    for (Index i = 0; i < shirt.size(); ++i) {
      sum += (now[i] - exact[i]).squaredNorm() / shirt.size();
      // The normals of the back point away from the direction of the pull.
      if (shirt.normals[i].y() < -0.5) back[is_auto] = std::max(back[is_auto], (now[i] - shirt.positions[i]).norm());
    }
    error[is_auto] = std::sqrt(sum);
  }
  // Seams lose links, so the front is softer there. Sixteen and 32 neighbours along the faces differ by a tenth of that.
  EXPECT_LT(error[true], 0.04 * drawn);
  EXPECT_GT(error[false], 0.1 * drawn);
  EXPECT_LT(back[true], 0.01 * drawn);
  EXPECT_GT(back[false], 0.1 * drawn);
}

}  // namespace
}  // namespace deformable_surface::test
