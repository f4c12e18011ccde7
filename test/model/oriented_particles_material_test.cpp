// What the potentials add up to: the flat lattice at rest, its moduli, curved shapes, and motion by the oriented integrators.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/solve/integrator.h"
#include "deformable_surface/solve/time_march.h"
#include "particle_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace deformable_surface::test {
namespace {

using solve::IntegratorParams;
using solve::IntegratorType;

/// Energy per particle of an endless sheet, J: of patches of four sizes, so that edges and corners cancel. place takes a
/// particle of the flat lattice to where it is, with its normal.
double energyPerParticle(const OrientedParticlesParams& params, const MaterialParams& material,
                         const std::function<void(Vec3&, Quaternion&)>& place) {
  double sum = 0.0;
  for (int longer = 0; longer < 2; ++longer)
    for (int wider = 0; wider < 2; ++wider) {
      const Index rows = 9 + longer, columns = 9 + wider;
      State s = emptyState(rows * columns);
      for (Index i = 0; i < rows; ++i)
        for (Index j = 0; j < columns; ++j) {
          Vec3& p = s.positions[i * columns + j];
          p = kSpacing * Vec3(j + 0.5 * i, 0.5 * std::sqrt(3.0) * i, 0.0);
          place(p, s.orientations[i * columns + j]);
        }
      sum += (longer == wider ? 1.0 : -1.0) * makeModel(s.size(), params, material).elasticEnergy(s);
    }
  return sum;
}

/// Second difference of the energy per area of the endless sheet by a small number that place takes.
double findModulus(const OrientedParticlesParams& params, const MaterialParams& material, double h,
                   const std::function<void(double, Vec3&, Quaternion&)>& place) {
  const auto energy = [&](double amount) {
    return energyPerParticle(params, material, [&](Vec3& p, Quaternion& q) { place(amount, p, q); });
  };
  return (energy(h) - 2.0 * energy(0.0) + energy(-h)) / (h * h) / (0.5 * std::sqrt(3.0) * kSpacing * kSpacing);
}

/// On a cylinder of the curvature (1/m) about the y axis turned by angle about z, arc lengths kept.
void rollUp(double curvature, double angle, Vec3& p, Quaternion& q) {
  const Quaternion turn(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  const Vec3 flat = turn.conjugate() * p;
  const double a = curvature * flat.x();
  const double x = a == 0.0 ? flat.x() : std::sin(a) / curvature, z = a == 0.0 ? 0.0 : (std::cos(a) - 1.0) / curvature;
  p = turn * Vec3(x, flat.y(), z);
  q = turn * Quaternion(Eigen::AngleAxisd(a, Vec3::UnitY())) * turn.conjugate();
}

std::vector<OrientedParticlesParams> kinds() {
  std::vector<OrientedParticlesParams> all(5);
  all[1].weighting = ParticleWeighting::kAnisotropic;
  all[2].exponents = Vec2(8.0, 4.0);
  all[3].cutoff = 3.0;
  all[4].cutoff = 2.5;
  all[4].exponents = Vec2(6.0, 3.0);
  all[4].weighting = ParticleWeighting::kAnisotropic;
  return all;
}

TEST(OrientedParticlesMaterial, AFlatEndlessSheetIsAtRestAtTheSpacing) {
  for (const OrientedParticlesParams& p : kinds()) {
    const auto energyAt = [&](double scale) {
      return energyPerParticle(p, thickSheet(), [&](Vec3& x, Quaternion&) { x *= scale; });
    };
    const double depth = makeModel(1, p).lattice().pair.depth, strained = energyAt(1.001);
    EXPECT_NEAR(energyAt(1.0), 0.0, 1e-11 * depth);  // rounding of some hundred bonds
    EXPECT_GT(strained, 0.0);
    // The slope at the spacing is zero: what is left is the third derivative, of the order of the strain.
    EXPECT_NEAR(energyAt(0.999), strained, 0.1 * strained);
  }
}

TEST(OrientedParticlesMaterial, TheSpacingOfTheLatticeIsThatOfItsSums) {
  // Spacing over r0 with first neighbours alone, and with those within three r0, whose switch weakens the outer ones a little.
  OrientedParticlesParams p;
  EXPECT_NEAR(kSpacing / makeModel(1, p).lattice().pair.distance, 1.0, 1e-9);
  p.cutoff = 3.0;
  EXPECT_NEAR(kSpacing / makeModel(1, p).lattice().pair.distance, 0.990626, 1e-3);
}

TEST(OrientedParticlesMaterial, ItHasTheYoungsModulusOfTheMaterialAndPoissonsRatioOfAThirdInAllDirections) {
  for (const OrientedParticlesParams& p : kinds()) {
    const double stiffness = thickSheet().young_modulus * thickSheet().thickness, nu = 1.0 / 3.0, h = 1e-4;
    const auto stretch = [&](double x, double y, double angle) {
      const Eigen::AngleAxisd turn(angle, Vec3::UnitZ());
      return findModulus(p, thickSheet(), h, [&](double amount, Vec3& position, Quaternion&) {
        position = turn * ((turn.inverse() * position).cwiseProduct(Vec3(1.0 + amount * x, 1.0 + amount * y, 1.0)));
      });
    };
    const double tolerance = 1e-4 * stiffness;  // fourth derivatives times h^2
    EXPECT_NEAR(stretch(1.0, 1.0, 0.0), 2.0 * stiffness / (1.0 - nu), tolerance);
    for (double angle : {0.0, 0.2, 0.5}) {
      EXPECT_NEAR(stretch(1.0, 0.0, angle), stiffness / (1.0 - nu * nu), tolerance) << angle;
      EXPECT_NEAR(stretch(1.0, -1.0, angle), 2.0 * stiffness / (1.0 + nu), tolerance) << angle;
    }
  }
}

TEST(OrientedParticlesMaterial, ItHasTheBendingRigidityOfTheMaterialInAllDirections) {
  for (OrientedParticlesParams p : kinds())
    for (double planarity : {0.0, 1.0, 2.0}) {
      p.co_planarity = planarity;
      p.co_normality = 2.0 - planarity;
      for (double angle : {0.0, 0.2, 0.5}) {
        const double rigidity = findModulus(p, thickSheet(), 0.01 / kSpacing, [&](double curvature, Vec3& x, Quaternion& q) {
          rollUp(curvature, angle, x, q);
        });
        // The next order in curvature times spacing, that of the arcs which are longer than their chords included.
        EXPECT_NEAR(rigidity, thickSheet().bendingRigidity(), 1e-3 * thickSheet().bendingRigidity()) << planarity << " " << angle;
      }
    }
}

TEST(OrientedParticlesMaterial, ARowInThePlaneHasTheModuliOfAStrip) {
  OrientedParticlesParams p;
  p.mode = ParticleMode::kPlane;
  const auto energyOf = [&](double strain, double curvature) {
    double difference = 0.0;
    for (Index n : {12, 13}) {
      State s = emptyState(n);
      for (Index i = 0; i < n; ++i) {
        s.positions[i].x() = (1.0 + strain) * kSpacing * i;
        if (curvature != 0.0) rollUp(curvature, 0.0, s.positions[i], s.orientations[i]);
      }
      difference += (n == 12 ? -1.0 : 1.0) * makeModel(n, p).elasticEnergy(s);
    }
    return difference / (kSpacing * kSpacing);  // a particle stands for a square
  };
  const double h = 1e-4, c = 0.01 / kSpacing, stiffness = thickSheet().young_modulus * thickSheet().thickness;
  EXPECT_NEAR((energyOf(h, 0.0) + energyOf(-h, 0.0) - 2.0 * energyOf(0.0, 0.0)) / (h * h), stiffness, 1e-4 * stiffness);
  EXPECT_NEAR(2.0 * (energyOf(0.0, c) - energyOf(0.0, 0.0)) / (c * c), thickSheet().bendingRigidity(),
              1e-3 * thickSheet().bendingRigidity());
}

struct World {
  explicit World(OrientedParticles& model, double damping = 0.0)
      : held(model.masses().size(), 0), system(model, loads, held, damping) {}
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held;
  solve::System system;
};

void relax(OrientedParticles& model, State& state) {
  IntegratorParams params;
  params.tolerance = 1e-9;
  World world(model);
  const auto fire = solve::makeIntegrator(IntegratorType::kStatic, params, true);
  const solve::SolveReport report = fire->advance(world.system, 0.0, 1.0, model.findStableStep(state), state);
  EXPECT_TRUE(report.converged) << report.residual;
}

TEST(OrientedParticlesMaterial, APatchThatWasSqueezedAndShakenFindsItsSpacing) {
  State s = hexagonalPatch(6, 7, 0.97 * kSpacing);
  OrientedParticles particles = makeModel(s.size(), {});
  s.positions = perturb(s.positions, 0.03 * kSpacing);
  relax(particles, s);
  // All first neighbours alone: nothing pulls an edge together.
  EXPECT_LT(particles.maxStretch(s), 1e-6);
  particles.refreshDisplay(s);
  EXPECT_EQ(particles.stretchLinks().size(), 6 * 6 + 5 * 13);
}

TEST(OrientedParticlesMaterial, TheCoNormalityEnergyOfASphereDoesNotDependOnItsRadius) {
  // 4 pi D, that is 16 sqrt(3) pi alpha_N psi_1 of a hexagonal lattice. Points spread by the golden angle are no lattice: what
  // the first neighbours alone see of their density differs from it, but by the same on every sphere; of some shells the mean
  // is near.
  OrientedParticlesParams p;
  p.lennard_jones = p.co_planarity = 0.0;
  p.co_normality = 2.0;
  const auto energyOf = [&](Index n) {
    const Surface sphere = makeSphere(n, 1.0);
    OrientedParticles particles(sphere.points, sphere.normals, OrientedParticles::findSpacing(4.0 * M_PI, n), thickSheet(), p);
    State s{sphere.points, Points(n, Vec3::Zero())};
    particles.beginAtRest(s);
    return particles.elasticEnergy(s) / (4.0 * M_PI * thickSheet().bendingRigidity());
  };
  const double few = energyOf(500), many = energyOf(4000);
  EXPECT_NEAR(few, 1.0, 0.1);
  EXPECT_NEAR(few, many, 0.01);
  p.cutoff = 4.0;
  EXPECT_NEAR(energyOf(4000), 1.0, 0.01);
}

TEST(OrientedParticlesMaterial, WithoutDampingEnergyStaysAndMomentaAreKept) {
  State s = hexagonalPatch(4, 4);
  OrientedParticles particles = makeModel(s.size(), allTerms());
  const double at_rest = particles.elasticEnergy(s), most = 0.02 / particles.findStableStep(s);
  std::mt19937 generator(5);
  for (Index i = 0; i < s.size(); i += 2) {
    const Vec3 speed = most * kSpacing * randomVector(generator);
    s.velocities[i] = speed;
    s.velocities[i + 1] = -speed;  // so that the patch stays near the origin, of which angular momentum is taken
    s.spins[i] = most * randomVector(generator);
  }
  World world(particles);
  const auto energyOf = [&] { return particles.elasticEnergy(s) + world.system.kineticEnergy(s); };
  const auto momenta = [&](Vec3& linear, Vec3& angular) {
    linear.setZero();
    angular.setZero();
    for (Index i = 0; i < s.size(); ++i) {
      const Vec3 momentum = particles.masses()[i] * s.velocities[i];
      linear += momentum;
      angular += s.positions[i].cross(momentum) + particles.inertias()[i] * s.spins[i];
    }
  };
  Vec3 linear, angular;
  momenta(linear, angular);
  const double step = 0.5 * particles.findStableStep(s), first = energyOf(), excess = first - at_rest;
  const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {}, true);
  double lowest = first, highest = first;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(verlet->advance(world.system, 0.0, 100.0 * 0.5 * step, step, s).finite);
    const double now = energyOf();
    lowest = std::min(lowest, now);
    highest = std::max(highest, now);
  }
  // The error of the second-order method stays that of the first oscillations: bounded, however many there are.
  EXPECT_LT(highest - lowest, 0.01 * excess);
  EXPECT_LT(largest(s.positions), 10.0 * kSpacing);  // it held together
  Vec3 linear_after, angular_after;
  momenta(linear_after, angular_after);
  // Rounding of a hundred thousand sub-steps.
  const double size = particles.masses()[0] * most * kSpacing;
  EXPECT_LT((linear_after - linear).norm(), 1e-11 * size);
  EXPECT_LT((angular_after - angular).norm(), 1e-11 * size * kSpacing);
}

