// Values of a scene that change while its surface runs.
#include "deformable_surface/simulation/run_time_params.h"
#include "deformable_surface/base/error.h"
#include "self_contact_runs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

SceneParams changed(SceneParams p) {
  p.gravity = Vec3(1.0, 0.0, -3.0);
  p.material.young_modulus *= 4.0;
  p.material.damping = 2.0;
  p.viscous_drag = 0.3;
  p.pressure = 0.2;
  return p;
}

TEST(RunTimeParams, AChangeAtRestIsAsASceneThatSaysSo) {
  const SceneParams before = hangingSheet(), after = changed(before);
  Simulation s(before, sheetCloud()), as_made(after, sheetCloud());
  s.setParams(after);
  run(s, 8);
  run(as_made, 8);
  EXPECT_EQ(s.stateHash(), as_made.stateHash());
  EXPECT_EQ(s.statistics().error_estimate, as_made.statistics().error_estimate);
  // The value stays through resets.
  s.reset();
  run(s, 8);
  EXPECT_EQ(s.stateHash(), as_made.stateHash());
}

TEST(RunTimeParams, TheyBelongToSnapshotsAndForks) {
  Simulation s(hangingSheet(), sheetCloud());
  run(s, 3);
  s.setParams(changed(hangingSheet()));
  run(s, 2);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork();
  run(s, 4);
  const std::uint64_t expected = s.stateHash();
  run(fork, 4);
  EXPECT_EQ(fork.stateHash(), expected);
  s.setParams(hangingSheet());
  s.restore(snapshot);
  EXPECT_EQ(s.params().pressure, 0.2);
  run(s, 4);
  EXPECT_EQ(s.stateHash(), expected);
}

// Contact of a surface with itself is the stiffer, the more layers weigh.
TEST(RunTimeParams, GravityThatChangesIsThatOfForksAlsoInContact) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  scene.params.material.young_modulus *= 0.01;
  Simulation s(scene.params, scene.cloud);
  run(s, 40);
  scene.params.gravity *= 4.0;
  s.setParams(scene.params);
  Simulation fork = s.fork();
  run(s, 80);
  run(fork, 80);
  EXPECT_GT(s.statistics().self_contacts, 0u);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
}

TEST(RunTimeParams, PointsWithAModulusOfTheirOwnKeepIt) {
  SceneParams p = hangingSheet();  // whose bending rigidity is a number
  simulation::RegionParams all;
  all.region = {geometry::Region::Kind::kSphere, {}, {}, Vec3::Zero(), 9.0};
  all.material.young_modulus = p.material.young_modulus;
  p.regions = {all};
  Simulation s(p, sheetCloud()), same(p, sheetCloud());
  p.material.young_modulus *= 8.0;
  s.setParams(p);
  run(s, 4);
  run(same, 4);
  EXPECT_EQ(s.stateHash(), same.stateHash());
}

TEST(RunTimeParams, NormalsAreMadeFromThenOn) {
  SceneParams p = hangingSheet();
  p.output.normals = false;
  Simulation s(p, sheetCloud());
  EXPECT_TRUE(s.surface(true).normals.empty());
  p.output.normals = true;
  s.setParams(p);
  EXPECT_EQ(s.surface(true).normals.size(), s.input().positions.size());
}

TEST(RunTimeParams, OthersAndWrongOnesAreRefusedAndNothingChanges) {
  Simulation s(hangingSheet(), sheetCloud());
  run(s, 2);
  SceneParams other = changed(hangingSheet());
  other.integrator.time_step = 0.005;
  EXPECT_THROW(s.setParams(other), InputError);
  other = changed(hangingSheet());
  other.pressure = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(s.setParams(other), InputError);
  other = changed(hangingSheet());
  other.material.young_modulus = -1.0;
  EXPECT_THROW(s.setParams(other), InputError);
  Simulation plain(hangingSheet(), sheetCloud());
  run(plain, 5);
  run(s, 3);
  EXPECT_EQ(s.stateHash(), plain.stateHash());

  SceneParams particles = hangingSheet();
  particles.model = "oriented_particles";
  particles.material.bending_rigidity = 0.05;
  Simulation of_particles(particles, sheetCloud());
  particles.material.young_modulus *= 2.0;
  EXPECT_THROW(of_particles.setParams(particles), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
