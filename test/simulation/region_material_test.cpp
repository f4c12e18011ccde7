// Surfaces of several materials: regions of a scene, and changes while it runs.
#include "deformable_surface/base/error.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "self_contact_runs.h"

namespace deformable_surface::test {
namespace {

using simulation::MaterialChangeParams;
using simulation::RegionParams;
using simulation::SceneParams;
using simulation::Simulation;

constexpr double kModulus = 1e5, kThickness = 1e-3, kPull = 1.0;  // Pa, m, N

geometry::Region beyond(double x) { return {geometry::Region::Kind::kBox, Vec3(x, -2, -2), Vec3(2, 2, 2), {}, 0.0}; }

RegionParams stiffer(double x, double ratio) {
  RegionParams region;
  region.region = beyond(x);
  region.material.young_modulus = ratio * kModulus;
  return region;
}

// A square metre in the plane, pinned at x = 0 and pulled at x = 1, in equilibrium.
SceneParams drawnSheet() {
  SceneParams p = hangingSheet();
  p.material.young_modulus = kModulus;
  p.material.thickness = kThickness;
  p.material.poisson_ratio = 0.0;
  p.gravity.setZero();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.type = solve::IntegratorType::kStatic;
  p.accuracy.estimate = false;
  return p;
}

cloud::PointCloud grid(Index n) { return asCloud(makeSheet(n, n, 1.0, 1.0, 0.0).points); }

double meanShift(const Simulation& s, double x) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < s.state().positions.size(); ++i) {
    const Vec3 rest = s.input().positions[i];
    if (std::abs(rest.x() - x) > 1e-9) continue;
    sum += s.state().positions[i].x() - rest.x();
    ++count;
  }
  return sum / count;
}

// In series the soft half has all of the strain: F L / (E h w). The triangles at the border, one spacing wide, are almost rigid,
// wherever in them the border lies.
TEST(Regions, ASheetWithAMuchStifferHalfStretchesInTheOtherHalf) {
  constexpr Index n = 21;
  for (const double ratio : {1e6, 1e-4}) {
    SceneParams p = drawnSheet();
    p.regions.push_back(stiffer(0.499, ratio));
    Simulation s(p, grid(n));
    const double soft = std::min(ratio, 1.0) * kModulus * kThickness, pull = std::min(ratio, 1.0);
    for (Index k = 0; k < n; ++k) {
      const double y = -0.5 + static_cast<double>(k) / (n - 1), share = (k == 0 || k == n - 1 ? 0.5 : 1.0) / (n - 1);
      s.setForce({"draw" + std::to_string(k), Vec3(1.0, y, 0.0), Vec3(pull * kPull * share, 0.0, 0.0), 0.0, 0.0, 1e300});
    }
    run(s, 1);
    const double spacing = 1.0 / (n - 1), strain = pull * kPull / soft,
                 expected = ratio > 1.0 ? (0.5 - spacing) * strain : 0.5 * strain;
    // The geometry is not linear: an error of the order of the strain.
    EXPECT_NEAR(meanShift(s, 1.0), expected, 2.0 * strain * expected) << ratio;
    const double stiff_part = ratio > 1.0 ? meanShift(s, 1.0) - meanShift(s, 0.5) : meanShift(s, 0.45);
    EXPECT_LT(std::abs(stiff_part), 1e-4 * expected) << ratio;
  }
}

TEST(Regions, AllOfTheSurfaceChangedIsAsASurfaceMadeSo) {
  SceneParams p = hangingSheet(), made = p;
  p.material.bending_rigidity = made.material.bending_rigidity = OrAuto<double>();
  made.material.young_modulus *= 4.0;
  made.material.density *= 2.0;
  MaterialChangeParams change;
  change.young_modulus = made.material.young_modulus;
  change.density = made.material.density;
  Simulation changed(p, sheetCloud()), as_made(made, sheetCloud());
  EXPECT_EQ(changed.setMaterial(nullptr, change), changed.state().size());
  run(changed, 20);
  run(as_made, 20);
  // Factors of two are exact: not even rounding differs.
  EXPECT_EQ(changed.stateHash(), as_made.stateHash());
  EXPECT_EQ(changed.statistics().error_estimate, as_made.statistics().error_estimate);
}

// Its contact with itself and with the table, too.
TEST(Regions, AFoldedSheetChangedIsAsOneMadeSo) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  MaterialChangeParams change;
  change.density = 2.0 * scene.params.material.density;
  Simulation changed(scene.params, scene.cloud);
  changed.setMaterial(nullptr, change);
  scene.params.material.density *= 2.0;
  Simulation as_made(scene.params, scene.cloud);
  run(changed, 150);
  run(as_made, 150);
  EXPECT_GT(as_made.statistics().self_contacts, 0u);
  EXPECT_EQ(changed.stateHash(), as_made.stateHash());
}

