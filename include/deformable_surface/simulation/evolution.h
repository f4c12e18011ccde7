// What of a model changes beside the motion: links are cut, matter flows, particles are born and go. Every model may bring one;
// the dynamics says when.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/oriented_particles/growth_params.h"
#include "deformable_surface/simulation/particle_edit.h"
#include "deformable_surface/tool/blade.h"
#include "deformable_surface/tool/tool.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

/// What follows the simulation points and must know on which side of a cut it is.
class CutFollower {
 public:
  virtual ~CutFollower() = default;
  /// A knife went through the surface while the simulation points (m x 3) moved from before to after: what follows them no longer
  /// follows those that the knife went between. Returns whether there is any.
  virtual bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after) = 0;
  /// The links (m) that are whole are others than before.
  virtual void followLinks(const std::vector<std::pair<Index, Index>>& whole) = 0;
};

/// Which points have gone and come.
struct Population {
  std::vector<Index> new_index;  // of the points before; -1 = gone; empty if none went
  Index born = 0;                // they are the last of the state
  std::string notice;            // what a user should know; else empty
};

/// Keeps what belongs to points that are left, in their order: new_index (of those before), -1 = gone.
template <class T>
void keepThose(const std::vector<Index>& new_index, std::vector<T>& items) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i)
    if (new_index[i] >= 0) items[kept++] = items[i];
  items.resize(kept);
}

/// By default nothing changes but the motion.
class Evolution {
 public:
  virtual ~Evolution() = default;

  /// A reset begins: the model is again as it was made, but for points that have gone or come.
  virtual void forget() {}
  /// The state is at rest, as the model began it. pinned (n).
  virtual Population begin(const std::vector<char>& /*pinned*/, model::State& /*state*/) { return {}; }

  struct Change {
    Population population;
    bool has_energy = false;  // points, elements or what they are at rest are others, and so is the energy
  };
  /// Before the step from time (s) to time + step.
  virtual Change beforeStep(double /*time*/, double /*step*/, const std::vector<tool::ToolParams>& /*tools*/,
                            model::State& /*state*/) {
    return {};
  }
  /// Which points do not move in it, beside those that pins and tools hold: held, held_turns (n), added to. Their velocities are
  /// set to zero.
  virtual void hold(model::State& /*state*/, std::vector<char>& /*held*/, std::vector<char>& /*held_turns*/) const {}
  /// The points begin to move.
  virtual void beginStep(double /*time*/, const std::vector<tool::ToolParams>& /*tools*/, const Points& /*positions*/) {}
  struct AfterStep {
    bool has_cut = false, has_flowed = false;
  };
  /// They have moved. follower: null, if nothing follows them.
  virtual AfterStep endStep(double /*time*/, double /*step*/, const std::vector<tool::ToolParams>& /*tools*/,
                            model::State& /*state*/, CutFollower* /*follower*/) {
    return {};
  }

  /// Whether such a tool pushes the points out.
  virtual bool isPushedBy(const tool::ToolParams& /*tool*/) const { return true; }
  /// Whether steps may leave out points that are at rest; and whether some, while others move.
  virtual bool maySleep() const { return true; }
  virtual bool maySleepInParts() const { return true; }

  /// What a snapshot must hold of it beside the state.
  struct Memory {
    virtual ~Memory() = default;
    virtual std::size_t bytes() const = 0;
  };
  /// Null: nothing. Allocates only if it has changed.
  virtual std::shared_ptr<const Memory> memory() const { return nullptr; }
  virtual void setMemory(const std::shared_ptr<const Memory>& /*saved*/) {}

  // Of a model that has_population.
  /// Does the edit wholly, or throws InputError with the reason and changes nothing. pinned, pinned_turns: (n), position and
  /// orientation held.
  virtual Population edit(const ParticleEdit& /*edit*/, model::State& /*state*/, std::vector<char>& /*pinned*/,
                          std::vector<char>& /*pinned_turns*/) {
    return {};
  }
  /// Grows a surface through the points that there are; held (n, 1 = fixed in place) stay in any case. is_start: at rest.
  virtual Population growSurface(const model::GrowthParams& /*growth*/, const std::vector<char>& /*held*/, bool /*is_start*/,
                                 model::State& /*state*/) {
    return {};
  }
};

}  // namespace deformable_surface::simulation
