// A part that is stepped alone: it moves as in the whole surface, its surroundings stay, and points that it disturbs are found.
#include "../../src/simulation/active_part.h"

#include "../support/surfaces.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

constexpr double kStep = 1e-3;
constexpr Index kSide = 15, kMiddle = kSide * kSide / 2;

struct Sheet {
  Sheet() {
    params.integrator.time_step = kStep;
    params.gravity.setZero();
    params.material.young_modulus = 1e3;
    model = std::make_unique<model::MassSpring>(surface.points, surface.normals, surface.rings, surface.area, false,
                                                params.material, model::MassSpringParams{});
    loads = std::make_unique<simulation::LoadSet>(*model, params);
    for (const Vec3& p : surface.points) moving.push_back(std::abs(p.x() - 0.5) < 0.3 && std::abs(p.y()) < 0.3);
    state.positions[kMiddle].z() += 1e-3;
  }
  solve::TimeMarch::Outcome stepPart(simulation::ActivePart& part) { return part.step(0.0, state, none, none); }

  Surface surface = makeSheet(kSide, kSide, 1.0, 1.0, 0.1);
  simulation::SceneParams params;
  std::unique_ptr<model::MassSpring> model;
  std::unique_ptr<simulation::LoadSet> loads;
  std::vector<char> moving, none = std::vector<char>(kSide * kSide, 0);
  model::State state{surface.points, Points(surface.points.size(), Vec3::Zero())};
};

TEST(ActivePart, MovesAsInTheWholeSurfaceWhileNothingReachesItsWall) {
  Sheet s;
  simulation::ActivePart part(*s.model, s.moving, s.params, *s.loads, 0.0);
  ASSERT_TRUE(s.stepPart(part).ok);
  model::State alone = s.state, whole = s.state;
  part.put(alone);
  const solve::System system(*s.model, s.loads->acting(), s.none, 0.0);
  solve::TimeMarch march(system, *s.model, s.params.integrator);
  ASSERT_TRUE(march.step(0.0, whole).ok);
  ASSERT_LT(whole.positions[kMiddle].z(), 1e-3);
  const double moved = 1e-3 - whole.positions[kMiddle].z();
  for (std::size_t i = 0; i < s.moving.size(); ++i) {
    EXPECT_LT((alone.positions[i] - whole.positions[i]).norm(), 1e-2 * moved) << i;
    EXPECT_TRUE(s.moving[i] || alone.positions[i] == s.state.positions[i]) << i;
  }
}

TEST(ActivePart, FindsWhatItDisturbs) {
  Sheet s;
  simulation::ActivePart part(*s.model, s.moving, s.params, *s.loads, 0.0);
  std::vector<Index> hits;
  // A point beside the wall moves: the wall is pushed, and the point itself is fast.
  Index rim = -1;
  for (std::size_t k = 0; k < s.moving.size() && rim < 0; ++k)
    if (s.moving[k]) rim = static_cast<Index>(k);
  s.state.positions = s.surface.points;
  ASSERT_TRUE(s.stepPart(part).ok);
  EXPECT_LT(part.findHits(kStep, 1e-9, 1e-9, 0.07, hits), 1e-9);
  EXPECT_TRUE(hits.empty()) << "at rest nothing is disturbed";
  s.state.positions[rim].x() += 1e-3;
  part.march().restart();
  ASSERT_TRUE(s.stepPart(part).ok);
  part.findHits(kStep, 1e-3, 1e-5, 0.07, hits);
  EXPECT_TRUE(std::find(hits.begin(), hits.end(), rim) != hits.end());
  EXPECT_TRUE(std::any_of(hits.begin(), hits.end(), [&](Index i) { return !s.moving[i]; }));
}

TEST(ActivePart, TellsHowFarItHasGone) {
  Sheet s;
  simulation::ActivePart part(*s.model, s.moving, s.params, *s.loads, 0.0);
  ASSERT_TRUE(s.stepPart(part).ok);
  EXPECT_TRUE(part.hasMoved(s.surface.points, 1e-4));
  EXPECT_FALSE(part.hasMoved(s.surface.points, 2e-3));
  EXPECT_EQ(part.moving(), s.moving);
}

}  // namespace
}  // namespace deformable_surface::test
