// Scenes that use a feature which their model does not have are refused.
#include "deformable_surface/simulation/scene_params.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::simulation {
namespace {

bool isRefused(const SceneParams& scene, const std::string& key) {
  const std::vector<std::string> problems = checkParams(scene);
  return std::any_of(problems.begin(), problems.end(), [&](const std::string& p) { return p.rfind(key + ":", 0) == 0; });
}

TEST(SceneRules, OfEachModelItsDefaultsAreAccepted) {
  for (const char* model : {"mass_spring", "oriented_particles", "elastic_solid"}) {
    SceneParams scene;
    scene.model = model;
    EXPECT_TRUE(checkParams(scene).empty()) << model << ": " << checkParams(scene).front();
  }
}

TEST(SceneRules, WhatNeedsSidesIsRefusedOfABody) {
  SceneParams scene;
  scene.model = "elastic_solid";
  scene.pressure = 1.0;
  scene.viscous_drag = 1.0;
  scene.output.resample = true;
  scene.input.policy = InputPolicy::kTrack;
  for (const char* key : {"pressure", "viscous_drag", "output.resample", "input.policy"})
    EXPECT_TRUE(isRefused(scene, key)) << key;
  scene.model = "mass_spring";
  EXPECT_FALSE(isRefused(scene, "pressure"));
}

TEST(SceneRules, RegionsOfATargetNeedATarget) {
  SceneParams scene;
  scene.accuracy.regions.resize(1);
  EXPECT_TRUE(isRefused(scene, "accuracy.regions"));
  scene.accuracy.position_error = 0.01;
  EXPECT_FALSE(isRefused(scene, "accuracy.regions"));
}

TEST(SceneRules, ErrorsOfPointsNeedAnEstimateOfAMassSpringSurface) {
  SceneParams scene;
  scene.output.error = true;
  EXPECT_FALSE(isRefused(scene, "output.error"));
  scene.output.resample = true;
  EXPECT_TRUE(isRefused(scene, "output.error"));
  scene.output.resample = false;
  scene.accuracy.estimate = false;
  EXPECT_TRUE(isRefused(scene, "output.error"));
  scene.accuracy.estimate = true;
  for (const char* model : {"elastic_solid", "oriented_particles"}) {
    scene.model = model;
    EXPECT_TRUE(isRefused(scene, "output.error")) << model;
  }
}

TEST(SceneRules, KineticFrictionIsAtMostTheStaticOne) {
  SceneParams scene;
  scene.contact.friction = 0.3;
  EXPECT_FALSE(isRefused(scene, "contact.kinetic_friction"));
  scene.contact.kinetic_friction = 0.3;
  EXPECT_FALSE(isRefused(scene, "contact.kinetic_friction"));
  scene.contact.kinetic_friction = 0.31;
  EXPECT_TRUE(isRefused(scene, "contact.kinetic_friction"));
}

TEST(SceneRules, OrientationsAndCreasesAreForOrientedParticles) {
  SceneParams scene;
  scene.model = "mass_spring";
  scene.pins.resize(1);
  scene.pins[0].orientation = true;
  scene.creases.resize(1);
  EXPECT_TRUE(isRefused(scene, "pins[0].orientation"));
  EXPECT_TRUE(isRefused(scene, "creases"));
  scene.output.pieces_per_edge = 2;
  EXPECT_TRUE(isRefused(scene, "output.pieces_per_edge"));
  scene.model = "oriented_particles";
  EXPECT_FALSE(isRefused(scene, "pins[0].orientation"));
  EXPECT_FALSE(isRefused(scene, "creases"));
  EXPECT_FALSE(isRefused(scene, "output.pieces_per_edge"));
}

TEST(SceneRules, KeptBondsNeedARestShapeAndAddNoParticles) {
  SceneParams scene;
  scene.model = "oriented_particles";
  const model::OrientedParticlesParams free = scene.oriented_particles;
  model::OrientedParticlesParams& p = scene.oriented_particles;
  p.bonds = model::ParticleBonds::kKept;
  EXPECT_TRUE(checkParams(scene).empty());
  const model::OrientedParticlesParams kept = p;
  const auto expectRefused = [&](const char* key) {
    EXPECT_TRUE(isRefused(scene, std::string("oriented_particles.") + key)) << key;
    p.bonds = free.bonds;
    EXPECT_TRUE(checkParams(scene).empty()) << key;
    p = kept;
  };
  p.rest_shape = model::RestShape::kFlat;
  expectRefused("bonds");
  p.mode = model::ParticleMode::kPlane;
  expectRefused("bonds");
  p.stretching = true;
  expectRefused("bonds");
  p.growing = model::Growing::kGaps;
  expectRefused("bonds");
  p.grow_surface = true;
  expectRefused("bonds");
  p.co_circularity = 1.0;
  expectRefused("co_circularity");
  p.yield_curvature = 1.0;
  expectRefused("yield_curvature");
}

TEST(SceneRules, ContactOfASurfaceWithItselfNeedsTriangles) {
  SceneParams scene;
  scene.contact.self = true;
  scene.model = "mass_spring";
  EXPECT_FALSE(isRefused(scene, "contact.self"));
  scene.mass_spring.tear_strain = 0.5;
  EXPECT_FALSE(isRefused(scene, "contact.self"));
  scene.mass_spring.tear_strain = 0.0;
  scene.model = "oriented_particles";
  EXPECT_TRUE(isRefused(scene, "contact.self"));
}

TEST(SceneRules, UntanglingNeedsContactAndTime) {
  SceneParams scene;
  scene.contact.untangle = true;
  EXPECT_TRUE(isRefused(scene, "contact.untangle"));
  scene.contact.self = true;
  EXPECT_FALSE(isRefused(scene, "contact.untangle"));
  scene.integrator.type = solve::IntegratorType::kStatic;
  EXPECT_TRUE(isRefused(scene, "contact.untangle"));
}

}  // namespace
}  // namespace deformable_surface::simulation
