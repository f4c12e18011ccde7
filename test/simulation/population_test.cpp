#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/expectations.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kSpacing = 0.05;

// A hexagonal patch that is at rest.
cloud::PointCloud patch(Index rows = 14, Index columns = 14) {
  Points points;
  for (Index j = 0; j < rows; ++j)
    for (Index i = 0; i < columns; ++i) points.emplace_back(kSpacing * (i + 0.5 * (j % 2)), kSpacing * std::sqrt(0.75) * j, 0.0);
  return asCloud(points);
}

SceneParams scene() {
  SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.oriented_particles.spacing = kSpacing;
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * kSpacing * kSpacing;
  return p;
}

tool::ToolParams ball(tool::Mode mode, const Vec3& at, double radius) {
  tool::ToolParams tool;
  tool.id = "ball";
  tool.mode = mode;
  tool.shape.radius = radius;
  tool.path = {{0.0, at, Vec4(0.0, 0.0, 0.0, 1.0)}};
  return tool;
}

TEST(Population, SpacingAutoIsThatOfALatticeWhateverItsEdges) {
  // Of a long strip, where two rows of five are at the edge, as of a square.
  for (const Index rows : {5, 14}) {
    SceneParams p = scene();
    p.oriented_particles.spacing = {};
    const Simulation s(p, patch(rows, 196 / rows));
    EXPECT_NEAR(latticeOf(s).spacing, kSpacing, 1e-3 * kSpacing) << rows;
  }
}

TEST(Population, AnEraserTakesWhatIsInsideItAndTheRowsOfTheInputBecomeHoles) {
  SceneParams p = scene();
  p.tools = {ball(tool::Mode::kErase, Vec3(0.35, 0.3, 0.0), 0.08)};
  Simulation s(p, patch());
  std::vector<char> inside;
  for (const Vec3& x : s.input().positions) inside.push_back((x - Vec3(0.35, 0.3, 0.0)).norm() <= 0.08);
  const auto gone = std::count(inside.begin(), inside.end(), 1);
  ASSERT_GT(gone, 3);
  run(s, 1);
  EXPECT_EQ(s.state().size(), s.input().size() - gone);
  EXPECT_EQ(simulation::computeQuantity("removed", s), gone);
  EXPECT_EQ(simulation::computeQuantity("boundary_loops", s), 2.0);
  const simulation::Surface& surface = s.surface(true);
  ASSERT_EQ(surface.positions.size(), inside.size());
  for (std::size_t i = 0; i < inside.size(); ++i) {
    EXPECT_EQ(std::isnan(surface.positions[i].x()), inside[i] != 0);
    if (!inside[i]) {
      EXPECT_LT((surface.positions[i] - s.input().positions[i]).norm(), 0.2 * kSpacing);
    }
  }
  // They return only after a reset.
  s.removeTool("ball");
  run(s, 5);
  EXPECT_EQ(s.state().size(), s.input().size() - gone);
  s.removeTool("ball");
  s.reset();
  EXPECT_EQ(s.state().size(), s.input().size());
}

TEST(Population, WhenEveryParticleIsGoneTheRunGoesOn) {
  SceneParams p = scene();
  p.tools = {ball(tool::Mode::kErase, Vec3(0.35, 0.3, 0.0), 5.0)};
  Simulation s(p, patch());
  run(s, 3);
  EXPECT_EQ(s.state().size(), 0);
  EXPECT_TRUE(std::isnan(s.surface(true).positions[0].x()));
  EXPECT_EQ(s.statistics().simulation_points, 0u);
}

