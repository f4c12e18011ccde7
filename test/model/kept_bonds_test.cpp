// Bonds with a rest shape: moduli on uneven triangles, gradients, momenta, the stable step, and bonds that are gone.
#include "deformable_surface/solve/integrator.h"
#include "particle_states.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::WeightedTriangle;

MaterialParams thinSheet() {
  MaterialParams m;
  m.thickness = 0.1 * kSpacing;
  m.poisson_ratio = 0.2;
  return m;
}

/// A patch of uneven triangles; bend gives it a curvature, 1/m.
State unevenPatch(double bend = 0.0) {
  State s = hexagonalPatch(6, 7);
  std::mt19937 generator(4);
  for (Index i = 0; i < s.size(); ++i) {
    Vec3& p = s.positions[i];
    p += 0.2 * kSpacing * Vec3(uniform(generator), uniform(generator), 0.0);
    if (!(bend > 0.0)) continue;
    const double angle = bend * p.x();
    p.x() = std::sin(angle) / bend;
    p.z() = (std::cos(angle) - 1.0) / bend;
    s.orientations[i] = Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  }
  return s;
}

std::vector<WeightedTriangle> trianglesOfPatch() {
  std::vector<WeightedTriangle> all;
  for (Index i = 0; i < 5; ++i)
    for (Index j = 0; j < 6; ++j) {
      const Index a = 7 * i + j, b = a + 1, c = a + 7, d = c + 1;
      if (i % 2 == 0) {
        all.push_back({{a, b, c}, 1.0});
        all.push_back({{b, d, c}, 1.0});
      } else {
        all.push_back({{a, b, d}, 1.0});
        all.push_back({{a, d, c}, 1.0});
      }
    }
  return all;
}

double areaOf(const State& s) {
  double area = 0.0;
  for (const WeightedTriangle& t : trianglesOfPatch())
    area +=
        0.5 *
        (s.positions[t.corner[1]] - s.positions[t.corner[0]]).cross(s.positions[t.corner[2]] - s.positions[t.corner[0]]).norm();
  return area;
}

OrientedParticles makeKept(const State& rest, const MaterialParams& material = thinSheet()) {
  OrientedParticlesParams p;
  p.bonds = model::ParticleBonds::kKept;
  OrientedParticles particles = makeModel(rest.size(), p, material);
  particles.keepBonds(rest, trianglesOfPatch(), std::vector<double>(rest.size(), areaOf(rest) / rest.size()));
  return particles;
}

State shaken(State s, double amount) {
  std::mt19937 generator(11);
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] += amount * kSpacing * randomVector(generator);
    s.orientations[i] = turnBy(amount * randomVector(generator), s.orientations[i]);
  }
  return s;
}

TEST(KeptBonds, AConstantStrainHasThePlatesEnergyOnUnevenTriangles) {
  const State rest = unevenPatch();
  const OrientedParticles particles = makeKept(rest);
  const MaterialParams m = thinSheet();
  EXPECT_LT(std::abs(particles.elasticEnergy(rest)), 1e-20);
  const double nu = m.poisson_ratio, e = 1e-5;
  for (const Vec3& strain : {Vec3(e, 0.0, 0.0), Vec3(0.0, e, 0.0), Vec3(0.0, 0.0, e), Vec3(e, e, 0.0)}) {
    State s = rest;
    Mat3 by = Mat3::Identity();
    by(0, 0) += strain[0];
    by(1, 1) += strain[1];
    by(0, 1) = by(1, 0) = 0.5 * strain[2];
    for (Vec3& x : s.positions) x = by * x;
    const double density = 0.5 * m.young_modulus * m.thickness / (1.0 - nu * nu) *
                           (strain[0] * strain[0] + strain[1] * strain[1] + 2.0 * nu * strain[0] * strain[1] +
                            0.5 * (1.0 - nu) * strain[2] * strain[2]);
    EXPECT_NEAR(particles.elasticEnergy(s) / (areaOf(rest) * density), 1.0, 1e-4) << strain.transpose();
  }
}

