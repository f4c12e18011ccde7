// Tests that break simulators: stiffness and steps of every size, collapsed and scattered starts, impacts, far origins. Passing
// means finite values, no more energy than there was, and a message when the method changed.
#include "clouds.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/solve/integrator.h"
#include "deformable_surface/solve/stable_step.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using solve::IntegratorType;

double totalEnergy(const Simulation& s) {
  const auto st = s.statistics();
  return st.kinetic_energy + st.elastic_energy + st.potential_energy;
}

// Runs the scene and checks every step: finite, and no more energy than at the start, up to a hundredth of what gravity can add.
void checkSound(simulation::SceneParams p, int steps) {
  Simulation s(p, sheetCloud(15));
  const double start = totalEnergy(s), mass = p.material.arealDensity();
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    for (const Vec3& x : s.state().positions) ASSERT_TRUE(x.allFinite());
    ASSERT_LE(totalEnergy(s), start + 0.01 * mass * 9.81) << "step " << k;
  }
  for (const Vec3& x : s.surface(true).positions) ASSERT_TRUE(x.allFinite());
}

simulation::SceneParams scene() {
  simulation::SceneParams p = hangingSheet();
  p.material.damping = 0.0;
  p.simplification.target_points = 100;
  p.integrator.time_step = 1.0 / 60.0;
  return p;
}

TEST(Stress, StiffnessOverEightDecades) {
  for (double young_modulus : {1e4, 1e6, 1e8, 1e10, 1e12}) {
    SCOPED_TRACE(young_modulus);
    simulation::SceneParams p = scene();
    p.material.young_modulus = young_modulus;
    checkSound(p, 20);
  }
}

TEST(Stress, TimeStepsUpToASecond) {
  for (double step : {1.0 / 240.0, 1.0 / 60.0, 0.1, 1.0}) {
    for (IntegratorType type : {IntegratorType::kAuto, IntegratorType::kImplicit}) {
      SCOPED_TRACE(std::to_string(step) + " s, integrator " + std::to_string(static_cast<int>(type)));
      simulation::SceneParams p = scene();
      p.integrator.time_step = step;
      p.integrator.type = type;
      checkSound(p, 10);
    }
  }
}

TEST(Stress, ACrumplingSheetWithoutDampingKeepsItsEnergyForManySeconds) {
  for (double step : {1.0 / 60.0, 0.5}) {
    simulation::SceneParams p = scene();
    p.integrator.time_step = step;
    checkSound(p, static_cast<int>(12.0 / step));
  }
}

TEST(Stress, AKeptVolumeOfAnyStiffness) {
  for (double volume_stiffness : {1e3, 1e5, 1e7, 1e9}) {
    SCOPED_TRACE(volume_stiffness);
    simulation::SceneParams p;
    p.gravity.setZero();
    p.mass_spring.volume_stiffness = volume_stiffness;
    p.simplification.target_points = 200;
    p.forces.push_back({"push", Vec3(0.0, 0.0, 0.5), Vec3(0.0, 0.0, -1.0), 0.2, 0.0, 1e300});
    Simulation s(p, asCloud(makeSphere(400, 0.5).points));
    const double volume = s.model().sides()->enclosedVolume(s.state());
    for (int k = 0; k < 20; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      // One newton on a ball of one metre cannot add more than a few joules.
      ASSERT_LT(totalEnergy(s), 1.0) << "step " << k;
    }
    if (volume_stiffness >= 1e5) {
      EXPECT_NEAR(s.model().sides()->enclosedVolume(s.state()) / volume, 1.0, 1e-3);
    }
  }
}

TEST(Stress, EveryMembraneAndBending) {
  for (model::Membrane membrane : {model::Membrane::kSprings, model::Membrane::kTriangles})
    for (model::Bending bending : {model::Bending::kSprings, model::Bending::kCurvature, model::Bending::kNone}) {
      SCOPED_TRACE(static_cast<int>(membrane) * 10 + static_cast<int>(bending));
      simulation::SceneParams p = scene();
      p.mass_spring.membrane = membrane;
      p.mass_spring.bending = bending;
      checkSound(p, 60);
    }
}

TEST(Stress, ABlowOfAMillionNewtonsForOneStepLeavesTheStateFinite) {
  simulation::SceneParams p = scene();
  Simulation s(p, sheetCloud(15));
  s.setForce({"blow", Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 1e6), 0.0, 0.0, p.integrator.time_step});
  for (int k = 0; k < 20; ++k) {
    const auto before = s.stateHash();
    const simulation::StepOutcome outcome = s.step();
    for (const Vec3& x : s.state().positions) ASSERT_TRUE(x.allFinite());
    if (!outcome.ok) {
      EXPECT_EQ(s.stateHash(), before);
      EXPECT_FALSE(outcome.problem.empty());
      break;
    }
  }
}