TEST(Population, ThereArePinsAndForcesOnTheSameParticlesAfterOthersAreGone) {
  SceneParams p = scene();
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.01, -1.0, -1.0);
  pin.region.max = Vec3(0.03, 2.0, 1.0);
  p.pins = {pin};
  p.material.damping = 5.0;
  simulation::ForceParams force;
  force.id = "pull";
  force.point = Vec3(0.65, 0.5, 0.0);
  force.force = Vec3(0.0, 0.0, 0.05);
  p.forces = {force};
  p.tools = {ball(tool::Mode::kErase, Vec3(0.3, 0.1, 0.0), 0.06)};
  p.tools[0].start = 0.05;
  Simulation s(p, patch());
  run(s, 5);
  const Vec3 attacked = s.activeForces().front().first;
  const auto pinned = std::count(s.pinned().begin(), s.pinned().end(), 1);
  run(s, 1);
  ASSERT_LT(s.state().size(), s.input().size());
  EXPECT_LT((s.activeForces().front().first - attacked).norm(), 0.1 * kSpacing);
  EXPECT_EQ(std::count(s.pinned().begin(), s.pinned().end(), 1), pinned);
  for (Index i = 0; i < s.state().size(); ++i)
    if (s.pinned()[i]) {
      EXPECT_LT(s.state().positions[i].x(), 0.031);
    }
}

TEST(Population, WhatLiesBelowTheFlatLatticesEnergyIsNotTakenForABlowUp) {
  // A saddle on a square grid. One particle is replaced by growth: at rest, with less energy than the flat lattice of as many
  // particles.
  cloud::PointCloud grid;
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) grid.positions.emplace_back(0.01f * i, 0.01f * j, (0.01f * i) * (0.01f * j));
  grid.width = 144;
  SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  Simulation s(p, grid);
  simulation::ParticleEdit edit;
  edit.action = simulation::ParticleAction::kDelete;
  edit.ids = {66};
  s.editParticles(edit);
  s.growSurface(p.oriented_particles.growth);
  run(s, 10);
  EXPECT_LT(s.statistics().elastic_energy, 0.0);
}

TEST(Population, TheSpacingThatAFitFindsGoesWithSnapshotsForksAndResets) {
  Simulation s(scene(), patch());
  simulation::ParticleEdit edit;  // the particles grown into the hole are not quite the original lattice
  edit.action = simulation::ParticleAction::kDelete;
  for (Index id = 90; id < 94; ++id) edit.ids.push_back(id);
  s.editParticles(edit);
  const simulation::Snapshot before = s.snapshot();
  const double stated = latticeOf(s).spacing;
  s.growSurface(s.params().oriented_particles.growth);
  const double fitted = latticeOf(s).spacing;
  ASSERT_NE(fitted, stated);
  const simulation::Snapshot after = s.snapshot();
  EXPECT_EQ(latticeOf(s.fork()).spacing, fitted);
  s.restore(before);
  EXPECT_EQ(latticeOf(s).spacing, stated);
  s.restore(after);
  EXPECT_EQ(latticeOf(s).spacing, fitted);
  s.reset();
  EXPECT_EQ(latticeOf(s).spacing, stated);
}

TEST(Population, HeatIsCarriedByToolsAndCoolsExponentially) {
  SceneParams p = scene();
  p.oriented_particles.cooling = 4.0;
  p.tools = {ball(tool::Mode::kHeat, Vec3(0.35, 0.3, 0.0), 0.08)};
  p.tools[0].strength = 300.0;
  p.tools[0].end = 0.05;
  Simulation s(p, patch());
  run(s, 5);
  double hottest = 0.0;
  for (const auto& particle : s.state().traits) hottest = std::max(hottest, particle.temperature);
  EXPECT_EQ(hottest, 300.0);
  run(s, 20);
  hottest = 0.0;
  for (const auto& particle : s.state().traits) hottest = std::max(hottest, particle.temperature);
  EXPECT_NEAR(hottest, 300.0 * std::exp(-4.0 * 0.2), 1e-9 * 300.0);
}

TEST(Population, OnlyWhatIsHotMovesWhereTheColdIsHeld) {
  SceneParams p = scene();
  p.oriented_particles.freeze_below = 50.0;
  p.gravity = Vec3(0.0, 0.0, -9.81);
  p.tools = {ball(tool::Mode::kHeat, Vec3(0.35, 0.3, 0.0), 0.12)};
  p.tools[0].strength = 100.0;
  Simulation s(p, patch());
  const Points rest = s.state().positions;
  run(s, 10);
  double hot = 0.0;
  for (Index i = 0; i < s.state().size(); ++i) {
    const double moved = (s.state().positions[i] - rest[i]).norm();
    if (s.state().traits[i].temperature < 50.0) {
      EXPECT_EQ(moved, 0.0);
    }
    hot = std::max(hot, moved);
  }
  EXPECT_GT(hot, 1e-4);
}

