// Clouds that are no hexagonal lattice, as oriented particles: the given shape is at rest, and stays.
#include "clouds.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"
#include "deformable_surface/simulation/expectations.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

constexpr Index kSide = 20;

// Without damping and without weight, so that a remaining force is visible.
simulation::SceneParams unloaded(model::RestShape rest, double spacing) {
  simulation::SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.material.damping = 0.0;
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * spacing * spacing;
  p.oriented_particles.rest_shape = rest;
  return p;
}

cloud::PointCloud unevenSheet(double jitter) { return asCloud(makeSheet(kSide, kSide, 1.0, 1.0, jitter).points); }

// Points of a spiral, moved within the sphere of radius 1.
cloud::PointCloud unevenSphere(Index n) {
  std::mt19937 generator(5);
  Points points;
  for (Index i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n, angle = 2.399963229728653 * i, ring = std::sqrt(1.0 - z * z);
    Vec3 p(ring * std::cos(angle), ring * std::sin(angle), z);
    p += 0.05 * Vec3(uniform(generator), uniform(generator), uniform(generator));
    points.push_back(p.normalized());
  }
  return asCloud(points);
}

double farthestMove(simulation::Simulation& s) {
  const simulation::Surface& surface = s.surface(false);
  return *std::max_element(surface.displacement.begin(), surface.displacement.end());
}

TEST(SettleParticles, UnevenSheetsStayWhereTheyAre) {
  const double spacing = 1.0 / (kSide - 1);
  for (const double jitter : {0.1, 0.3}) {
    simulation::Simulation s(unloaded(model::RestShape::kAuto, spacing), unevenSheet(jitter));
    EXPECT_EQ(farthestMove(s), 0.0);
    run(s, 50);
    // The relaxation ends at 1e-4 of the first force. Without damping the rest of the motion does not decay.
    EXPECT_LT(farthestMove(s), 0.01 * spacing) << jitter;
    EXPECT_EQ(simulation::computeQuantity("components", s), 1.0);
    EXPECT_EQ(simulation::computeQuantity("boundary_loops", s), 1.0);
    EXPECT_EQ(simulation::computeQuantity("isolated", s), 0.0);
  }
}

// Clouds in which particles are so near that they would fly apart slide until they are even, also if a flat lattice is the rest
// shape.
TEST(SettleParticles, UnevenCloudsDoNotFlyApartWithAFlatRestShape) {
  const double spacing = 1.0 / (kSide - 1);
  simulation::Simulation s(unloaded(model::RestShape::kFlat, spacing), unevenSheet(0.3));
  EXPECT_EQ(farthestMove(s), 0.0);
  run(s, 50);
  EXPECT_LT(farthestMove(s), 0.5 * spacing);
  EXPECT_EQ(simulation::computeQuantity("components", s), 1.0);
  EXPECT_EQ(simulation::computeQuantity("boundary_loops", s), 1.0);
  EXPECT_EQ(simulation::computeQuantity("isolated", s), 0.0);
}

TEST(SettleParticles, UnevenSpheresKeepTheirRadius) {
  constexpr Index kPoints = 400;
  const double spacing = std::sqrt(8.0 * 3.141592653589793 / (std::sqrt(3.0) * kPoints));
  for (const model::RestShape rest : {model::RestShape::kAuto, model::RestShape::kFlat}) {
    simulation::Simulation s(unloaded(rest, spacing), unevenSphere(kPoints));
    run(s, 50);
    double sum = 0.0;
    for (const Vec3& p : s.surface(false).positions) sum += p.norm() / kPoints;
    // One that is flat at rest opens or pulls in, but stays a closed surface.
    EXPECT_NEAR(sum, 1.0, (rest == model::RestShape::kAuto ? 0.02 : 1.0) * spacing);
    EXPECT_EQ(simulation::computeQuantity("euler_characteristic", s), 2.0);
    EXPECT_EQ(simulation::computeQuantity("isolated", s), 0.0);
  }
}

TEST(SettleParticles, LatticesStayToTheBit) {
  Points lattice;
  for (Index j = 0; j < 10; ++j)
    for (Index i = 0; i < 10; ++i) lattice.emplace_back(0.05 * (i + 0.5 * (j % 2)), 0.05 * std::sqrt(0.75) * j, 0.0);
  simulation::SceneParams p = unloaded(model::RestShape::kAuto, 0.05);
  p.oriented_particles.spacing = 0.05;
  simulation::Simulation settled(p, asCloud(lattice));
  p.oriented_particles.rest_shape = model::RestShape::kFlat;
  simulation::Simulation flat(p, asCloud(lattice));
  EXPECT_EQ(settled.stateHash(), flat.stateHash());
  EXPECT_EQ(settled.state().positions, lattice);
}

