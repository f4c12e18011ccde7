// Thin sheets of oriented particles with kept bonds against closed forms, and what separates them.
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kLength = 0.3, kWidth = 0.1, kClamped = 0.03;  // m

/// A strip with one end clamped. Poisson's ratio is zero, so that the clamp does not hinder the strip from narrowing.
SceneParams clampedStrip(double thickness) {
  SceneParams p;
  p.model = "oriented_particles";
  p.oriented_particles.bonds = model::ParticleBonds::kKept;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.material.young_modulus = 1e6;
  p.material.thickness = thickness;
  p.material.poisson_ratio = 0.0;
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.max_iterations = 2000;
  p.integrator.tolerance = 1e-7;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(kClamped - 0.5 * kLength, 1.0, 1.0);
  pin.orientation = true;
  p.pins.push_back(pin);
  return p;
}

cloud::PointCloud makeStrip(Index points, double jitter) {
  simulation::CloudParams c;
  c.shape = simulation::CloudParams::Shape::kStrip;
  c.points = points;
  c.size = Vec2(kLength, kWidth);
  c.jitter = jitter;
  cloud::PointCloud cloud = io::makeShape(c);
  double least = 1e300;
  for (const Vec3& x : cloud.positions) least = std::min(least, x.x());
  for (Vec3& x : cloud.positions) x.x() += -0.5 * kLength - least;
  return cloud;
}

/// Mean over the outer 40 % of the strip of the displacement along an axis, over that of the closed form, displacement(x) at the
/// distance x from the clamp of a strip of that length.
template <class Displacement>
double compare(SceneParams p, Index points, double jitter, int axis, const Displacement& displacement) {
  Simulation s(p, makeStrip(points, jitter));
  const Points rest = s.state().positions;
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(s.step().ok);
  const Points& now = s.state().positions;
  double clamp = -1e300, end = -1e300, found = 0.0, expected = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    end = std::max(end, rest[i].x());
    if (now[i] == rest[i]) clamp = std::max(clamp, rest[i].x());
  }
  const double length = end - clamp;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const double x = rest[i].x() - clamp;
    if (x < 0.6 * length) continue;
    found += now[i][axis] - rest[i][axis];
    expected += displacement(x, length);
  }
  return found / expected;
}

TEST(ThinParticles, AStripHangsAsLongAsElasticityHasIt) {
  for (const double thickness : {0.0005, 0.001})
    for (const double jitter : {0.0, 0.2, 0.3}) {
      SceneParams p = clampedStrip(thickness);
      p.gravity = Vec3(20.0, 0.0, 0.0);
      const double by = p.material.density * p.gravity.x() / p.material.young_modulus;
      const double ratio = compare(p, 300, jitter, 0, [&](double x, double length) { return by * (length * x - 0.5 * x * x); });
      EXPECT_NEAR(ratio, 1.0, 0.04) << thickness << " " << jitter;
    }
}

// The clamp's place is known to half a spacing of seventeen, which is 6 % of the fourth power of the length on either side.
TEST(ThinParticles, ACantileverSagsAsABeam) {
  SceneParams p = clampedStrip(0.003);
  const double rigidity = p.material.bendingRigidity(), load = p.material.arealDensity();
  p.gravity = Vec3(0.0, 0.0, -0.16 * rigidity / (load * std::pow(kLength, 3)));
  const double ratio = compare(p, 300, 0.2, 2, [&](double x, double length) {
    return load * p.gravity.z() * x * x * (6.0 * length * length - 4.0 * length * x + x * x) / (24.0 * rigidity);
  });
  EXPECT_NEAR(ratio, 1.0, 0.08);
}

SceneParams fallingSheet(Index points) {
  SceneParams p;
  p.model = "oriented_particles";
  p.oriented_particles.bonds = model::ParticleBonds::kKept;
  p.cloud.shape = simulation::CloudParams::Shape::kLattice;
  p.cloud.points = points;
  p.cloud.size = Vec2(0.3, 0.3);
  p.cloud.jitter = 0.1;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.material.young_modulus = 1e5;
  p.material.thickness = 0.001;
  p.material.damping = 3.0;
  p.integrator.time_step = 0.01;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(-0.13, 1.0, 1.0);
  p.pins.push_back(pin);
  return p;
}

