// The parameters on which the shared part of a rest surface depends. Every parameter is changed.
#include "deformable_surface/simulation/prepared_surface.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/model_kind.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

#include <sstream>

namespace deformable_surface::test {
namespace {

using simulation::RestSurface;
using simulation::SceneParams;

// Changes the n-th visited value to another accepted one.
class ChangeOne : public Fields {
 public:
  explicit ChangeOne(int n) : left_(n) {}
  bool hasChanged() const { return left_ < 0; }
  const std::string& name() const { return name_; }

 private:
  bool isNext(const About& about) {
    if (left_-- != 0) return false;
    name_ = about.name;
    return true;
  }
  static double change(double value, const Range& range) {
    for (const double other : {1.25 * value, 0.75 * value, value + 0.1, value - 0.1, 0.1})
      if (other != value && range.contains(other)) return other;
    return range.low;
  }

  void onNumber(const About& about, double& value) override {
    if (isNext(about)) value = change(value, about.range);
  }
  void onNumberOrAuto(const About& about, OrAuto<double>& value) override {
    if (isNext(about)) value = value.is_auto ? change(0.0, about.range) : change(value.value, about.range);
  }
  void onInteger(const About& about, Index& value) override {
    if (!isNext(about)) return;
    value = about.range.contains(value + 1) ? value + 1 : value - 1;
  }
  void onFlag(const About& about, bool& value) override {
    if (isNext(about)) value = !value;
  }
  void onFlagOrAuto(const About& about, OrAuto<bool>& value) override {
    if (isNext(about)) value = !value.valueOr(false);
  }
  void onText(const About& about, std::string& value) override {
    if (isNext(about)) value += "x";
  }
  void onVector(const About& about, double* value, int size) override {
    if (isNext(about)) value[size - 1] = change(value[size - 1], about.range);
  }
  void onRows(const About& about, Points& value) override {
    if (isNext(about)) value.push_back(Vec3::UnitX());
  }
  void onChoice(const About& about, int& chosen, const std::vector<std::string>& accepted, const Value&) override {
    if (isNext(about)) chosen = (chosen + 1) % static_cast<int>(accepted.size());
  }
  void onBounds(const About& about, std::vector<NamedBounds>& value, const std::vector<std::string>& known) override {
    if (isNext(about)) value.push_back({known.front(), 0.0, 1.0});
  }
  bool onBegin(const About&, bool present) override { return present; }
  void onEnd() override {}
  std::size_t onBeginList(const About&, std::size_t size) override { return size; }
  bool onBeginItem(std::size_t) override { return true; }
  void onEndList() override {}
  void onBroken(const std::string&, const std::string&) override {}