TEST(Population, StretchingGivesBirthToParticlesThatAreRowsOfTheirOwn) {
  SceneParams p = scene();
  p.oriented_particles.stretching = true;
  // Two halves, farther apart than bonds reach, and held. Particles are added between their edges.
  cloud::PointCloud cloud = patch();
  for (Vec3& x : cloud.positions)
    if (x.x() > 0.34) x.x() += 1.1 * kSpacing;
  simulation::PinParams all;
  all.region.kind = geometry::Region::Kind::kSphere;
  all.region.radius = 10.0;
  p.pins = {all};
  Simulation s(p, cloud);
  EXPECT_EQ(simulation::computeQuantity("components", s), 2.0);
  run(s, 10);
  const Index born = s.state().size() - s.input().size();
  EXPECT_GT(born, 5);
  EXPECT_EQ(simulation::computeQuantity("components", s), 1.0);
  const simulation::Surface& surface = s.surface(true);
  ASSERT_EQ(static_cast<Index>(surface.positions.size()), s.input().size() + born);
  EXPECT_EQ(static_cast<Index>(surface.source.size()), born);
  for (Index k = 0; k < born; ++k) {
    EXPECT_TRUE(surface.positions[s.input().size() + k].allFinite());
    EXPECT_TRUE(std::isnan(surface.displacement[s.input().size() + k]));
    EXPECT_GE(surface.source[k], 0);
  }
}

TEST(Population, OneAddedByHandTakesTheOtherFieldsOfTheNearestPoint) {
  Simulation s(scene(), patch());
  simulation::ParticleEdit edit;
  edit.positions = {s.input().positions[100] + Vec3(0.0, 0.0, 0.5 * kSpacing)};
  edit.orientations = {Quaternion::Identity()};
  s.editParticles(edit);
  EXPECT_EQ(s.surface(false).source, std::vector<Index>{100});
}

TEST(Population, NobodyIsBornInAnother) {
  // A melting knife in a sheet leaves particles with all orientations, and gaps between them.
  SceneParams p = scene();
  p.material.damping = 5.0;
  p.oriented_particles.stretching = true;
  p.material.bending_rigidity = 0.05;
  p.oriented_particles.cooling = 1.0;
  p.cloud.shape = simulation::CloudParams::Shape::kLattice;
  p.cloud.points = 240;
  p.cloud.size = Vec2(0.75, 0.7);
  tool::ToolParams knife = ball(tool::Mode::kCut, Vec3(0.0, 0.0, 0.45), 0.1);
  knife.shape.kind = geometry::Solid::Kind::kBox;
  knife.shape.size = Vec3(0.01, 2.0, 0.3);
  knife.strength = p.oriented_particles.melting;
  knife.path.push_back({1.3, Vec3(0.0, 0.0, 0.05), Vec4(0.0, 0.0, 0.0, 1.0)});
  p.tools = {knife};
  Simulation s(p, io::makeShape(p.cloud));
  double fastest = 0.0;
  for (int k = 0; k < 200; ++k) {
    run(s, 1);
    fastest = std::max(fastest, s.statistics().max_speed);
  }
  EXPECT_LT(fastest, 5.0);  // 1.8 m/s; 70 if a particle is added inside another
  EXPECT_GT(s.state().next_id, s.input().size());
}

