// Changes of particles between steps: heat from knives.
#include "deformable_surface/simulation/simulation.h"

#include "clouds.h"
#include "particles.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace deformable_surface::test