TEST(OrientedParticlesMaterial, TimeRunsBackwardsAsWell) {
  State s = hexagonalPatch(4, 5);
  s.positions = perturb(s.positions, 0.02 * kSpacing);
  std::mt19937 generator(8);
  for (Quaternion& q : s.orientations) q = turnBy(0.1 * randomVector(generator), q);
  OrientedParticles particles = makeModel(s.size(), allTerms());
  World world(particles);
  const State start = s;
  const double step = 0.5 * particles.findStableStep(s);
  const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {}, true);
  for (int way = 0; way < 2; ++way) {
    verlet->advance(world.system, 0.0, 100.0 * 0.5 * step, step, s);
    if (way == 0) {
      EXPECT_GT((s.positions[0] - start.positions[0]).norm(), 1e-3 * kSpacing);
    }
    for (Index i = 0; i < s.size(); ++i) {
      s.velocities[i] = -s.velocities[i];
      s.spins[i] = -s.spins[i];
    }
  }
  // Rounding of two hundred sub-steps, which vibration in so many ways multiplies.
  for (Index i = 0; i < s.size(); ++i) {
    EXPECT_LT((s.positions[i] - start.positions[i]).norm(), 1e-11 * kSpacing);
    EXPECT_LT(s.orientations[i].angularDistance(start.orientations[i]), 1e-7);  // an arc cosine's rounding
    EXPECT_LT((s.orientations[i].coeffs() - start.orientations[i].coeffs()).norm(), 1e-11);
  }
}