TEST(Regions, ARegionOfTheSceneIsAsOneThatIsChangedAtRest) {
  SceneParams p = hangingSheet(), with_region = p;
  with_region.regions.push_back(stiffer(0.5, 16.0));
  with_region.regions[0].material.density = 500.0;
  Simulation changed(p, sheetCloud()), as_made(with_region, sheetCloud());
  EXPECT_EQ(as_made.numOwnMaterial(), changed.setMaterial(&with_region.regions[0].region, with_region.regions[0].material));
  EXPECT_GT(as_made.numOwnMaterial(), 0);
  EXPECT_LT(as_made.numOwnMaterial(), as_made.state().size());
  run(changed, 10);
  run(as_made, 10);
  EXPECT_EQ(changed.stateHash(), as_made.stateHash());
  Simulation plain(p, sheetCloud());
  run(plain, 10);
  EXPECT_NE(plain.stateHash(), as_made.stateHash());
  // A reset restores the material of the scene.
  changed.reset();
  run(changed, 10);
  EXPECT_EQ(changed.stateHash(), plain.stateHash());
  const std::uint64_t with_regions = as_made.stateHash();
  as_made.setMaterial(nullptr, stiffer(0.0, 3.0).material);
  as_made.reset();
  run(as_made, 10);
  EXPECT_EQ(as_made.stateHash(), with_regions);
}

TEST(Regions, SnapshotsAndForksKnowTheMaterial) {
  Simulation s(hangingSheet(), sheetCloud());
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.2;
  ball.path = {{0.0, Vec3(0.5, 0.0, -0.25), Vec4(0, 0, 0, 1)}};
  s.setTool(ball);
  run(s, 3);
  const RegionParams part = stiffer(0.5, 100.0);
  s.setMaterial(&part.region, part.material);
  s.setDamping(3.0);
  run(s, 3);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork(), anew(hangingSheet(), sheetCloud());
  run(s, 5);
  run(fork, 5);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
  anew.restore(snapshot);
  run(anew, 5);
  EXPECT_EQ(anew.stateHash(), s.stateHash());
  s.reset();
  s.restore(snapshot);
  run(s, 5);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
}

// Nothing dissipates: a swinging sheet with two stiffnesses keeps its energy.
TEST(Regions, AMillionToOneWithinASheetKeepsTheEnergy) {
  SceneParams p = hangingSheet();
  p.material.damping = 0.0;
  p.material.young_modulus = 10.0;
  p.regions.push_back(stiffer(0.5, 1e6 * 10.0 / kModulus));
  Simulation s(p, sheetCloud(15));
  const auto energy = [&] {
    const simulation::Statistics now = s.statistics();
    return now.kinetic_energy + now.elastic_energy + now.potential_energy;
  };
  const double before = energy();
  double exchanged = 0.0;
  for (int k = 0; k < 30; ++k) {
    run(s, 1);
    exchanged = std::max(exchanged, std::abs(s.statistics().potential_energy));
    // The limit of the energy guard for the oscillation of Verlet's energy.
    EXPECT_LT(energy() - before, 0.25 * std::max(exchanged, 1e-12)) << k;
  }
  EXPECT_GT(exchanged, 0.0);
}

TEST(Regions, WhatCannotBeIsRefusedAndNothingChanges) {
  Simulation s(hangingSheet(), sheetCloud());
  run(s, 2);
  MaterialChangeParams change;
  EXPECT_THROW(s.setMaterial(nullptr, change), InputError);
  change.young_modulus = -1.0;
  EXPECT_THROW(s.setMaterial(nullptr, change), InputError);
  change.young_modulus = std::nan("");
  EXPECT_THROW(s.setMaterial(nullptr, change), InputError);
  EXPECT_THROW(s.setDamping(-1.0), InputError);
  EXPECT_EQ(s.numOwnMaterial(), 0);

  SceneParams particles = hangingSheet();
  particles.model = "oriented_particles";
  particles.material.bending_rigidity = 0.05;
  Simulation of_particles(particles, sheetCloud());
  change.young_modulus = 1e6;
  EXPECT_THROW(of_particles.setMaterial(nullptr, change), InputError);
  of_particles.setDamping(5.0);
  particles.regions.push_back(stiffer(0.5, 2.0));
  EXPECT_FALSE(checkParams(particles).empty());

  SceneParams nowhere = hangingSheet();
  nowhere.regions.push_back(stiffer(1.5, 2.0));
  EXPECT_THROW(Simulation(nowhere, sheetCloud()), InputError);
  nowhere.regions[0] = stiffer(0.5, 2.0);
  nowhere.mass_spring.bending = model::Bending::kNone;
  nowhere.regions[0].material.bending_rigidity = 1e-3;
  EXPECT_FALSE(checkParams(nowhere).empty());
}

}  // namespace
}  // namespace deformable_surface::test