// A ball fills a hole of one particle up to a third of a spacing above the sheet.
TEST(Population, NobodyIsBornInASolidTool) {
  SceneParams p = scene();
  p.oriented_particles.growing = model::Growing::kGaps;
  p.oriented_particles.growth.max_gap = 3.1;
  p.oriented_particles.growth_interval = 0.02;
  cloud::PointCloud cloud = patch();
  const Vec3 hole = cloud.positions[7 * 14 + 7];
  cloud.positions.erase(cloud.positions.begin() + 7 * 14 + 7);
  const double radius = 0.8 * kSpacing, above = 0.33 * kSpacing;
  p.tools = {ball(tool::Mode::kSolid, hole + Vec3(0.0, 0.0, above - radius), radius)};
  Simulation s(p, asCloud(cloud.positions));
  while (s.state().size() == s.input().size() && s.time() < 0.1) run(s, 1);
  ASSERT_EQ(s.state().size(), s.input().size() + 1);
  EXPECT_GT((s.state().positions.back() - p.tools[0].path[0].position).norm(), radius - 0.05 * kSpacing);
}

// A hole is filled unless another sheet that faces the opposite way is so near that the new particle would stand between the two.
TEST(Population, NobodyIsBornBetweenTwoSheets) {
  for (const double apart : {1.2 * kSpacing, 3.0 * kSpacing}) {
    SceneParams p = scene();
    p.oriented_particles.growing = model::Growing::kGaps;
    p.oriented_particles.growth.max_gap = 3.1;
    p.oriented_particles.freeze_below = 1.0;
    cloud::PointCloud cloud = patch();
    Points points = cloud.positions, normals(points.size(), Vec3::UnitZ());
    for (const Vec3& at : cloud.positions) {
      points.push_back(at + apart * Vec3::UnitZ());
      normals.push_back(-Vec3::UnitZ());
    }
    points.erase(points.begin() + 7 * 14 + 7);
    normals.erase(normals.begin() + 7 * 14 + 7);
    cloud = asCloud(points);
    cloud.normals = normals;
    Simulation s(p, cloud);
    run(s, 10);
    EXPECT_EQ(s.state().size(), s.input().size() + (apart > 2.0 * kSpacing ? 1 : 0));
  }
}

// Erasers around one particle leave it alone: the newborn in a filled hole goes, one of the beginning stays.
TEST(Population, ANewParticleThatIsAloneGoes) {
  for (const bool is_new : {true, false}) {
    SceneParams p = scene();
    p.oriented_particles.growing = model::Growing::kGaps;
    p.oriented_particles.growth.max_gap = 3.1;
    cloud::PointCloud cloud = patch();
    const Vec3 middle = cloud.positions[7 * 14 + 7];
    if (is_new) cloud.positions.erase(cloud.positions.begin() + 7 * 14 + 7);
    for (int k = 0; k < 6; ++k) {
      const double angle = k * kPi / 3.0;
      p.tools.push_back(
          ball(tool::Mode::kErase, middle + 3.2 * kSpacing * Vec3(std::cos(angle), std::sin(angle), 0.0), 2.6 * kSpacing));
      p.tools.back().id = "eraser " + std::to_string(k);
      p.tools.back().start = 0.1;
    }
    Simulation s(p, asCloud(cloud.positions));
    run(s, 9);
    ASSERT_EQ(s.state().size(), 14 * 14);
    run(s, 10);
    const auto isMiddle = [&](const Vec3& x) { return (x - middle).norm() < kSpacing; };
    EXPECT_EQ(std::count_if(s.state().positions.begin(), s.state().positions.end(), isMiddle), is_new ? 0 : 1);
    EXPECT_LT(s.state().size(), 14 * 14 - 20);
  }
}