/// A sheet with waves, for the tests of what must not change the bits.
State wavyPatch() {
  State s = hexagonalPatch(40, 40);
  std::mt19937 generator(6);
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] += 0.1 * kSpacing * randomVector(generator);
    s.positions[i].z() += 0.5 * kSpacing * std::sin(2.0 * s.positions[i].x() / kSpacing);
    s.orientations[i] = turnBy(0.3 * randomVector(generator), s.orientations[i]);
    s.traits[i].temperature = 100.0 * (i % 5);
    s.traits[i].is_smooth = i % 7 != 0;
  }
  return s;
}

bool areSame(const Points& a, const Points& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const Vec3& x, const Vec3& y) { return x == y; });
}

TEST(OrientedParticlesMaterial, TheBitsDoNotDependOnThreadsNorOnWhenListsWereMade) {
  for (ParticleWeighting weighting : {ParticleWeighting::kIsotropic, ParticleWeighting::kAnisotropic}) {
    const State s = wavyPatch();
    Points forces, torques, first_forces, first_torques;
    double energy = 0.0, step = 0.0;
    evaluate(makeModel(s.size(), allTerms(weighting)), s, first_forces, first_torques);
    for (int threads : {1, 2, 3}) {
      setNumThreads(threads);
      const OrientedParticles particles = makeModel(s.size(), allTerms(weighting));
      // Lists made at another state, of which these are not yet half a skin away.
      State before = s;
      before.positions = perturb(s.positions, 0.05 * kSpacing, threads);
      evaluate(particles, before, forces, torques);
      EXPECT_FALSE(areSame(forces, first_forces));
      evaluate(particles, s, forces, torques);
      EXPECT_TRUE(areSame(forces, first_forces)) << threads;
      EXPECT_TRUE(areSame(torques, first_torques)) << threads;
      if (energy == 0.0) {
        energy = particles.elasticEnergy(s);
        step = particles.findStableStep(s);
      }
      EXPECT_EQ(particles.elasticEnergy(s), energy) << threads;
      EXPECT_EQ(particles.findStableStep(s), step) << threads;
    }
  }
  setNumThreads(0);
}

