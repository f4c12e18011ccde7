#include "accuracy_scenes.h"

#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/cloud/simplification.h"
#include "deformable_surface/io/shapes.h"
#include "physics/references.h"
#include "physics/samplings.h"
#include "swinging_sheet.h"

#include <fstream>
#include <limits>

namespace deformable_surface::benchmark {
namespace {

using simulation::PinParams;
using simulation::SceneParams;

std::vector<Index> halve(Index points) { return {points, points / 2, points / 4, points / 8}; }

PinParams pinBox(const Vec3& min, const Vec3& max) {
  PinParams pin;
  pin.region.min = min;
  pin.region.max = max;
  return pin;
}

AccuracyScene makeSwing(const std::string& name, double membrane_stiffness, Index points) {
  AccuracyScene scene{name, makeSwingingScene(solve::IntegratorType::kAuto, 0.01), makeSwingingSheet(points), 0.4, {}, {}};
  scene.params.simplification.method = cloud::SimplificationMethod::kDelaunay;
  scene.params.material.young_modulus = membrane_stiffness / scene.params.material.thickness;
  scene.levels = halve(scene.cloud.size());
  return scene;
}

// A sheet of rubber between two held edges, sagging under its weight.
AccuracyScene makeSag(Index points) {
  AccuracyScene scene{"static_sag", {}, {}, 0.0, {}, {}};
  simulation::CloudParams shape;
  shape.shape = simulation::CloudParams::Shape::kSheet;
  shape.points = points;
  shape.jitter = 0.2;
  scene.cloud = io::makeShape(shape);
  scene.params.material.young_modulus = 1e6;
  scene.params.material.thickness = 0.002;
  scene.params.integrator.type = solve::IntegratorType::kStatic;
  scene.params.pins = {pinBox(Vec3(-1.0, -1.0, -1.0), Vec3(-0.499, 1.0, 1.0)),
                       pinBox(Vec3(0.499, -1.0, -1.0), Vec3(1.0, 1.0, 1.0))};
  scene.levels = halve(scene.cloud.size());
  return scene;
}

// The points of the scan that simplification keeps: real sampling, with few enough points to be simulated without simplification.
cloud::PointCloud readScan(Index points) {
  std::ifstream file(physics::dataFolder() + "/open3d_bunny/bunnyData.pts");
  cloud::PointCloud scan;
  std::size_t count = 0;
  file >> count;
  for (Vec3 p; scan.positions.size() < count && file >> p[0] >> p[1] >> p[2];) scan.positions.push_back(p);
  if (scan.positions.empty()) return scan;
  const Lists neighbors = cloud::nearestNeighbors(scan.positions, 32);
  const Points normals = cloud::estimateNormals(scan.positions, neighbors);
  cloud::PointCloud kept;
  for (Index i : cloud::simplify(scan.positions, normals, 16, points, {}).keepCount(points))
    kept.positions.push_back(scan.positions[i]);
  kept.width = kept.size();
  return kept;
}

// A scanned animal of soft rubber that stands on its lowest centimetre and is poked from the side.
AccuracyScene makePoke(Index points) {
  AccuracyScene scene{"poked_scan", {}, readScan(points), 0.3, {}, {}};
  if (scene.cloud.positions.empty()) return scene;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3& p : scene.cloud.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = (high - low).maxCoeff();
  scene.params.gravity = Vec3(0.0, -9.81, 0.0);  // the scan's y axis points up
  scene.params.material.young_modulus = 2e5;
  scene.params.material.thickness = 0.004;
  scene.params.material.damping = 5.0;
  scene.params.pins = {pinBox(low - Vec3::Ones(), Vec3(high.x() + 1.0, low.y() + 0.1 * size, high.z() + 1.0))};
  simulation::ForceParams poke;
  poke.id = "poke";
  poke.point = Vec3(high.x(), 0.5 * (low.y() + high.y()), 0.5 * (low.z() + high.z()));
  poke.force = Vec3(-0.3, 0.0, 0.0);
  poke.radius = 0.15 * size;
  scene.params.forces = {poke};
  scene.levels = halve(points);
  return scene;
}

// A sheet that falls on a ball and drapes over it.
AccuracyScene makeDrape(Index points) {
  AccuracyScene scene{"drape", {}, makeSwingingSheet(points), 0.4, {}, {}};
  scene.params.material.young_modulus = 1e6;
  scene.params.material.density = 200.0;
  scene.params.material.damping = 2.0;
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.25;
  ball.path = {{0.0, Vec3(0.0, 0.0, -0.26), Vec4(0.0, 0.0, 0.0, 1.0)}};
  scene.params.tools = {ball};
  scene.levels = halve(scene.cloud.size());
  return scene;
}

// A towel on a table, of which one edge is carried over the other: it meets itself and stays folded. Scattered points.
AccuracyScene makeFold(Index points) {
  AccuracyScene scene{"fold", {}, {}, 1.0, {}, {}};
  simulation::CloudParams cloud;
  cloud.shape = simulation::CloudParams::Shape::kSheet;
  cloud.points = points;
  cloud.size = Vec2(0.3, 0.3);
  cloud.jitter = 0.3;
  scene.cloud = io::makeShape(cloud);
  scene.params.material.young_modulus = 3e5;
  scene.params.material.thickness = 0.001;
  scene.params.material.density = 250.0;
  scene.params.material.bending_rigidity = 2e-5;
  scene.params.material.damping = 5.0;
  scene.params.contact.self = true;
  tool::ToolParams table, hand;
  table.id = "table";
  table.friction = 0.5;
  table.shape.kind = geometry::Solid::Kind::kPlane;
  table.path = {{0.0, Vec3(0.0, 0.0, -1e-4), Vec4(0.0, 0.0, 0.0, 1.0)}};
  hand.id = "hand";
  hand.mode = tool::Mode::kMove;
  hand.shape.kind = geometry::Solid::Kind::kBox;
  hand.shape.size = Vec3(0.02, 0.4, 0.04);
  hand.end = 0.85;
  constexpr int kWaypoints = 13;
  for (int i = 0; i <= kWaypoints; ++i) {  // along half an ellipse, slowly at both ends
    const double share = static_cast<double>(i) / kWaypoints, angle = M_PI * share * share * (3.0 - 2.0 * share);
    hand.path.push_back(
        {0.8 * share, Vec3(0.02 + 0.13 * std::cos(angle), 0.0, 0.005 + 0.09 * std::sin(angle)), Vec4(0.0, 0.0, 0.0, 1.0)});
  }
  scene.params.tools = {table, hand};
  scene.levels = halve(scene.cloud.size());
  return scene;
}

// A plate of scattered points with small bending, so that theories of small deflections are valid. Poisson's ratio 0, as for a
// beam.
constexpr double kWeak = 0.01;  // m/s^2, of gravity

AccuracyScene makePlate(const std::string& name, simulation::CloudParams::Shape shape, const Vec2& size, double duration) {
  AccuracyScene scene{name, {}, {}, duration, {}, {}};
  simulation::CloudParams cloud;
  cloud.shape = shape;
  cloud.points = 10000;
  cloud.size = size;
  cloud.jitter = 0.3;
  scene.cloud = io::makeShape(cloud);
  scene.params.material.young_modulus = 1e8;
  scene.params.material.poisson_ratio = 0.0;
  scene.params.material.thickness = 0.02;
  scene.params.material.density = 250.0;
  if (duration == 0.0) scene.params.integrator.type = solve::IntegratorType::kStatic;
  scene.levels = {1600, 800, 400, 200, 100};
  return scene;
}

// A beam of 1 m under a thousandth of its weight, clamped at a place that does not depend on its points: at rest, or released at
// time zero.
AccuracyScene makeCantilever(const std::string& name, double duration) {
  const double clamp = 0.2037, length = 1.0;
  AccuracyScene scene = makePlate(name, simulation::CloudParams::Shape::kStrip, Vec2(clamp + length, 0.25), duration);
  scene.params.gravity = -kWeak * Vec3::UnitZ();
  scene.params.pins = {pinBox(Vec3(-1.0, -1.0, -1.0), Vec3(clamp, 1.0, 1.0))};
  const double areal_density = scene.params.material.arealDensity(), rigidity = scene.params.material.bendingRigidity();
  scene.exact = [=](const Vec3& rest) {
    const double share = std::max(0.0, (rest.x() - clamp) / length), time_scale = std::sqrt(areal_density / rigidity);
    return Vec3(rest - kWeak * areal_density / rigidity *
                           physics::sagCantilever(share, duration > 0.0 ? duration / time_scale : physics::kAtRest) *
                           Vec3::UnitZ());
  };
  return scene;
}

// A square plate of 1 m, clamped all around, under a thousandth of its weight.
AccuracyScene makeClampedPlate() {
  AccuracyScene scene = makePlate("clamped_plate", simulation::CloudParams::Shape::kSheet, Vec2(1.4, 1.4), 0.0);
  scene.params.gravity = -kWeak * Vec3::UnitZ();
  const double far = 1.0, half = 0.5;
  const Vec3 low(-far, -far, -far), high(far, far, far);
  scene.params.pins = {pinBox(low, Vec3(-half, far, far)), pinBox(Vec3(half, -far, -far), high),
                       pinBox(low, Vec3(far, -half, far)), pinBox(Vec3(-far, half, -far), high)};
  const double load = kWeak * scene.params.material.arealDensity() / scene.params.material.bendingRigidity();
  scene.exact = [load, sag = physics::ClampedPlate()](const Vec3& rest) {
    return Vec3(rest - load * sag(rest.x() + 0.5, rest.y() + 0.5) * Vec3::UnitZ());
  };
  return scene;
}

// Soft rubber without damping; size along x, y, z, m. Its middle plane is z = 0, and it begins at x = 0.
AccuracyScene makeSolid(const std::string& name, const Vec3& size, Index points) {
  AccuracyScene scene{name, {}, {}, 0.4, {}, {}};
  simulation::CloudParams shape;
  shape.shape = simulation::CloudParams::Shape::kBar;
  shape.points = points;
  shape.size = size.head<2>();
  shape.height = size.z();
  shape.jitter = 0.2;
  scene.cloud = io::makeShape(shape);
  scene.params.model = "elastic_solid";
  scene.params.material.young_modulus = 1e5;
  scene.params.material.poisson_ratio = 0.3;
  scene.params.material.density = 1000.0;
  scene.levels = halve(scene.cloud.size());
  return scene;
}

// Clamped at one end: it falls under its weight and swings, or is stretched by its weight.
AccuracyScene makeSolidBar(const std::string& name, const Vec3& gravity, Index points) {
  AccuracyScene scene = makeSolid(name, Vec3(1.0, 0.1, 0.1), points);
  scene.params.gravity = gravity;
  scene.params.pins = {pinBox(Vec3(-1.0, -1.0, -1.0), Vec3(1e-6, 1.0, 1.0))};
  return scene;
}

// A block that is held from below. A ball is pressed into it.
AccuracyScene makeSolidIndentation(Index points) {
  AccuracyScene scene = makeSolid("solid_indentation", Vec3(0.3, 0.3, 0.1), points);
  scene.params.gravity.setZero();
  scene.params.material.damping = 2.0;
  scene.params.pins = {pinBox(Vec3(-1.0, -1.0, -1.0), Vec3(1.0, 1.0, -0.05 + 1e-6))};
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.1;
  const Vec4 upright(0.0, 0.0, 0.0, 1.0);
  ball.path = {{0.0, Vec3(0.15, 0.0, 0.15), upright}, {0.2, Vec3(0.15, 0.0, 0.13), upright}};
  scene.params.tools = {ball};
  return scene;
}

}  // namespace

std::vector<AccuracyScene> makeStaticScenes(bool large) {
  std::vector<AccuracyScene> scenes;
  for (const bool hangs : {false, true})
    for (const double young_modulus : {1e5, 1e6, 1e7, 1e8, 1e9}) {
      AccuracyScene scene = makeSag(large ? 1254 : 400);
      scene.params.material.young_modulus = young_modulus;
      if (hangs) scene.params.pins.pop_back();
      scene.name = hangs ? "hangs from an edge" : "between two edges";
      scenes.push_back(std::move(scene));
    }
  return scenes;
}

std::vector<AccuracyScene> makeAccuracyScenes(bool large) {
  const Index points = large ? 1254 : 400;
  std::vector<AccuracyScene> scenes{makeSwing("swing_soft", 1e3, points),
                                    makeSwing("swing_stiff", 1e5, points),
                                    makeSwing("swing_rigid", 1e7, points / 4),
                                    makeDrape(points),
                                    makeFold(points),
                                    makeSag(points)};
  scenes.push_back(makeCantilever("cantilever", 0.0));
  scenes.push_back(makeCantilever("cantilever_swing", 0.2));
  scenes.push_back(makeClampedPlate());
  const Index body = large ? 5000 : 1200;
  scenes.push_back(makeSolidBar("solid_bar", Vec3(0.0, 0.0, -9.81), body));
  scenes.push_back(makeSolidBar("solid_stretch", Vec3(9.81, 0.0, 0.0), body));
  scenes.push_back(makeSolidIndentation(body));
  AccuracyScene poke = makePoke(points);
  if (!poke.cloud.positions.empty()) scenes.push_back(std::move(poke));
  return scenes;
}

SceneParams atLevel(const AccuracyScene& scene, Index num_points) {
  SceneParams params = scene.params;
  params.accuracy.estimate = false;  // the error is known here
  params.simplification.method =
      num_points >= scene.cloud.size() ? cloud::SimplificationMethod::kNone : cloud::SimplificationMethod::kDelaunay;
  params.simplification.target_points = num_points;
  return params;
}

}  // namespace deformable_surface::benchmark
