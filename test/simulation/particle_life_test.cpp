// Changes of particles between steps: heat from knives.
#include "deformable_surface/simulation/simulation.h"

#include "clouds.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

simulation::SceneParams particleSheet() {
  simulation::SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  return p;
}

TEST(ParticleLife, AKnifeHeatsWhatItTouchesToItsTemperatureOrNothing) {
  for (const double strength : {0.0, 700.0}) {
    simulation::SceneParams p = particleSheet();
    p.tools.resize(1);
    p.tools[0].id = "knife";
    p.tools[0].mode = tool::Mode::kCut;
    p.tools[0].strength = strength;
    p.tools[0].shape.radius = 0.2;
    p.tools[0].path.resize(1);
    p.tools[0].path[0].position = Vec3(0.5, 0.5, 0.0);
    simulation::Simulation s(p, sheetCloud(12));
    const Points before = s.state().positions;  // the sheet is square: they have settled
    run(s, 1);
    Index touched = 0;
    for (Index i = 0; i < s.state().size(); ++i) {
      const double far = (before[i] - p.tools[0].path[0].position).norm();
      const double reach = 0.2 + 0.5 * latticeOf(s).spacing;
      EXPECT_EQ(s.state().traits[i].temperature, far > reach ? 0.0 : strength) << far;
      touched += far <= reach;
    }
    EXPECT_GT(touched, 10);
    EXPECT_LT(touched, s.state().size());
  }
}

// Two samples in nearly one place would stay there: repulsion is constant near zero, and none at zero.
TEST(ParticleLife, AfterAFitNoTwoParticlesAreInOnePlace) {
  for (const bool lets_go : {true, false})
    for (const double apart : {1e-9, 0.003, 0.1}) {  // spacings
      simulation::SceneParams p = particleSheet();
      p.pins.clear();
      p.simplification.method = cloud::SimplificationMethod::kNone;
      p.gravity.setZero();
      const double spacing = 0.1;
      p.oriented_particles.spacing = spacing;
      p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * spacing * spacing;
      p.oriented_particles.grow_surface = true;
      p.oriented_particles.growth.release_samples = lets_go;
      cloud::PointCloud cloud = sheetCloud(8);
      for (const Index i : {20, 33, 46}) cloud.positions.push_back(cloud.positions[i] + Vec3(0.6, 0.8, 0.0) * apart * spacing);
      cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
      simulation::Simulation s(p, cloud);
      double nearest = 1e300;
      for (Index i = 0; i < s.state().size(); ++i)
        for (Index j = 0; j < i; ++j) nearest = std::min(nearest, (s.state().positions[i] - s.state().positions[j]).norm());
      const auto& notes = s.buildNotes();
      const bool is_told = std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
        return note.find("3 pairs of held particles are nearer") != std::string::npos;
      });
      EXPECT_EQ(is_told, !lets_go) << apart;
      if (lets_go) {
        EXPECT_GE(nearest, 0.3 * latticeOf(s).spacing) << apart;
      }
      run(s, 5);
    }
}

}  // namespace
}  // namespace deformable_surface::test
