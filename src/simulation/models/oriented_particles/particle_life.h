// What happens to oriented particles between steps: they cool and are heated, are born where there is room and go where tools
// take them. Apart from their model, which knows forces only.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/growth.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/scene_params.h"

#include "piercing_watch.h"

namespace deformable_surface::simulation {

class ParticleLife : public Evolution, public solve::Breaking {
 public:
  /// All are kept by reference. creased (n): particles of the beginning that are not smooth.
  ParticleLife(model::OrientedParticles& model, const std::vector<char>& creased, const SceneParams& scene)
      : model_(model), creased_(creased), scene_(scene) {}

  void forget() override { model_.setCuts({}); }
  Population begin(const std::vector<char>& pinned, const std::vector<char>& pinned_turns, model::State& state) override;
  /// Temperatures, then who goes, then who is born. Nobody is born while several pieces of the surface consist of newborns alone:
  /// what is born closes a gap between its parents, so that such pieces have come loose, and growth would only feed them.
  Change beforeStep(double time, double step, const std::vector<tool::ToolParams>& tools, model::State& state) override;
  void beginStep(double time, const std::vector<tool::ToolParams>& tools, const Points& positions) override;
  /// Kept bonds break within the step.
  solve::Breaking* breaking() override { return model_.hasKeptBonds() ? this : nullptr; }
  bool isAnyStretched(const model::DeformableModel& model, const model::State& state) const override;
  std::optional<double> breakStretched(const model::State& state) override;
  void takeBack() override { model_.setCuts(begun_with_); }
  /// Knives cut what they went through, and the cuts follow the particles.
  AfterStep endStep(double time, double step, const std::vector<tool::ToolParams>& tools, model::State& state,
                    CutFollower* follower) override;
  /// Knives cut without resistance, hot ones are solid.
  bool isPushedBy(const tool::ToolParams& tool) const override;
  /// Those that are too cold to move.
  void hold(model::State& state, std::vector<char>& held, std::vector<char>& held_turns) const override;
  bool maySleep() const override;
  /// Only what moves is in parts, not what particles live through.
  bool maySleepInParts() const override;
  std::shared_ptr<const Memory> memory() const override;
  void setMemory(const std::shared_ptr<const Memory>& saved) override;
  std::uint64_t addToHash(std::uint64_t hash) const override { return model_.cuts().addToHash(hash); }

  /// Sec. 7 of [Szeliski 1991], with relaxation in between. is_start: all take the shape that is found for their rest shape, and
  /// the model the spacing with which it has no tension; else the new ones alone take theirs.
  Population growSurface(const model::GrowthParams& growth, const std::vector<char>& held, const std::vector<char>& held_turns,
                         bool is_start, model::State& state) override;
  Population edit(const ParticleEdit& edit, model::State& state, std::vector<char>& pinned,
                  std::vector<char>& pinned_turns) override;

 private:
  struct Kept : Memory {
    std::size_t bytes() const override { return sizeof(Kept) + cuts.bytes(); }
    double spacing = 0.0;  // m, which a fit may have found
    model::ParticleCuts cuts;
  };

  static void takeOut(const std::vector<char>& is_gone, model::State& state, Population& changes);
  void grow(double time, const std::vector<tool::ToolParams>& tools, model::State& state, Population& changes);
  void reportArrival(const model::State& state, Population& changes);
  void requireRoom(const model::State& state, const std::vector<Index>& placed) const;
  void heat(double time, double step, const std::vector<tool::ToolParams>& tools, model::State& state) const;
  void remove(double time, bool looks, const std::vector<tool::ToolParams>& tools, model::State& state, Population& changes);
  bool mayJoin(const model::State& state) const;
  std::vector<model::NewParticle> join(double time, const std::vector<tool::ToolParams>& tools, const model::State& state,
                                       Population& changes);
  void markMeeting(const model::State& state);
  void markLoose(const model::State& state);
  void reportPiercing(double time, const std::vector<tool::ToolParams>& tools, const model::State& state, Population& changes);
  void noteTorn(double time, const std::vector<tool::ToolParams>& tools, const model::State& state);
  void append(const model::NewParticle& particle, model::State& state) const;
  void followBirths(const model::State& state, Index first, const std::vector<model::NewParticle>& born);
  bool cut(double time, double step, const std::vector<tool::ToolParams>& tools, const model::State& state);
  model::GrowthParams growthParams() const;

  std::vector<Index> findQuiet(const model::State& state, const cloud::KdTree& tree) const;
  Index countDebris(const model::State& state, const cloud::KdTree& tree) const;

  model::OrientedParticles& model_;
  const std::vector<char>& creased_;
  const SceneParams& scene_;
  bool is_hot_ = false;  // some particles are above the ambient temperature, or have flowed, before the last step
  mutable std::shared_ptr<const Kept> kept_;  // that was given out last
  Points before_;                             // m, when a step with a knife began last
  model::ParticleCuts begun_with_;            // when the last step began
  bool has_reported_debris_ = false, has_reported_heap_ = false, has_reported_gap_ = false;
  bool has_arrived_ = false;  // at the iso-surface, or where it hardly moves
  PiercingWatch piercing_;
  std::string torn_;                    // what the last step has torn, for the notice of the next one
  std::vector<char> is_gone_, inside_;  // scratch
};

}  // namespace deformable_surface::simulation