// A stiff sheet that swings down pulls at its clamp with 2.5 times its weight; an elastic one and the ends of a clamp with more.
TEST(ThinParticles, ASheetHangsWithoutAClumpAndTheBitsAreThoseOfOneThreadAndOfReplays) {
  std::uint64_t hashes[3];
  for (int k = 0; k < 3; ++k) {
    setNumThreads(k == 1 ? 2 : 1);
    SceneParams p = fallingSheet(500);
    const double most = 2.5 * p.material.density * p.gravity.norm() * kLength / p.material.young_modulus;
    Simulation s(p, io::makeShape(p.cloud));
    run(s, 20);
    const simulation::Snapshot saved = s.snapshot();
    run(s, 10);
    hashes[k] = s.stateHash();
    s.restore(saved);
    run(s, 10);
    EXPECT_EQ(s.stateHash(), hashes[k]);
    EXPECT_LT(s.statistics().max_stretch, 2.0 * most);
  }
  setNumThreads(0);
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

/// A sheet in free space, pulled apart by 0.2 m within half a second.
SceneParams tornSheet() {
  SceneParams p = fallingSheet(300);
  p.gravity.setZero();
  p.oriented_particles.tear_strain = 0.2;
  simulation::PinParams pull;
  pull.region.min = Vec3(0.13, -1.0, -1.0);
  pull.region.max = Vec3(1.0, 1.0, 1.0);
  pull.path.resize(2);
  pull.path[1].time = 0.5;
  pull.path[1].position.x() = 0.2;
  p.pins.push_back(pull);
  return p;
}

/// Sizes of the pieces of two or more particles that links hold together, the largest first.
std::vector<Index> countPieces(const Simulation& s) {
  std::vector<Index> piece(s.state().positions.size());
  std::iota(piece.begin(), piece.end(), 0);
  const auto find = [&](Index i) {
    while (piece[i] != i) i = piece[i];
    return i;
  };
  const auto& model = static_cast<const model::OrientedParticles&>(s.model());
  model.refreshDisplay(s.state());
  for (const auto& [i, j] : model.stretchLinks()) piece[find(i)] = find(j);
  std::map<Index, Index> sizes;
  for (Index i = 0; i < s.state().size(); ++i) ++sizes[find(i)];
  std::vector<Index> sorted;
  for (const auto& [root, size] : sizes)
    if (size > 1) sorted.push_back(size);
  std::sort(sorted.rbegin(), sorted.rend());
  return sorted;
}

TEST(ThinParticles, ASheetTornBetweenTwoHandsComesApartWithTheSameBitsForAllThreadsAndReplays) {
  std::uint64_t hashes[2];
  for (int k = 0; k < 2; ++k) {
    setNumThreads(k + 1);
    const SceneParams p = tornSheet();
    Simulation s(p, io::makeShape(p.cloud));
    EXPECT_EQ(countPieces(s), std::vector<Index>{s.state().size()});
    run(s, 25);
    const simulation::Snapshot saved = s.snapshot();
    run(s, 55);
    hashes[k] = s.stateHash();
    const std::vector<Index> pieces = countPieces(s);
    ASSERT_GE(pieces.size(), 2u);
    EXPECT_GT(pieces[1], s.state().size() / 10);  // either hand holds one
    s.restore(saved);
    run(s, 55);
    EXPECT_EQ(s.stateHash(), hashes[k]);
    s.reset();
    EXPECT_EQ(countPieces(s), std::vector<Index>{s.state().size()});
    run(s, 80);
    EXPECT_EQ(s.stateHash(), hashes[k]);
  }
  setNumThreads(0);
  EXPECT_EQ(hashes[0], hashes[1]);
}

std::size_t countLinks(const Simulation& s) {
  const auto& model = static_cast<const model::OrientedParticles&>(s.model());
  model.refreshDisplay(s.state());
  return model.stretchLinks().size();
}

TEST(ThinParticles, StatisticsCountTheBondsThatAreThere) {
  for (const char* change : {"torn", "cut", "erased"}) {
    SCOPED_TRACE(change);
    SceneParams p = fallingSheet(300);
    p.gravity.setZero();
    if (change == std::string("torn")) {
      p = tornSheet();
    } else {
      tool::ToolParams tool;
      tool.id = "tool";
      const bool erases = change == std::string("erased");
      tool.mode = erases ? tool::Mode::kErase : tool::Mode::kCut;
      tool.shape.kind = geometry::Solid::Kind::kBox;
      tool.shape.size = Vec3(erases ? 0.03 : 0.002, 0.2, 0.2);
      tool.path = {{0.0, Vec3(0.003, -0.3, 0.0), {0.0, 0.0, 0.0, 1.0}}, {0.3, Vec3(0.003, 0.3, 0.0), {0.0, 0.0, 0.0, 1.0}}};
      p.tools = {tool};
    }
    Simulation s(p, io::makeShape(p.cloud));
    const std::uint32_t links = s.statistics().links;
    EXPECT_GT(links, 2u * static_cast<std::uint32_t>(s.state().size()));
    const std::string note = simulation::buildRestSurface(p, io::makeShape(p.cloud)).notes.back();
    EXPECT_NE(note.find(" simulation points, " + std::to_string(links) + " links"), std::string::npos) << note;
    const simulation::Snapshot saved = s.snapshot();
    run(s, 50);
    const std::uint32_t left = s.statistics().links;
    EXPECT_LT(left, links);
    EXPECT_EQ(left, countLinks(s));
    s.restore(saved);
    EXPECT_EQ(s.statistics().links, links);
    s.reset();
    EXPECT_EQ(s.statistics().links, links);
  }
}

// Bonds as long as the particles are apart, and a ball of ten times of it.
TEST(ThinParticles, ABallThatGoesThroughTheHoleThatItToreIsNotTooNarrow) {
  SceneParams p = fallingSheet(600);
  p.gravity.setZero();
  p.cloud.size = Vec2(1.0, 0.7);
  p.cloud.jitter = 0.0;
  p.material.young_modulus = 1e4;
  p.material.thickness = 0.002;
  p.material.damping = 5.0;
  p.material.bending_rigidity = 0.02;
  p.oriented_particles.tear_strain = 0.2;
  p.pins[0].region.min = Vec3(-0.45, -0.3, -1.0);
  p.pins[0].region.max = Vec3(0.45, 0.3, 1.0);
  p.pins[0].region.outside = true;
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.2;
  const Vec4 still(0.0, 0.0, 0.0, 1.0);
  ball.path = {{0.4, Vec3(0.0, 0.0, -0.3), still}, {1.4, Vec3(0.0, 0.0, 0.45), still}};
  p.tools = {ball};
  Simulation s(p, io::makeShape(p.cloud));
  const std::uint32_t links = s.statistics().links;
  std::string told;
  for (int k = 0; k < 140; ++k) told += s.step().notice;
  EXPECT_LT(s.statistics().links, links);
  EXPECT_EQ(told.find("has passed through"), std::string::npos) << told;
}

// Half a period of its longest wave, about 0.03 s, after it was stretched the sheet is compressed.
TEST(ThinParticles, BondsBreakThatAreTooLongInTheMiddleOfAStep) {
  for (const double tear_strain : {0.2, 0.0}) {
    SceneParams p = fallingSheet(300);
    p.gravity.setZero();
    p.pins.clear();
    p.material.damping = 0.0;
    p.oriented_particles.tear_strain = tear_strain;
    p.integrator.time_step = 0.03;
    Simulation s(p, io::makeShape(p.cloud));
    const std::size_t links = countLinks(s);
    const double rate = tear_strain > 0.0 ? 50.0 : 150.0;  // 1/s
    model::State state = s.state();
    for (Index i = 0; i < state.size(); ++i) state.velocities[i].x() = rate * state.positions[i].x();
    s.setState(state);
    const simulation::Snapshot saved = s.snapshot();
    run(s, 1);
    EXPECT_LT(countLinks(s), links) << tear_strain;
    const std::uint64_t hash = s.stateHash();
    s.restore(saved);
    run(s, 1);
    EXPECT_EQ(s.stateHash(), hash) << tear_strain;
  }
}

// What the pins pulled on is gone at the end of the step. Their work counts, or the steps would seem to gain energy.
TEST(ThinParticles, PinsThatTearASheetHaveDoneTheirWork) {
  for (const double step : {0.002, 0.005, 0.01})
    for (const double torn_at : {0.03, 0.04, 0.06}) {
      SceneParams p = fallingSheet(400);
      p.gravity.setZero();
      p.material.damping = 0.0;
      p.oriented_particles.tear_strain = 0.3;
      p.integrator.time_step = step;
      simulation::PinParams held, carried;
      held.region.min = Vec3(-1.0, -1.0, -1.0);
      held.region.max = Vec3(-0.14, 1.0, 1.0);
      carried.region.min = Vec3(0.14, -1.0, -1.0);
      carried.region.max = Vec3(1.0, 1.0, 1.0);
      carried.path = {{0.02, Vec3::Zero()}, {torn_at, Vec3(0.15, 0.0, 0.02)}};
      p.pins = {held, carried};
      Simulation s(p, io::makeShape(p.cloud));
      const std::size_t links = countLinks(s);
      for (int k = 0; k < std::lround(0.08 / step); ++k) {
        const simulation::StepOutcome outcome = s.step();
        ASSERT_TRUE(outcome.ok) << step << " " << torn_at << " " << outcome.notice;
      }
      EXPECT_LT(countLinks(s), links);
    }
}

TEST(ThinParticles, AKnifeDividesASheetInTwoAlongItsWay) {
  for (const double jitter : {0.0, 0.2}) {
    SceneParams p = fallingSheet(400);
    p.cloud.jitter = jitter;
    p.gravity.setZero();
    p.pins.clear();
    tool::ToolParams knife;
    knife.id = "knife";
    knife.mode = tool::Mode::kCut;
    knife.shape.kind = geometry::Solid::Kind::kBox;
    knife.shape.size = Vec3(0.005, 0.02, 0.1);
    knife.path = {{0.0, Vec3(0.021, -0.25, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)},
                  {0.2, Vec3(0.021, 0.25, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
    p.tools = {knife};
    Simulation s(p, io::makeShape(p.cloud));
    const Points before = s.state().positions;
    run(s, 30);
    const std::vector<Index> pieces = countPieces(s);
    ASSERT_EQ(pieces.size(), 2u) << jitter;
    EXPECT_EQ(pieces[0] + pieces[1], s.state().size()) << jitter;
    for (const auto& [i, j] : s.model().links()->stretchLinks())
      EXPECT_GT((before[i].x() - 0.021) * (before[j].x() - 0.021), 0.0) << jitter << " " << i << " " << j;
    EXPECT_EQ(s.state().positions, before) << jitter;  // nothing pushes
  }
}

TEST(ThinParticles, ParticlesCanBeRemovedAndNotAdded) {
  SceneParams p = fallingSheet(300);
  p.gravity.setZero();
  p.pins.clear();
  Simulation s(p, io::makeShape(p.cloud));
  const Index before = s.state().size();
  const std::uint64_t hash = s.stateHash();
  simulation::ParticleEdit add;
  add.positions = {Vec3(0.0, 0.0, 0.1)};
  add.orientations = {Quaternion::Identity()};
  EXPECT_THROW(s.editParticles(add), InputError);
  EXPECT_THROW(s.growSurface(model::GrowthParams()), InputError);
  EXPECT_EQ(s.stateHash(), hash);
  simulation::ParticleEdit remove;
  remove.action = simulation::ParticleAction::kDelete;
  remove.ids = {s.state().traits[150].id};
  s.editParticles(remove);
  run(s, 20);
  EXPECT_EQ(countPieces(s), std::vector<Index>{before - 1});
  EXPECT_LT(s.statistics().max_stretch, 1e-9);  // the others stay at rest
}

TEST(ThinParticles, WithoutLoadsNothingMoves) {
  for (const bool is_round : {false, true})
    for (const double jitter : {0.0, 0.3, 0.5}) {
      SceneParams p = fallingSheet(500);
      p.gravity.setZero();
      p.pins.clear();
      p.cloud.jitter = jitter;
      if (is_round) p.cloud.shape = simulation::CloudParams::Shape::kSphere;
      Simulation s(p, io::makeShape(p.cloud));
      const Points before = s.state().positions;
      run(s, 20);
      double moved = 0.0;
      for (std::size_t i = 0; i < before.size(); ++i) moved = std::max(moved, (s.state().positions[i] - before[i]).norm());
      EXPECT_LT(moved, 1e-9 * latticeOf(s).spacing) << is_round << " " << jitter;
    }
}

}  // namespace
}  // namespace deformable_surface::test