  int left_;
  std::string name_;
};

// All bits of a surface without a model, or the reason why there is none.
std::string describe(const std::function<RestSurface()>& make) {
  std::ostringstream out;
  out << std::hexfloat;
  const auto list = [&](const auto& values) {
    for (const auto& value : values) out << value << ' ';
    out << '\n';
  };
  const auto points = [&](const Points& values) {
    for (const Vec3& v : values) out << v.x() << ' ' << v.y() << ' ' << v.z() << ' ';
    out << '\n';
  };
  const auto lists = [&](const Lists& values) {
    list(values.offsets);
    list(values.items);
  };
  try {
    const RestSurface s = make();
    for (const Points* p : {&s.dense.positions, &s.dense.normals, &s.off_surface, &s.points, &s.normals}) points(*p);
    for (const Lists* l : {&s.dense_neighbors, &s.cells.neighbors, &s.rings.ring, &s.solid_neighbors}) lists(*l);
    for (const std::vector<Index>* v : {&s.dense.point_of_input, &s.order.removed, &s.dense_index, &s.cells.owner}) list(*v);
    for (const std::vector<double>* v : {&s.order.diameter, &s.rings.area, &s.detours}) list(*v);
    for (const std::vector<std::string>* v : {&s.warnings, &s.notes}) list(*v);
    for (const cloud::Triangle& t : s.rings.triangles)
      out << t.corner[0] << ' ' << t.corner[1] << ' ' << t.corner[2] << ' ' << t.weight << ' ';
    out << s.is_thick << s.closed << ' ' << s.area << ' ' << s.across.transpose() << ' ' << s.order.num_points;
    // The points that follow the simulation points, by their motion.
    Points moved = s.points, dense;
    for (Vec3& p : moved) p += Vec3(0.1 * p.y() * p.y(), p.x() * p.y(), 0.2 * p.x());
    if (!s.solid_transfer.isEmpty()) {
      s.solid_transfer.apply(moved, dense, nullptr);
      points(dense);
    } else if (!s.rings.area.empty()) {
      s.transfer.apply(moved, dense);
      points(dense);
    }
  } catch (const InputError& error) {
    out << error.what();
  }
  return out.str();
}

std::string print(const SceneParams& scene) { return toYaml(printParams(simulation::keepWhatPrepares(scene))); }

// A sheet and a few points beside it, with one of everything that a scene may contain.
SceneParams makeScene(const std::string& model) {
  SceneParams scene;
  scene.model = model;
  scene.cloud.shape = simulation::CloudParams::Shape::kSheet;
  scene.cloud.points = 120;
  scene.cloud.jitter = 0.2;
  scene.simplification.target_points = 60;
  scene.pins.emplace_back();
  scene.pins[0].region.min = Vec3(-0.6, -0.1, -0.1);
  scene.pins[0].region.max = Vec3(-0.3, 0.1, 0.1);
  scene.pins[0].path.resize(2);
  scene.creases.emplace_back().region = scene.pins[0].region;
  scene.regions.emplace_back().region = scene.pins[0].region;
  scene.anchors.push_back({Vec3(0.31, 0.2, 0.0), Vec3(0.31, 0.2, 0.1), 3.0});
  scene.forces.push_back({"pull", Vec3(0.27, -0.22, 0.0), Vec3(1.0, 0.0, 1.0), 0.0, 0.0, 1.0});
  scene.forces.push_back({"push", Vec3(0.1, 0.1, 0.0), Vec3(0.0, 0.0, 1.0), 0.2, 0.0, 1.0});
  scene.tools.resize(1);
  scene.tools[0].path.resize(1);
  scene.robot.links.resize(1);
  scene.expect.push_back({"min_z", 0.0, 1.0});
  return scene;
}

cloud::PointCloud makeCloud(const SceneParams& scene) {
  cloud::PointCloud cloud = io::makeShape(scene.cloud);
  for (int i = 0; i < 12; ++i) cloud.positions.emplace_back(3.0 + 0.05 * (i % 4), 0.05 * (i / 4), 0.001 * (i % 3));
  cloud.normals.clear();
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

// Returns the number of parameters on which the surface depends.
int changeEach(const SceneParams& scene, bool to_choose) {
  const cloud::PointCloud cloud = makeCloud(scene);
  const simulation::ModelKind& kind = simulation::findModel(scene.model);
  const auto prepareOf = [&](const SceneParams& of) {
    return describe([&] { return simulation::findModel(of.model).prepare(of, cloud, simulation::kCoarsestPoints, to_choose); });
  };
  const std::string base = prepareOf(scene), key = print(scene);
  EXPECT_EQ(base, describe([&] { return simulation::prepareSurface(scene, cloud, simulation::kCoarsestPoints, to_choose); }));
  EXPECT_TRUE(kind.traits().is_prepared);
  int depends = 0;
  for (int n = 0;; ++n) {
    SceneParams changed = scene;
    ChangeOne change(n);
    visit(static_cast<Fields&>(change), changed);
    if (!change.hasChanged()) break;
    EXPECT_NE(toYaml(printParams(changed)), toYaml(printParams(scene))) << change.name();
    const std::string made = prepareOf(changed);
    depends += made != base;
    // For these the kept part of the scene is sufficient.
    const std::string where = change.name() + ", the parameter number " + std::to_string(n);
    if (print(changed) == key)
      EXPECT_EQ(made, base) << where;
    else if (simulation::canShare(changed))
      EXPECT_EQ(made,
                describe([&] { return simulation::prepareSurface(changed, cloud, simulation::kCoarsestPoints, to_choose); }))
          << where;
  }
  return depends;
}

TEST(PreparedSurface, OfAMassSpringSurfaceDependsOnWhatIsKeptOfItsScene) {
  SceneParams scene = makeScene("mass_spring");
  EXPECT_GE(changeEach(scene, false), 5);
  scene.simplification.density = cloud::PointDensity::kAdaptive;
  scene.material.bending_rigidity = 0.0;
  EXPECT_GE(changeEach(scene, true), 5);
  scene.material.bending_rigidity = {};
  // With so many loads the number of points decides whether all of their points are kept.
  for (int i = 0; i < 12; ++i) scene.anchors.push_back({Vec3(0.4 - 0.075 * i, 0.35, 0.0), Vec3::Zero(), 1.0});
  scene.cloud.points = 200;
  scene.simplification.target_points = 150;
  EXPECT_GE(changeEach(scene, true), 5);
  scene.input.unconstrained_parts = simulation::UnconstrainedParts::kDrop;
  EXPECT_GE(changeEach(scene, false), 5);
}

TEST(PreparedSurface, OfParticlesDependsOnWhatIsKeptOfItsScene) {
  EXPECT_GE(changeEach(makeScene("oriented_particles"), false), 5);
}

TEST(PreparedSurface, OfABodyDependsOnWhatIsKeptOfItsScene) {
  SceneParams scene = makeScene("elastic_solid");
  scene.elastic_solid.dimension = model::SolidDimension::kPlanar;
  EXPECT_GE(changeEach(scene, false), 5);
  scene.elastic_solid.dimension = model::SolidDimension::kAuto;
  scene.cloud.shape = simulation::CloudParams::Shape::kSphere;
  scene.elastic_solid.fill = true;
  EXPECT_GE(changeEach(scene, false), 5);
}

TEST(PreparedSurface, IsSharedByScenesThatPutOtherLoadsOnIt) {
  SceneParams scene = makeScene("mass_spring"), other = scene;
  other.material.young_modulus *= 2.0;
  other.forces[0].force *= 3.0;
  other.gravity.setZero();
  other.tools.clear();
  other.duration = 1.0;
  other.cloud = {};
  EXPECT_EQ(print(scene), print(other));
  other.forces[0].point.x() += 0.1;
  EXPECT_NE(print(scene), print(other));
  EXPECT_TRUE(simulation::canShare(scene));
  // Tools and gravity decide there, and the meshes of tools are not in the printed scene.
  scene.input.unconstrained_parts = simulation::UnconstrainedParts::kDrop;
  EXPECT_FALSE(simulation::canShare(scene));
}

TEST(PreparedSurface, GivesTheRunThatASurfaceOfItsOwnGives) {
  for (const char* model : {"mass_spring", "oriented_particles", "elastic_solid"})
    for (const double target : {0.0, 0.02}) {
      SceneParams scene;
      scene.model = model;
      scene.cloud.shape = simulation::CloudParams::Shape::kSheet;
      scene.cloud.points = 300;
      scene.gravity = scene.model == "elastic_solid" ? Vec3(1.0, 0.0, 0.0) : scene.gravity;
      scene.pins.emplace_back();
      scene.pins[0].region.min = Vec3(-0.6, -0.6, -0.1);
      scene.pins[0].region.max = Vec3(-0.4, 0.6, 0.1);
      scene.duration = 0.03;
      scene.accuracy.remember = false;
      if (target > 0.0 && scene.model == "mass_spring")
        scene.accuracy.position_error = target;
      else
        scene.simplification.target_points = 100;
      const cloud::PointCloud cloud = io::makeShape(scene.cloud);
      SceneParams first = scene;
      first.material.young_modulus *= 3.0;
      first.duration = 1.0;
      RestSurface prepared =
          simulation::prepareSurface(first, cloud, simulation::findCoarsest(first), simulation::hasTarget(first.accuracy));
      simulation::Simulation own(scene, cloud), shared(scene, cloud, std::move(prepared));
      EXPECT_EQ(own.buildNotes(), shared.buildNotes());
      EXPECT_EQ(own.buildWarnings(), shared.buildWarnings());
      for (int k = 0; k < 3; ++k) {
        ASSERT_TRUE(own.step().ok);
        ASSERT_TRUE(shared.step().ok);
      }
      EXPECT_EQ(own.statistics().state_hash, shared.statistics().state_hash) << model;
      EXPECT_EQ(formatReal(own.statistics().error_estimate), formatReal(shared.statistics().error_estimate)) << model;
      EXPECT_EQ(own.surface(false).positions, shared.surface(false).positions) << model;
    }
}

}  // namespace
}  // namespace deformable_surface::test
