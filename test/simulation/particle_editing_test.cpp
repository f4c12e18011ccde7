// Edits of single particles by a user: their effect, that the surface continues with them, and that a wrong edit changes nothing.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

constexpr double kSpacing = 0.1;

/// A flat sheet of particles at rest in z = 0.
Simulation makeSheet(const std::string& kind = "oriented_particles") {
  cloud::PointCloud input;
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) input.positions.emplace_back(kSpacing * (i + 0.5 * (j % 2)), kSpacing * std::sqrt(0.75) * j, 0.0);
  input.width = 64;
  SceneParams params;
  params.model = kind;
  params.gravity.setZero();
  return {params, input};
}

void run(Simulation& s, int steps) {
  for (int k = 0; k < steps; ++k) {
    const StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
  }
}

TEST(ParticleEditing, AddedParticlesAreThereWithNewIdsAndAreNotTakenForOthers) {
  Simulation s = makeSheet();
  const Index n = s.state().size(), next = s.state().next_id;
  ParticleEdit edit;
  edit.positions = {Vec3(0.3, 0.3, 0.5), Vec3(0.4, 0.3, 0.5)};
  edit.orientations.assign(2, Quaternion::Identity());
  EXPECT_EQ(s.editParticles(edit), (std::vector<Index>{next, next + 1}));
  EXPECT_EQ(s.state().size(), n + 2);
  run(s, 3);
  // Each is a row of the surface behind the input's.
  EXPECT_EQ(s.surface(true).positions.size(), s.input().positions.size() + 2);
  EXPECT_NEAR(s.surface(true).positions.back().z(), 0.5, 1e-2);
  s.reset();
  EXPECT_EQ(s.state().size(), n);
}

TEST(ParticleEditing, DeletedOnesAreGoneAndTheOthersKeepTheirIds) {
  Simulation s = makeSheet();
  ParticleEdit edit;
  edit.action = ParticleAction::kDelete;
  edit.ids = {5, 0};
  EXPECT_TRUE(s.editParticles(edit).empty());
  ASSERT_EQ(s.state().size(), 62);
  EXPECT_EQ(s.state().traits[0].id, 1);
  EXPECT_EQ(s.state().traits[4].id, 6);
  run(s, 3);
  EXPECT_TRUE(std::isnan(s.surface(true).positions[0].x()));
  EXPECT_THROW(s.editParticles(edit), InputError);
}

TEST(ParticleEditing, MovedOrientedAndCreasedOnesAreAsAsked) {
  Simulation s = makeSheet();
  ParticleEdit edit;
  edit.action = ParticleAction::kMove;
  edit.ids = {9};
  edit.positions = {s.state().positions[9] + Vec3(0.0, 0.0, 0.02)};
  s.editParticles(edit);
  EXPECT_EQ(s.state().positions[9], edit.positions[0]);

  edit = ParticleEdit();
  edit.action = ParticleAction::kCrease;
  edit.ids = {9, 10};
  s.editParticles(edit);
  EXPECT_FALSE(s.state().traits[10].is_smooth);
  EXPECT_TRUE(s.state().traits[11].is_smooth);

  edit.action = ParticleAction::kOrient;
  edit.orientations.assign(2, Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitX())));
  s.editParticles(edit);
  EXPECT_TRUE(s.state().traits[10].is_smooth);
  EXPECT_NEAR(s.state().orientations[10].angularDistance(edit.orientations[1]), 0.0, 1e-12);
  run(s, 3);
}

TEST(ParticleEditing, FixedOnesStayUntilTheyAreFreed) {
  Simulation s = makeSheet();
  ParticleEdit edit;
  edit.action = ParticleAction::kFix;
  edit.ids = {0, 1};
  s.editParticles(edit);
  s.setGravity(Vec3(0.0, 0.0, -9.81));
  const Vec3 place = s.state().positions[1];
  run(s, 5);
  EXPECT_EQ(s.state().positions[1], place);
  EXPECT_LT(s.state().positions[40].z(), -1e-4);
  edit.action = ParticleAction::kFree;
  s.editParticles(edit);
  run(s, 5);
  EXPECT_LT(s.state().positions[1].z(), 0.0);
}

