// Changes of a model beside the motion: links are cut, material flows, particles are added and removed. Each model may bring one
// Evolution; the dynamics calls it.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/oriented_particles/growth_params.h"
#include "deformable_surface/simulation/particle_edit.h"
#include "deformable_surface/solve/breaking.h"
#include "deformable_surface/tool/blade.h"
#include "deformable_surface/tool/tool.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

/// Follows the simulation points, and must know on which side of a cut it is.
class CutFollower {
 public:
  virtual ~CutFollower() = default;
  /// A knife passed through the surface while the simulation points (m x 3) moved from before to after. Whatever follows them
  /// stops following points on the other side of the knife's path. Returns whether anything was separated.
  virtual bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after) = 0;
  /// The set of whole links (m) has changed.
  virtual void followLinks(const std::vector<std::pair<Index, Index>>& whole) = 0;
};

/// Which points were removed and added.
struct Population {
  std::vector<Index> new_index;  // of the points before; -1 = gone; empty if none went
  Index born = 0;                // they are the last of the state
  std::string notice;            // for the user; else empty
  std::string warning;           // what will not be as asked for; else empty
};

/// Keeps the values of the remaining points, in their order. new_index: of the former points, -1 = removed.
template <class T>
void keepThose(const std::vector<Index>& new_index, std::vector<T>& items) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i)
    if (new_index[i] >= 0) items[kept++] = items[i];
  items.resize(kept);
}

/// By default, nothing but the motion changes.
class Evolution {
 public:
  virtual ~Evolution() = default;

  /// A reset begins: the model is again as it was made, except for removed and added points.
  virtual void forget() {}
  /// The state is at rest, as the model began it. pinned, pinned_turns: (n), position and orientation held.
  virtual Population begin(const std::vector<char>& /*pinned*/, const std::vector<char>& /*pinned_turns*/,
                           model::State& /*state*/) {
    return {};
  }

  struct Change {
    Population population;
    bool has_energy = false;  // points, elements or their rest state have changed, and so has the energy
  };
  /// Before the step from time (s) to time + step.
  virtual Change beforeStep(double /*time*/, double /*step*/, const std::vector<tool::ToolParams>& /*tools*/,
                            model::State& /*state*/) {
    return {};
  }
  /// Adds the points that do not move in the step, beside those held by pins and tools, to held, held_turns (n). Sets their
  /// velocities to zero.
  virtual void hold(model::State& /*state*/, std::vector<char>& /*held*/, std::vector<char>& /*held_turns*/) const {}
  /// Before the points move.
  virtual void beginStep(double /*time*/, const std::vector<tool::ToolParams>& /*tools*/, const Points& /*positions*/) {}
  /// What breaks within the step, from beginStep() on; null: nothing.
  virtual solve::Breaking* breaking() { return nullptr; }
  struct AfterStep {
    bool has_cut = false, has_flowed = false;
    bool leaves_copies = false;  // points have changed in another way that copies of fewer points do not follow
  };
  /// After the points have moved. follower: null if nothing follows them.
  virtual AfterStep endStep(double /*time*/, double /*step*/, const std::vector<tool::ToolParams>& /*tools*/,
                            model::State& /*state*/, CutFollower* /*follower*/) {
    return {};
  }

  /// Whether this tool pushes points out of itself.
  virtual bool isPushedBy(const tool::ToolParams& /*tool*/) const { return true; }
  /// Whether steps may skip points at rest; and whether they may skip some while others move.
  virtual bool maySleep() const { return true; }
  virtual bool maySleepInParts() const { return true; }

  /// The part of a snapshot that is not in the state.
  struct Memory {
    virtual ~Memory() = default;
    virtual std::size_t bytes() const = 0;
  };
  /// Null: nothing. Allocates only after a change.
  virtual std::shared_ptr<const Memory> memory() const { return nullptr; }
  virtual void setMemory(const std::shared_ptr<const Memory>& /*saved*/) {}
  /// A hash of the state extended by what decides the coming steps and is not in the state; unchanged if there is nothing.
  virtual std::uint64_t addToHash(std::uint64_t hash) const { return hash; }

  // For models with has_population.
  /// Makes the whole edit, or throws InputError with the reason and changes nothing. pinned, pinned_turns: (n), position and
  /// orientation held.
  virtual Population edit(const ParticleEdit& /*edit*/, model::State& /*state*/, std::vector<char>& /*pinned*/,
                          std::vector<char>& /*pinned_turns*/) {
    return {};
  }
  /// Grows a surface through the present points. held, held_turns: (n), 1 = stays, does not turn. is_start: at rest.
  virtual Population growSurface(const model::GrowthParams& /*growth*/, const std::vector<char>& /*held*/,
                                 const std::vector<char>& /*held_turns*/, bool /*is_start*/, model::State& /*state*/) {
    return {};
  }
};

}  // namespace deformable_surface::simulation