// A hand lowers a stiff sheet onto another one that lies on a plate; both are too cold to move by themselves. They are joined
// once the hand has stopped, if it is near enough then. Else that is told.
TEST(Population, StiffSheetsAreJoinedWhenTheToolsHaveStopped) {
  const double from = 6.0 * kSpacing, lasts = 0.3;
  for (const double apart : {3.0 * kSpacing, 4.5 * kSpacing}) {
    SceneParams p = scene();
    const double stiff_length = kSpacing;  // sheets are joined from four of these on
    p.material.bending_rigidity = p.material.young_modulus * p.material.thickness * stiff_length * stiff_length;
    p.oriented_particles.rest_shape = model::RestShape::kFlat;
    p.oriented_particles.delete_trapped = p.oriented_particles.stretching = true;
    p.oriented_particles.freeze_below = 1.0;
    cloud::PointCloud cloud = patch();
    for (Vec3& at : cloud.positions) at.x() += 1000.0;  // where three digits are no place
    Points points = cloud.positions, normals(points.size(), Vec3::UnitZ());
    Vec3 middle = Vec3::Zero();
    for (const Vec3& at : cloud.positions) {
      points.push_back(at + from * Vec3::UnitZ());
      normals.push_back(-Vec3::UnitZ());
      middle += at / static_cast<double>(cloud.positions.size());
    }
    cloud = asCloud(points);
    cloud.normals = normals;
    tool::ToolParams plate = ball(tool::Mode::kSolid, middle - 0.05 * Vec3::UnitZ(), 0.0);
    plate.id = "plate";
    plate.shape.kind = geometry::Solid::Kind::kBox;
    plate.shape.size = Vec3(2.0, 2.0, 0.1);
    tool::ToolParams hand = ball(tool::Mode::kMove, middle + from * Vec3::UnitZ(), 0.0);
    hand.id = "hand";
    hand.shape.kind = geometry::Solid::Kind::kBox;
    hand.shape.size = Vec3(2.0, 2.0, kSpacing);
    hand.path.push_back({lasts, middle + apart * Vec3::UnitZ(), Vec4(0.0, 0.0, 0.0, 1.0)});
    p.tools = {plate, hand};
    Simulation s(p, cloud);
    std::string notices;
    while (s.time() < 1.5 * lasts) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      notices += outcome.notice;
      if (s.time() < lasts - 0.01) {
        EXPECT_EQ(s.state().size(), s.input().size()) << "joined on the way, at " << s.time() << " s";
      }
    }
    const bool is_near = apart < 4.0 * stiff_length;
    EXPECT_EQ(simulation::computeQuantity("components", s), is_near ? 1.0 : 2.0);
    EXPECT_EQ(notices.find("are joined at (1000.") != std::string::npos, is_near) << notices;
    EXPECT_EQ(notices.find("stop 0.225 m apart; sheets are joined from 0.2 m on") != std::string::npos, !is_near) << notices;
  }
}

TEST(Population, ASnapshotBringsBackWhoHasGone) {
  SceneParams p = scene();
  p.gravity = Vec3(0.0, 0.0, -1.0);
  p.tools = {ball(tool::Mode::kErase, Vec3(0.35, 0.3, 0.0), 0.08)};
  p.tools[0].start = 0.05;
  simulation::AnchorParams anchor;
  anchor.point = Vec3(0.65, 0.5, 0.0);
  anchor.target = Vec3(0.65, 0.5, 0.1);
  anchor.stiffness = 1.0;
  p.anchors = {anchor};
  Simulation s(p, patch());
  run(s, 3);
  const simulation::Snapshot before = s.snapshot();
  run(s, 7);
  const std::uint64_t end = s.stateHash();
  const simulation::Snapshot after = s.snapshot();
  run(s, 3);
  const std::uint64_t later = s.stateHash();
  s.restore(before);
  EXPECT_EQ(s.state().size(), s.input().size());
  run(s, 7);
  EXPECT_EQ(s.stateHash(), end);
  s.restore(after);
  run(s, 3);
  EXPECT_EQ(s.stateHash(), later);
}