TEST(Stress, AFarOriginChangesNothingButRounding) {
  const auto runAt = [](const Vec3& offset) {
    simulation::SceneParams p = scene();
    p.pins[0].region.min += offset;
    p.pins[0].region.max += offset;
    cloud::PointCloud cloud = sheetCloud(15);
    for (Vec3& x : cloud.positions) x += offset;
    Simulation s(p, cloud);
    run(s, 10);
    Points positions = s.surface(false).positions;
    for (Vec3& x : positions) x -= offset;
    return positions;
  };
  const Points here = runAt(Vec3::Zero());
  for (double distance : {1e2, 1e4}) {
    const Points there = runAt(Vec3(distance, -distance, 0.5 * distance));
    for (std::size_t i = 0; i < here.size(); ++i) ASSERT_LT((here[i] - there[i]).norm(), 1e-9 * distance) << distance;
  }
}

// A free net released from an impossible shape.
struct Start {
  const char* name;
  Points positions;
};

std::vector<Start> impossibleStarts(const Points& rest) {
  const std::size_t n = rest.size();
  std::mt19937 generator(4);
  Start point{"Point", Points(n, Vec3(0.5, 0.0, 0.0))}, near_point{"NearPoint", point.positions}, line{"Line", rest},
      folded{"Folded", rest}, random{"Random", Points(n)}, stretched{"Stretched", rest};
  for (std::size_t i = 0; i < n; ++i) {
    near_point.positions[i] += 1e-6 * randomVector(generator);
    line.positions[i] = Vec3(rest[i].x(), 0.0, 0.0);
    if (rest[i].x() > 0.5) folded.positions[i].x() = 1.0 - rest[i].x();
    random.positions[i] = 0.5 * randomVector(generator);
    stretched.positions[i] *= 10.0;
  }
  return {point, near_point, line, folded, random, stretched};
}

// Nothing holds it and nothing pushes it.
struct FreeNet {
  explicit FreeNet(double rigidity)
      : surface(makeSheet(11, 11, 1.0, 1.0, 0.2)),
        net(surface.points, surface.normals, surface.rings, surface.area, false, makeMaterial(rigidity), {}),
        held(surface.points.size(), 0),
        system(net, loads, held, 0.0) {}

  static model::MaterialParams makeMaterial(double rigidity) {
    model::MaterialParams material;
    material.bending_rigidity = rigidity;
    return material;
  }

  const Surface surface;
  const model::MassSpring net;
  const std::vector<const solve::ExternalLoad*> loads;
  const std::vector<char> held;
  const solve::System system;
};

TEST(Stress, ImpossibleStartsNeverGainEnergyWithTheImplicitMethod) {
  const FreeNet net(1e-3);
  const solve::System& system = net.system;
  for (const Start& start : impossibleStarts(net.surface.points)) {
    SCOPED_TRACE(start.name);
    model::State state{start.positions, Points(start.positions.size(), Vec3::Zero())};
    const auto implicit = solve::makeIntegrator(IntegratorType::kImplicit, {});
    double energy = system.potentialEnergy(0.0, state) + system.kineticEnergy(state);
    ASSERT_GT(energy, 0.0);
    for (int k = 0; k < 20; ++k) {
      const auto report = implicit->advance(system, k / 60.0, 1.0 / 60.0, 1.0, state);
      ASSERT_TRUE(report.finite);
      const double now = system.potentialEnergy(0.0, state) + system.kineticEnergy(state);
      ASSERT_LE(now, energy * (1.0 + 1e-6)) << "step " << k;
      energy = now;
    }
  }
}

TEST(Stress, ImpossibleStartsStayFiniteAndKeepMomentumWithVerlet) {
  const FreeNet net(0.0);
  const solve::System& system = net.system;
  for (const Start& start : impossibleStarts(net.surface.points)) {
    SCOPED_TRACE(start.name);
    model::State state{start.positions, Points(start.positions.size(), Vec3::Zero())};
    const double energy = system.potentialEnergy(0.0, state);
    const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {});
    solve::StableStep stable;
    for (int k = 0; k < 30; ++k) {
      // A quarter of the stable step, because the stiffness changes within the step when triangles unfold.
      const double limit = 0.25 * stable.estimate(0.0, state, system);
      ASSERT_TRUE(verlet->advance(system, k / 60.0, 1.0 / 60.0, limit, state).finite);
      ASSERT_LE(system.potentialEnergy(0.0, state) + system.kineticEnergy(state), 1.05 * energy) << "step " << k;
    }
    Vec3 momentum = Vec3::Zero();
    double sizes = 0.0;
    for (Index i = 0; i < state.size(); ++i) {
      momentum += system.masses()[i] * state.velocities[i];
      sizes += system.masses()[i] * state.velocities[i].norm();
    }
    EXPECT_LT(momentum.norm(), 1e-10 * sizes);
  }
}

}  // namespace
}  // namespace deformable_surface::test