TEST(SettleParticles, SheetsThatAreBentBackReturnToTheShapeOfTheirCloud) {
  // A half-pipe is opened by a force and released: it is as wide as before. Flat at rest it opens by itself.
  Points pipe;
  for (Index j = 0; j < 12; ++j)
    for (Index i = 0; i < 16; ++i) {
      const double angle = 0.2 * (i + 0.5 * (j % 2)) - 1.6;
      pipe.emplace_back(0.25 * std::sin(angle), 0.05 * std::sqrt(0.75) * j, 0.25 * std::cos(angle));
    }
  for (const bool rests : {true, false}) {
    simulation::SceneParams p = unloaded(rests ? model::RestShape::kCloud : model::RestShape::kFlat, 0.05);
    p.material.damping = 20.0;
    p.forces.push_back({"spread", pipe[15], Vec3(0.2, 0.0, 0.0), 0.06, 0.0, 0.2});
    simulation::Simulation s(p, asCloud(pipe));
    const auto findWidth = [&] { return (s.state().positions[15] - s.state().positions[0]).norm(); };
    const double width = findWidth();
    run(s, 20);
    const double spread = findWidth();
    run(s, 180);
    EXPECT_GT(spread, width + 0.01);
    if (rests) {
      EXPECT_NEAR(findWidth(), width, 0.1 * (spread - width));
    } else {
      EXPECT_GT(findWidth(), width + 0.05);
    }
  }
}

TEST(SettleParticles, WhatIsTooSoftToStayASurfaceOnlyBecomesEven) {
  simulation::SceneParams p = unloaded(model::RestShape::kAuto, 0.1);
  p.material.bending_rigidity = 1e-3 * p.material.young_modulus * p.material.thickness * 0.1 * 0.1;
  simulation::Simulation s(p, unevenSphere(400));
  for (const Vec3& x : s.state().positions) EXPECT_NEAR(x.norm(), 1.0, 0.2 * latticeOf(s).spacing);
  const auto says = [](const std::string& note) { return note.find("crumpled") != std::string::npos; };
  EXPECT_TRUE(std::any_of(s.buildNotes().begin(), s.buildNotes().end(), says));
}

TEST(SettleParticles, PinsOfSingleParticlesHoldWhileTheOthersSettle) {
  simulation::SceneParams p = unloaded(model::RestShape::kAuto, 0.05);
  const cloud::PointCloud cloud = unevenSheet(0.3);
  const std::vector<Index> singles{0, kSide * kSide / 2 + kSide / 2};
  for (const Index i : singles) {
    simulation::PinParams pin;
    pin.region.min = cloud.positions[i] - Vec3::Constant(1e-6);
    pin.region.max = cloud.positions[i] + Vec3::Constant(1e-6);
    p.pins.push_back(pin);
  }
  simulation::Simulation s(p, cloud);
  for (const Index i : singles) {
    EXPECT_TRUE(s.pinned()[i]);
    EXPECT_EQ(s.state().positions[i], cloud.positions[i]);
  }
}

// A strip of jittered particles, clamped over its first rows, under its weight.
simulation::SceneParams clampedStrip(Index points, double jitter, unsigned seed, double weight) {
  simulation::SceneParams p;
  p.model = "oriented_particles";
  p.cloud.shape = simulation::CloudParams::Shape::kLattice;
  p.cloud.points = points;
  p.cloud.size = Vec2(1.0, 0.4);
  p.cloud.jitter = jitter;
  p.cloud.seed = seed;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.material.young_modulus = 1e6;
  p.material.thickness = 0.01;
  p.material.bending_rigidity = 2.0;
  p.gravity = Vec3(0.0, 0.0, -weight);
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.max_iterations = 2000;
  p.integrator.tolerance = 1e-7;
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.6, -1.0, -1.0);
  pin.region.max = Vec3(-0.42, 1.0, 1.0);
  p.pins.push_back(pin);
  return p;
}

// The mean deflection of the end over the fourth power of the free length, 1/m^3, per weight of one.
double findBend(const simulation::SceneParams& p) {
  simulation::Simulation s(p, io::makeShape(p.cloud));
  const Points rest = s.state().positions;
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(outcome.ok && outcome.notice.empty()) << outcome.problem << outcome.notice;
  double clamp = -1.0, end = -1.0, sum = 0.0, count = 0.0;
  for (Index i = 0; i < s.state().size(); ++i) {
    if (s.pinned()[i]) clamp = std::max(clamp, rest[i].x());
    end = std::max(end, rest[i].x());
  }
  for (Index i = 0; i < s.state().size(); ++i)
    if (rest[i].x() > end - 0.05) {
      sum += rest[i].z() - s.state().positions[i].z();
      count += 1.0;
    }
  return sum / count / std::pow(end - clamp, 4) / -p.gravity.z();
}