// A sphere of particles that are too near for their spacing flies apart. New particles fill the gaps and fly off in turn.
TEST(Population, GrowthThatFeedsDebrisRestsAndSaysSoOnce) {
  SceneParams p;
  p.model = "oriented_particles";
  p.cloud.shape = simulation::CloudParams::Shape::kSphere;
  p.cloud.points = 500;
  p.cloud.radius = 0.5;
  p.cloud.jitter = 0.2;
  p.material.young_modulus = 1e5;
  p.material.damping = 10.0;
  p.material.bending_rigidity = 0.1;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.oriented_particles.rest_shape = model::RestShape::kFlat;
  p.oriented_particles.spacing = 0.14;  // 0.085 in the cloud
  p.oriented_particles.stretching = true;
  p.oriented_particles.growing = model::Growing::kGaps;
  p.oriented_particles.growth.min_gap = 1.6;
  p.gravity.setZero();
  Simulation s(p, io::makeShape(p.cloud));
  int told = 0;
  Index at_end = 0;
  for (int k = 0; k < 100; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    told += outcome.notice.find("growth is out of control and pauses: ") != std::string::npos;
    if (k == 49) at_end = s.state().size();
  }
  EXPECT_EQ(told, 1);
  EXPECT_LT(s.state().size(), 900);
  EXPECT_LT(s.state().size() - at_end, 50);
}

// Edges of a cut, which are curved and uneven, and the rim of a cap, which closes.
TEST(Population, EdgesThatGrowThrowNoParticles) {
  using Shape = simulation::CloudParams::Shape;
  for (const Shape shape : {Shape::kSphere, Shape::kCap}) {
    SceneParams p;
    p.model = "oriented_particles";
    p.cloud.shape = shape;
    p.cloud.points = shape == Shape::kSphere ? 400 : 300;
    p.cloud.radius = 0.4;
    p.cloud.angle = 1.2;
    p.material.young_modulus = 1e5;
    p.material.damping = 10.0;
    p.material.bending_rigidity = 0.05;
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.integrator.time_step = 0.002;
    p.oriented_particles.growing = model::Growing::kEdges;
    p.oriented_particles.growth.max_particles = 2000;
    p.gravity.setZero();
    if (shape == Shape::kSphere) {
      tool::ToolParams knife;
      knife.id = "knife";
      knife.mode = tool::Mode::kCut;
      knife.shape.kind = geometry::Solid::Kind::kBox;
      knife.shape.size = Vec3(0.004, 0.1, 2.0);
      knife.path = {{0.02, Vec3(-0.1, -0.7, 0.0)}, {0.2, Vec3(-0.1, 0.0, 0.0)}};
      knife.start = 0.02;
      knife.end = 0.2;
      p.tools = {knife};
      simulation::PinParams pin;
      pin.region.min = Vec3(-1.0, -1.0, -1.0);
      pin.region.max = Vec3(-0.3, 1.0, 1.0);
      p.pins = {pin};
    }
    Simulation s(p, io::makeShape(p.cloud));
    const Index before = s.state().size();
    double fastest = 0.0;
    for (int k = 0; k < 400; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      EXPECT_EQ(outcome.notice.find("out of control"), std::string::npos);
      for (const Vec3& v : s.state().velocities) fastest = std::max(fastest, v.norm());
    }
    EXPECT_EQ(simulation::computeQuantity("components", s), 1.0);
    EXPECT_EQ(simulation::computeQuantity("isolated", s), 0.0);
    EXPECT_LT(fastest, 4.0);
    if (shape == Shape::kCap) {
      EXPECT_GT(s.state().size(), 2 * before);
    }
  }
}

TEST(Population, OpenEdgesGrowUntilThereAreMaxParticlesAndANoteSaysSo) {
  for (const Index rows : {0, 2}) {
    SceneParams p;
    p.model = "oriented_particles";
    p.cloud.shape = simulation::CloudParams::Shape::kLattice;
    p.cloud.points = 60;
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.integrator.time_step = 0.002;
    p.oriented_particles.growing = model::Growing::kEdges;
    p.oriented_particles.growth.edge_rows = rows;
    p.oriented_particles.growth.max_particles = 300;
    p.gravity.setZero();
    Simulation s(p, io::makeShape(p.cloud));
    const std::vector<std::string>& notes = s.buildNotes();
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("open edges grow until there are oriented_particles.growth.max_particles, 300") != std::string::npos;
    }));
    for (int k = 0; k < 150; ++k) ASSERT_TRUE(s.step().ok);
    EXPECT_EQ(s.state().size(), 300);
  }
}

}  // namespace
}  // namespace deformable_surface::test