TEST(KeptBonds, AConstantCurvatureHasThePlatesEnergyOnUnevenTriangles) {
  const State rest = unevenPatch();
  const OrientedParticles particles = makeKept(rest);
  const MaterialParams m = thinSheet();
  const double nu = m.bendingPoissonRatio(), k = 1e-5 / kSpacing;
  for (const Vec3& bend : {Vec3(k, 0.0, 0.0), Vec3(0.0, k, 0.0), Vec3(0.0, 0.0, k), Vec3(k, k, 0.0)}) {
    State s = rest;  // z = (xx x^2 + yy y^2 + xy x y) / 2
    for (Index i = 0; i < s.size(); ++i) {
      const Vec3 x = rest.positions[i];
      s.positions[i].z() = 0.5 * (bend[0] * x.x() * x.x() + bend[1] * x.y() * x.y() + bend[2] * x.x() * x.y());
      const Vec3 slope(bend[0] * x.x() + 0.5 * bend[2] * x.y(), bend[1] * x.y() + 0.5 * bend[2] * x.x(), 0.0);
      s.orientations[i] = turnBy(Vec3(slope.y(), -slope.x(), 0.0), Quaternion::Identity());
    }
    const double density =
        0.5 * m.bendingRigidity() *
        (bend[0] * bend[0] + bend[1] * bend[1] + 2.0 * nu * bend[0] * bend[1] + 0.5 * (1.0 - nu) * bend[2] * bend[2]);
    EXPECT_NEAR(particles.elasticEnergy(s) / (areaOf(rest) * density), 1.0, 1e-3) << bend.transpose();
  }
}

TEST(KeptBonds, ForcesAndTorquesAreMinusTheGradientAndKeepMomenta) {
  for (const double bend : {0.0, 2.0}) {
    State s = shaken(unevenPatch(bend), 0.15);
    const OrientedParticles particles = makeKept(unevenPatch(bend));
    for (Index i = 0; i < s.size(); i += 3) s.traits[i].temperature = 300.0;
    s.traits[8].is_smooth = false;
    s.positions[40] = s.positions[1] + Vec3(0.1, 0.2, 0.6) * kSpacing;  // without a bond, near
    Points forces, torques;
    evaluate(particles, s, forces, torques);
    const double h = 1e-4, force_scale = largest(forces), torque_scale = largest(torques);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (Index i = 0; i < s.size(); ++i) {
      sum += forces[i];
      moment += torques[i] + s.positions[i].cross(forces[i]);
      for (int axis = 0; axis < 6; ++axis) {
        const auto energyAt = [&](double amount) {
          State moved = s;
          if (axis < 3)
            moved.positions[i] += amount * kSpacing * Vec3::Unit(axis);
          else
            moved.orientations[i] = turnBy(amount * Vec3::Unit(axis - 3), moved.orientations[i]);
          return particles.elasticEnergy(moved);
        };
        const double slope = (8.0 * (energyAt(h) - energyAt(-h)) - (energyAt(2 * h) - energyAt(-2 * h))) / (12.0 * h);
        if (axis < 3)
          EXPECT_NEAR(forces[i][axis], -slope / kSpacing, 1e-7 * force_scale) << i << " " << axis;
        else
          EXPECT_NEAR(torques[i][axis - 3], -slope, 1e-6 * torque_scale) << i << " " << axis;
      }
    }
    EXPECT_LT(sum.norm(), 1e-12 * force_scale);
    EXPECT_LT(moment.norm(), 1e-12 * force_scale);
  }
}