TEST(OrientedParticlesMaterial, NoStateGivesForcesThatAreNotFinite) {
  const double far = 1e12;
  for (ParticleWeighting weighting : {ParticleWeighting::kIsotropic, ParticleWeighting::kAnisotropic}) {
    for (int kind = 0; kind < 4; ++kind) {
      State s = randomState(20, 1);
      std::mt19937 generator(kind);
      for (Index i = 0; i < s.size(); ++i) {
        if (kind == 0) s.positions[i].setConstant(0.3);                              // all in one place
        if (kind == 1) s.positions[i] = s.positions[i / 2];                          // each twice
        if (kind == 2) s.positions[i] = 1e-9 * kSpacing * randomVector(generator);   // next to one place
        if (kind == 3) s.positions[i] = (i % 3 ? 1.0 : far) * randomVector(generator);
      }
      const OrientedParticles particles = makeModel(20, allTerms(weighting));
      Points forces, torques;
      evaluate(particles, s, forces, torques);
      EXPECT_TRUE(std::isfinite(largest(forces)) && std::isfinite(largest(torques))) << kind;
      EXPECT_TRUE(std::isfinite(particles.elasticEnergy(s))) << kind;
      EXPECT_GT(particles.findStableStep(s), 0.0) << kind;
    }
  }
}

