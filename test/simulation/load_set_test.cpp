#include "../../src/simulation/load_set.h"

#include "clouds.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

using simulation::LoadSet;
using simulation::SceneParams;

model::MassSpring makeModel() {
  const Surface s = makeSheet(4, 4, 1.0, 1.0, 0.0);
  return model::MassSpring(s.points, s.normals, s.rings, s.area, false, model::MaterialParams(), model::MassSpringParams());
}

bool acts(const LoadSet& loads, const solve::ExternalLoad& load) {
  return std::count(loads.acting().begin(), loads.acting().end(), &load) == 1;
}

TEST(LoadSet, EvaluatesOnlyLoadsThatCanAct) {
  const model::MassSpring model = makeModel();
  SceneParams params;
  params.gravity.setZero();
  LoadSet loads(model, params);
  loads.choose();
  ASSERT_EQ(loads.acting().size(), 1u);
  EXPECT_TRUE(acts(loads, loads.forces));
  loads.gravity.gravity = Vec3(0.0, 0.0, -1.0);
  loads.pressure.setPressure(3.0);
  loads.drag.setDrag(0.5);
  loads.anchors = simulation::AnchorLoad({{2, Vec3::Zero(), 10.0}});
  loads.choose();
  EXPECT_EQ(loads.acting().size(), 5u);
  EXPECT_TRUE(acts(loads, loads.gravity) && acts(loads, loads.pressure) && acts(loads, loads.drag) && acts(loads, loads.anchors));
  loads.pressure.setPressure(0.0);
  loads.choose();
  EXPECT_FALSE(acts(loads, loads.pressure));
}

TEST(LoadSet, GivesAPartItsShareOfAForce) {
  const model::MassSpring model = makeModel();
  LoadSet whole(model, SceneParams()), part(model, SceneParams());
  simulation::NamedForces::Named force;
  force.started = true;
  force.points = {1, 3, 5};
  force.shares = {0.5, 0.3, 0.2};
  whole.forces.restore({force});
  whole.anchors = simulation::AnchorLoad({{0, Vec3::Zero(), 1.0}});
  whole.gravity.gravity = Vec3(1.0, 2.0, 3.0);
  std::vector<Index> new_index(16, -1);
  new_index[3] = 0;
  new_index[5] = 1;
  part.takePart(whole, new_index);
  ASSERT_EQ(part.forces.all().size(), 1u);
  EXPECT_EQ(part.forces.all()[0].points, (std::vector<Index>{0, 1}));
  EXPECT_EQ(part.forces.all()[0].shares, (std::vector<double>{0.3, 0.2}));
  EXPECT_TRUE(part.anchors.isEmpty());
  EXPECT_EQ(part.gravity.gravity, whole.gravity.gravity);
  EXPECT_TRUE(acts(part, part.gravity));
}

}  // namespace
}  // namespace deformable_surface::test