TEST(KeptBonds, ACurvedShapeIsAtRestWhereverItIsMoved) {
  const State rest = unevenPatch(2.0);
  const OrientedParticles particles = makeKept(rest);
  State s = rest;
  const Quaternion turn(Eigen::AngleAxisd(1.1, Vec3(1.0, 2.0, -0.5).normalized()));
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] = turn * rest.positions[i] + Vec3(3.0, -1.0, 2.0);
    s.orientations[i] = turn * rest.orientations[i];
  }
  Points forces, torques;
  evaluate(particles, s, forces, torques);
  EXPECT_LT(largest(forces), 1e-10 * thinSheet().young_modulus * thinSheet().thickness * kSpacing);
}

TEST(KeptBonds, WithoutDampingEnergyAndMomentaStay) {
  State s = unevenPatch(2.0);
  OrientedParticles particles = makeKept(s);
  const double most = 0.02 / particles.findStableStep(s);
  std::mt19937 generator(5);
  for (Index i = 0; i < s.size(); i += 2) {
    s.velocities[i] = most * kSpacing * randomVector(generator);
    s.velocities[i + 1] = -s.velocities[i];
  }
  const auto measureAngularMomentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (Index i = 0; i < s.size(); ++i)
      sum += particles.masses()[i] * s.positions[i].cross(s.velocities[i]) + particles.inertias()[i] * s.spins[i];
    return sum;
  };
  const Vec3 turning = measureAngularMomentum();
  const std::vector<const solve::ExternalLoad*> no_loads;
  const std::vector<char> held(s.positions.size(), 0);
  const solve::System system(particles, no_loads, held, 0.0);
  const double step = 0.5 * particles.findStableStep(s), first = system.kineticEnergy(s);
  const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, {}, true);
  double lowest = first, highest = first;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(verlet->advance(system, 0.0, 20.0 * step, step, s).finite);
    const double now = particles.elasticEnergy(s) + system.kineticEnergy(s);
    lowest = std::min(lowest, now);
    highest = std::max(highest, now);
  }
  EXPECT_LT(highest - lowest, 0.02 * first);
  Vec3 momentum = Vec3::Zero();
  for (Index i = 0; i < s.size(); ++i) momentum += particles.masses()[i] * s.velocities[i];
  EXPECT_LT(momentum.norm(), 1e-10 * particles.masses()[0] * most * kSpacing);
  EXPECT_GT(turning.norm(), 0.0);
  EXPECT_LT((measureAngularMomentum() - turning).norm(), 1e-9 * turning.norm());
}

TEST(KeptBonds, ABondThatIsTooLongMeltedOrCutIsGone) {
  State s = unevenPatch();
  OrientedParticles particles = makeKept(s);
  EXPECT_TRUE(particles.findBroken(s).empty());
  s.traits[0].temperature = 2000.0;
  for (Index i = 35; i < 42; ++i) s.positions[i].y() += 2.0 * kSpacing;  // the last row
  const model::ParticleCuts::Pairs broken = particles.findBroken(s);
  EXPECT_EQ(broken.size(), 13 + 2);  // 13 between two rows of seven, two of the corner
  particles.setCuts(particles.cuts().sever(broken));
  particles.refreshDisplay(s);
  EXPECT_EQ(particles.triangles().size(), 60 - 12 - 1);
  s.traits[0].temperature = 0.0;
  for (Index i = 35; i < 42; ++i) s.positions[i].y() += 10.0 * kSpacing;
  EXPECT_LT(std::abs(particles.elasticEnergy(s)), 1e-20);  // nothing pulls, then or when it is cold again
}

TEST(KeptBonds, TheirMemoryCounts) {
  const State rest = unevenPatch();
  const OrientedParticles particles = makeKept(rest);
  EXPECT_GT(particles.elasticEnergy(rest), -1.0);  // which lists those that are present
  // Those of the rest shape and those that are present.
  EXPECT_GT(particles.bytes(), 2 * trianglesOfPatch().size() * sizeof(model::KeptBonds::Triangle));
}

}  // namespace
}  // namespace deformable_surface::test