TEST(OrientedParticlesMaterial, StepsFromBrokenStatesEndFiniteOrAreRefusedWithTheStateAsItWas) {
  IntegratorParams params;
  params.type = IntegratorType::kVerlet;
  params.time_step = 1e-3;
  for (int kind = 0; kind < 4; ++kind) {
    State s = randomState(20, 1);
    for (Index i = 0; i < s.size(); ++i) {
      if (kind == 0) s.positions[i].setConstant(0.3);
      if (kind == 1) s.positions[i] = s.positions[i / 2] + 1e-3 * kSpacing * Vec3(i % 2, 0.0, 0.0);
      if (kind == 2) s.velocities[i] = 1e6 * Vec3(i % 3 - 1.0, i % 5 - 2.0, 0.0);
      if (kind == 3 && i == 4) s.positions[i].x() = std::numeric_limits<double>::quiet_NaN();
    }
    OrientedParticles particles = makeModel(20, allTerms());
    World world(particles, 1.0);
    solve::TimeMarch march(world.system, particles, params);
    for (int k = 0; k < 5; ++k) {
      const Points before = s.positions;
      const solve::TimeMarch::Outcome outcome = march.step(k * params.time_step, s);
      if (kind == 3) {
        EXPECT_FALSE(outcome.ok);
      }
      for (Index i = 0; i < s.size(); ++i) {
        if (outcome.ok) {
          EXPECT_TRUE(s.positions[i].allFinite() && s.orientations[i].coeffs().allFinite()) << kind;
        } else if (kind != 3) {
          EXPECT_EQ(s.positions[i], before[i]) << kind;
        }
      }
    }
  }
}

TEST(OrientedParticlesMaterial, AHeapThatListsCannotHoldIsRefused) {
  const Index n = model::NeighborList::kMostNeighbors + 2;
  const OrientedParticles particles = makeModel(n, {});
  const State s = emptyState(n);
  Points forces, torques;
  evaluate(particles, s, forces, torques);
  EXPECT_TRUE(std::isnan(forces[0].x()));
  EXPECT_TRUE(std::isnan(particles.elasticEnergy(s)));
}

TEST(OrientedParticlesMaterial, ParticlesMayComeAndGo) {
  OrientedParticles particles = makeModel(30, {});
  Points forces, torques;
  for (Index rows : {5, 7, 3}) {
    const State s = hexagonalPatch(rows, 6);
    particles.adopt(s);
    EXPECT_EQ(static_cast<Index>(particles.masses().size()), s.size());
    EXPECT_EQ(static_cast<Index>(particles.inertias().size()), s.size());
    evaluate(particles, s, forces, torques);
    EXPECT_LT(largest(forces), 1e-9);
    Points fresh, fresh_torques;
    const State moved = {perturb(s.positions, 0.1 * kSpacing), s.velocities, s.orientations, s.spins, s.traits};
    evaluate(particles, moved, forces, torques);
    evaluate(makeModel(s.size(), {}), moved, fresh, fresh_torques);
    EXPECT_TRUE(areSame(forces, fresh));
  }
}

TEST(OrientedParticlesMaterial, ItBeginsWithFramesWhoseZAxesAreTheNormals) {
  std::mt19937 generator(3);
  Points normals{Vec3::UnitZ(), -Vec3::UnitZ(), Vec3(1e-9, 0.0, -1.0).normalized()};
  while (normals.size() < 60) normals.push_back(randomVector(generator).normalized());
  OrientedParticles particles(Points(60, Vec3::Zero()), normals, kSpacing, thickSheet(), {});
  State s{Points(60, Vec3::Zero()), Points(60, Vec3::Zero())};
  particles.beginAtRest(s);
  for (Index i = 0; i < 60; ++i) {
    EXPECT_LT((s.orientations[i] * Vec3::UnitZ() - normals[i]).norm(), 1e-8) << i;
    EXPECT_NEAR(s.orientations[i].norm(), 1.0, 1e-15);
    EXPECT_EQ(s.traits[i].id, i);
    EXPECT_EQ(s.spins[i], Vec3::Zero());
  }
  EXPECT_EQ(s.orientations[1] * Vec3::UnitX(), Vec3::UnitX());
}