// While pinned particles kept the uneven distances of the cloud, the stress beside them buckled such strips: they bent by four
// times as much, and as far under a hundredth of the weight.
TEST(SettleParticles, AClampedStripOfUnevenParticlesBendsAsALatticeDoes) {
  for (const Index points : {100, 400}) {
    const double lattice = findBend(clampedStrip(points, 0.0, 1, 0.05));
    for (const unsigned seed : {0u, 1u, 2u}) {
      // The edge of the clamp holds only part of a jittered row. Of the 13 columns of 100 points that counts by up to a third.
      const double bend = findBend(clampedStrip(points, 0.3, seed, 0.05));
      EXPECT_NEAR(bend, lattice, (points < 200 ? 0.33 : 0.05) * lattice) << points << " " << seed;
      EXPECT_NEAR(findBend(clampedStrip(points, 0.3, seed, 0.0005)), bend, 0.02 * bend) << points << " " << seed;
    }
  }
}

TEST(SettleParticles, PinnedNeighborsSettleWithTheOthersAndAreHeldThere) {
  simulation::SceneParams p = clampedStrip(100, 0.3, 1, 0.05);
  const cloud::PointCloud cloud = io::makeShape(p.cloud);
  simulation::Simulation s(p, cloud);
  const Points rest = s.state().positions;
  Index pinned = 0, moved = 0;
  for (Index i = 0; i < s.state().size(); ++i) {
    // Those that the region held where the cloud was.
    EXPECT_EQ(static_cast<bool>(s.pinned()[i]), cloud.positions[i].x() <= -0.42) << i;
    pinned += s.pinned()[i] != 0;
    moved += s.pinned()[i] && rest[i] != cloud.positions[i];
  }
  EXPECT_GT(pinned, 6);
  EXPECT_EQ(moved, pinned);
  s.step();
  for (Index i = 0; i < s.state().size(); ++i) {
    if (s.pinned()[i]) {
      EXPECT_EQ(s.state().positions[i], rest[i]);
    }
  }
}

// A clamp with a path carries those that were in its region where the cloud was, also where others are in it at rest, and the
// strip bends as far as from a fixed one.
TEST(SettleParticles, AClampThatMovesHoldsTheSameParticlesAndBendsTheStripAsAFixedOne) {
  constexpr int kSteps = 10;  // the clamp pushes the strip along its length: in one step it would buckle
  Index strayed = 0;
  for (const unsigned seed : {0u, 1u, 2u}) {
    simulation::SceneParams p = clampedStrip(100, 0.3, seed, 0.05);
    const cloud::PointCloud cloud = io::makeShape(p.cloud);
    simulation::Simulation fixed(p, cloud);
    const Vec3 motion(0.03, -0.01, 0.02);
    const Vec4 upright(0.0, 0.0, 0.0, 1.0);
    p.pins[0].path = {{0.0, Vec3::Zero(), upright}, {kSteps * p.integrator.time_step, motion, upright}};
    simulation::Simulation moving(p, cloud);
    const Points rest = moving.state().positions;
    EXPECT_EQ(fixed.state().positions, rest);
    EXPECT_EQ(fixed.pinned(), moving.pinned());
    fixed.step();
    for (int k = 0; k < kSteps; ++k) moving.step();
    Index pinned = 0;
    double farthest = 0.0, deflection = 0.0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const Vec3 moved_back = moving.state().positions[i] - motion;
      if (moving.pinned()[i]) {
        EXPECT_LT((moved_back - rest[i]).norm(), 1e-12) << i;
        ++pinned;
      }
      strayed += (moving.pinned()[i] != 0) != p.pins[0].region.contains(rest[i]);
      farthest = std::max(farthest, (moved_back - fixed.state().positions[i]).norm());
      deflection = std::max(deflection, (moved_back - rest[i]).norm());
    }
    EXPECT_GT(deflection, 0.01);
    EXPECT_LT(farthest, 0.01 * deflection) << seed;
    // All held particles count in the reaction of their pin.
    for (const simulation::Simulation* s : {&fixed, &moving}) {
      ASSERT_EQ(s->pinReactions().size(), 1u);
      EXPECT_EQ(s->pinReactions()[0].points, pinned);
    }
  }
  EXPECT_GT(strayed, 0);
}

TEST(SettleParticles, DoesNotDependOnTheNumberOfThreads) {
  const simulation::SceneParams p = unloaded(model::RestShape::kAuto, 0.05);
  setNumThreads(1);
  const cloud::PointCloud cloud = unevenSphere(300);  // two blocks
  const std::uint64_t one = simulation::Simulation(p, cloud).stateHash();
  for (const int threads : {2, 3}) {
    setNumThreads(threads);
    EXPECT_EQ(simulation::Simulation(p, cloud).stateHash(), one);
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::test
