// What is told of steps that are far more work than others.
#include "clouds.h"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

namespace deformable_surface::test {
namespace {

using solve::IntegratorType;

constexpr char kTold[] = "steps of integrator.type implicit now take ", kTouched[] = "a tool touches, and steps of integrator";

// How many notices of 60 steps, in which a ball presses on a held sheet, have these words. If the ball is away, the sheet sags.
int countTold(const char* words, IntegratorType type, double young_modulus, double away) {
  simulation::SceneParams p = hangingSheet();
  if (away == 0.0) p.gravity.setZero();
  p.material.young_modulus = young_modulus;
  p.integrator.type = type;
  p.integrator.max_substeps = 100000;
  p.accuracy.estimate = false;
  p.tools.emplace_back();
  p.tools[0].id = "ball";
  p.tools[0].shape.radius = 0.15;
  const Vec4 upright(0.0, 0.0, 0.0, 1.0);
  p.tools[0].path = {{0.0, Vec3(0.6, 0.0, 0.16 + away), upright}, {0.6, Vec3(0.6, 0.0, -0.1 + away), upright}};
  simulation::Simulation s(p, sheetCloud(20));
  int told = 0;
  for (int k = 0; k < 60; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    told += outcome.notice.find(words) != std::string::npos;
  }
  return told;
}

TEST(CostlySteps, AreToldOnceWhereVerletWouldBeFaster) {
  EXPECT_EQ(countTold(kTold, IntegratorType::kImplicit, 1e5, 0.0), 1);
  EXPECT_EQ(countTold(kTold, IntegratorType::kVerlet, 1e5, 0.0), 0);
  EXPECT_EQ(countTold(kTold, IntegratorType::kAuto, 1e5, 0.0), 0);
}

TEST(CostlySteps, NameATool) { EXPECT_EQ(countTold(kTouched, IntegratorType::kImplicit, 1e5, 0.0), 1); }

TEST(CostlySteps, AreToldWithoutContactAndNameNoTool) {
  EXPECT_EQ(countTold(kTold, IntegratorType::kImplicit, 1e5, 1.0), 1);
  EXPECT_EQ(countTold(kTouched, IntegratorType::kImplicit, 1e5, 1.0), 0);
}

TEST(CostlySteps, AreNotToldWhereVerletNeedsVeryManySubsteps) {
  EXPECT_EQ(countTold(kTold, IntegratorType::kImplicit, 1e11, 0.0), 0);
}

// A tool pulls a sheet into one place.
simulation::Simulation makeCrumpled(double strength, bool self) {
  simulation::SceneParams p;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.material.young_modulus = 1e4;
  p.material.thickness = 0.005;
  p.contact.self = self;
  p.accuracy.estimate = false;
  p.tools.emplace_back();
  p.tools[0].id = "magnet";
  p.tools[0].mode = tool::Mode::kAttract;
  p.tools[0].strength = strength;
  p.tools[0].reach = 1.0;
  p.tools[0].shape.radius = 0.01;
  p.tools[0].path = {{0.0, Vec3(0.5, 0.5, 0.05), Vec4(0.0, 0.0, 0.0, 1.0)}};
  return simulation::Simulation(p, sheetCloud(15));
}

// In which of 20 steps it is told that contact takes most of the work.
std::vector<int> findContactTold(simulation::Simulation& s) {
  std::vector<int> told;
  for (int k = 0; k < 20; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (outcome.notice.find("in very many places; tool 'magnet' attracts") != std::string::npos) told.push_back(k);
  }
  return told;
}

TEST(CostlySteps, InWhichASurfaceIsCrumpledAreToldOnce) {
  for (const auto& [strength, self, count] : {std::tuple(2000.0, true, 1u), {1.0, true, 0u}, {2000.0, false, 0u}}) {
    simulation::Simulation s = makeCrumpled(strength, self);
    EXPECT_EQ(findContactTold(s).size(), count) << strength << (self ? " N with" : " N without") << " contact";
  }
}

TEST(CostlySteps, InWhichASurfaceIsCrumpledAreToldInTheSameStepAfterAReset) {
  simulation::Simulation s = makeCrumpled(2000.0, true);
  const std::vector<int> first = findContactTold(s);
  EXPECT_EQ(first.size(), 1u);
  s.reset();
  EXPECT_EQ(findContactTold(s), first);
}

}  // namespace
}  // namespace deformable_surface::test