TEST(ParticleEditing, AWrongEditChangesNothingAndSaysWhatWasFound) {
  Simulation s = makeSheet();
  run(s, 1);
  const std::uint64_t hash = s.stateHash();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Orientations upright(1, Quaternion::Identity());
  const Orientations twice(1, Quaternion(2.0, 0.0, 0.0, 0.0));
  const Vec3 far(0.0, 0.0, 1.0);
  using Action = ParticleAction;
  const std::vector<std::pair<ParticleEdit, std::string>> wrong = {
      {{Action::kAdd, {}, {}, {}}, "no particle"},
      {{Action::kAdd, {1}, {far}, upright}, "ids: found 1"},
      {{Action::kAdd, {}, {far}, {}}, "orientations: found 0"},
      {{Action::kAdd, {}, {Vec3(nan, 0, 0)}, upright}, "not finite"},
      {{Action::kAdd, {}, {far}, twice}, "length 2"},
      {{Action::kAdd, {}, {Vec3(0.01, 0.0, 0.0)}, upright}, "particle 64"},  // nearly on the first
      {{Action::kMove, {3, 4}, {far, far}, {}}, "m from particle 4"},
      {{Action::kMove, {3}, {}, {}}, "positions: found 0"},
      {{Action::kDelete, {3, 64}, {}, {}}, "particle 64"},
      {{Action::kDelete, {3, -1}, {}, {}}, "particle -1"},
      {{Action::kCrease, {3, 3}, {}, {}}, "twice"},
      {{Action::kOrient, {3}, {}, twice}, "length 2"},
  };
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    try {
      s.editParticles(wrong[i].first);
      ADD_FAILURE() << i;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(wrong[i].second), std::string::npos) << i << ": " << error.what();
    }
    EXPECT_EQ(s.stateHash(), hash) << i;
    EXPECT_EQ(s.state().size(), 64) << i;
  }
}

TEST(ParticleEditing, AnInterruptedEditChangesNothing) {
  Simulation s = makeSheet();
  ParticleEdit edit;
  edit.action = ParticleAction::kMove;
  edit.ids = {3};
  edit.positions = {Vec3(0.3, 0.3, 0.5)};
  const std::uint64_t hash = s.stateHash();
  std::atomic<bool> flag{true};
  const InterruptScope scope(flag);
  EXPECT_THROW(s.editParticles(edit), Interrupted);
  EXPECT_EQ(s.stateHash(), hash);
  flag = false;
  s.editParticles(edit);
  EXPECT_NE(s.stateHash(), hash);
}

TEST(ParticleEditing, AHoleIsGrownOverByAFit) {
  Simulation s = makeSheet();
  ParticleEdit edit;
  edit.action = ParticleAction::kDelete;
  edit.ids = {27};  // in the middle
  s.editParticles(edit);
  model::GrowthParams growth;
  growth.max_gap = 3.0;
  const std::string sentence = s.growSurface(growth);
  EXPECT_NE(sentence.find("1 particles were added to 63"), std::string::npos) << sentence;
  ASSERT_EQ(s.state().size(), 64);
  // Back to within a tenth of a spacing: the relaxation is no further from equilibrium, and the exact place is not stored.
  EXPECT_NEAR((s.state().positions.back() - s.input().positions[27]).norm(), 0.0, 0.1 * kSpacing);
  run(s, 3);
  growth.min_gap = 0.0;
  EXPECT_THROW(s.growSurface(growth), InputError);
}

TEST(ParticleEditing, AnInterruptedFitChangesNothing) {
  for (const bool has_begun : {false, true}) {
    Simulation s = makeSheet();
    ParticleEdit edit;
    edit.action = ParticleAction::kDelete;
    edit.ids = {27};
    s.editParticles(edit);
    if (has_begun) run(s, 1);
    model::GrowthParams growth;
    growth.max_gap = 3.0;
    std::atomic<bool> flag{false};
    const InterruptScope scope(flag);
    Simulation undisturbed = s.fork();
    long looks = 0;
    {
      const LookCounter counter(flag);
      undisturbed.growSurface(growth);
      looks = counter.count();
    }
    const std::uint64_t hash = s.stateHash();
    for (long at = 1; at <= looks; at += std::max(looks / 8, 1L)) {
      {
        const LookCounter counter(flag, at);
        EXPECT_THROW(s.growSurface(growth), Interrupted) << at << " of " << looks;
      }
      flag = false;
      ASSERT_EQ(s.stateHash(), hash) << at << " of " << looks;
      ASSERT_EQ(s.state().size(), 63) << at << " of " << looks;
    }
    s.growSurface(growth);
    run(s, 1);
    run(undisturbed, 1);
    EXPECT_EQ(s.stateHash(), undisturbed.stateHash());
  }
}

TEST(ParticleEditing, SpringsHaveNoParticles) {
  Simulation s = makeSheet("mass_spring");
  EXPECT_THROW(s.editParticles(ParticleEdit()), InputError);
  EXPECT_THROW(s.growSurface(model::GrowthParams()), InputError);
}

}  // namespace
}  // namespace deformable_surface::simulation