TEST(OrientedParticlesMaterial, TheSpinTorqueTurnsXAxesToAPrincipalDirectionAndMovesNothingElse) {
  // A cylinder about y, normals outwards, frames turned about them. Outside its axis a cylinder falls off: the least signed
  // curvature is across, the least absolute one along.
  for (model::PrincipalDirection principal : {model::PrincipalDirection::kSigned, model::PrincipalDirection::kAbsolute}) {
    State s = hexagonalPatch(9, 9);
    for (Index i = 0; i < s.size(); ++i) {
      s.positions[i] -= Vec3(4.25, 4.0 * 0.5 * std::sqrt(3.0), 0.0) * kSpacing;
      rollUp(0.2 / kSpacing, 0.0, s.positions[i], s.orientations[i]);
      s.orientations[i] = s.orientations[i] * Quaternion(Eigen::AngleAxisd(0.6, Vec3::UnitZ()));
    }
    OrientedParticlesParams p;
    Points forces, torques, still_forces, still_torques;
    evaluate(makeModel(s.size(), p), s, still_forces, still_torques);
    p.spin = 1.0;
    p.principal = principal;
    evaluate(makeModel(s.size(), p), s, forces, torques);
    EXPECT_TRUE(areSame(forces, still_forces));
    const Index middle = 4 * 9 + 4;
    for (Index i = 0; i < s.size(); ++i) {
      const Vec3 normal = s.orientations[i] * Vec3::UnitZ(), spin = torques[i] - still_torques[i];
      EXPECT_LT(spin.cross(normal).norm(), 1e-12 * largest(torques)) << i;
      if (i == middle) {
        // From 0.6 rad off the curved direction: back for the signed one, on to a right angle for the absolute one.
        EXPECT_LT(spin.dot(normal) * (principal == model::PrincipalDirection::kSigned ? 1.0 : -1.0), 0.0);
      }
    }
  }
}

TEST(OrientedParticlesMaterial, AreasLinksAndStrainsAreThoseOfTheParticles) {
  const Surface sphere = makeSphere(800, 2.0);
  const double spacing = OrientedParticles::findSpacing(16.0 * M_PI, 800);
  OrientedParticles particles(sphere.points, sphere.normals, spacing, thickSheet(), {});
  State s{sphere.points, Points(800, Vec3::Zero())};
  particles.beginAtRest(s);
  Points areas;
  particles.computeAreaVectors(s, areas);
  double area = 0.0, mass = 0.0;
  for (Index i = 0; i < 800; ++i) {
    area += areas[i].norm();
    mass += particles.masses()[i];
  }
  EXPECT_NEAR(area, 16.0 * M_PI, 1e-12 * area);
  EXPECT_NEAR(mass, 16.0 * M_PI * thickSheet().arealDensity(), 1e-12 * mass);
  EXPECT_NEAR(particles.enclosedVolume(s), 4.0 / 3.0 * M_PI * 8.0, 1e-12 * 34.0);

  State flat = hexagonalPatch(5, 5, 1.1 * kSpacing);
  flat.positions.back() = Vec3(1.0, 1.0, 1.0);  // far from all
  const OrientedParticles patch = makeModel(25, {});
  std::vector<double> strain;
  patch.computePointStrain(flat, strain);
  EXPECT_NEAR(strain[12], 0.1, 1e-12);
  EXPECT_EQ(strain[24], 0.0);
  EXPECT_NEAR(patch.maxStretch(flat), 0.1, 1e-12);
}

TEST(OrientedParticlesMaterial, SurfacesThatWouldCollapseAndParametersThatMakeNoSenseAreRefused) {
  OrientedParticlesParams p;
  p.exponents = Vec2(2.0, 1.0);
  p.cutoff = 4.0;
  EXPECT_THROW(makeModel(5, p), InputError);
  EXPECT_TRUE(checkParams(OrientedParticlesParams{}).empty());
  const auto isRefused = [](const std::function<void(OrientedParticlesParams&)>& change) {
    OrientedParticlesParams params;
    change(params);
    return !checkParams(params).empty();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(isRefused([](auto& q) { q.exponents = Vec2(6.0, 12.0); }));
  EXPECT_TRUE(isRefused([](auto& q) { q.exponents = Vec2(12.5, 6.0); }));
  EXPECT_TRUE(isRefused([](auto& q) { q.cutoff = 1.0; }));
  EXPECT_TRUE(isRefused([](auto& q) { q.weighting_height = 2.0; }));
  EXPECT_TRUE(isRefused([&](auto& q) { q.co_planarity = nan; }));
  EXPECT_TRUE(isRefused([&](auto& q) { q.spacing = nan; }));
  EXPECT_TRUE(isRefused([](auto& q) { q.melting = 0.0; }));
}

}  // namespace
}  // namespace deformable_surface::test
