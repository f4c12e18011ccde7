// Scenes in which a surface meets itself, and what tests count in them.
#pragma once

#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "../../src/simulation/contact_skin.h"
#include "../support/contact_scenes.h"
#include "../support/crossings.h"

namespace deformable_surface::test {

inline ContactScene makeScene(const std::string& name, std::uint32_t seed, double duration,
                              solve::IntegratorType type = solve::IntegratorType::kVerlet) {
  ContactSceneMaker maker(seed);
  for (const auto& [known, make] : listContactScenes()) {
    if (known != name) continue;
    ContactScene scene = make(maker);
    scene.params.duration = duration;
    scene.params.integrator.type = type;
    return scene;
  }
  throw InputError("contact scenes: found " + name);
}

struct SelfContactOutcome {
  int crossed = 0;    // checks in which any triangles cross
  Index touched = 0;  // most pairs in contact
};
inline SelfContactOutcome simulate(const ContactScene& scene) {
  SelfContactOutcome seen;
  simulation::Simulation s(scene.params, scene.cloud);
  const std::vector<contact::Triangle> triangles = simulation::ContactSkin(s.state().positions, trianglesOf(s.model())).triangles;
  const int steps = static_cast<int>(std::lround(scene.params.duration / scene.params.integrator.time_step));
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (!outcome.ok) return seen;
    if (k % 4 != 3) continue;
    seen.crossed += !findCrossings(s.state().positions, triangles).empty();
    seen.touched = std::max(seen.touched, static_cast<Index>(s.statistics().self_contacts));
  }
  return seen;
}

}  // namespace deformable_surface::test
