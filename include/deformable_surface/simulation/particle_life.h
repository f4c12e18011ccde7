// What happens to oriented particles between steps: they cool and are heated, are born where there is room and go where tools
// take them. Apart from their model, which knows forces only, and from the simulation, which only says when.
#pragma once

#include "deformable_surface/model/oriented_particles/growth.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/simulation/particle_edit.h"
#include "deformable_surface/tool/tool.h"

#include <string>

namespace deformable_surface::simulation {

/// Keeps what belongs to points that are left, in their order: new_index (of those before), -1 = gone.
template <class T>
void keepThose(const std::vector<Index>& new_index, std::vector<T>& items) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i)
    if (new_index[i] >= 0) items[kept++] = items[i];
  items.resize(kept);
}

class ParticleLife {
 public:
  /// Kept by reference.
  explicit ParticleLife(model::OrientedParticles& model) : model_(model) {}

  struct Changes {
    std::vector<Index> new_index;  // of the particles before; -1 = gone; empty if none went
    Index born = 0;                // they are the last of the state
    bool has_flowed = false;       // rest shapes have changed
    bool are_hot = false;          // some particles are above the ambient temperature
    std::string notice;
  };

  /// Before the step from time (s) to time + step: temperatures, then who goes, then who is born. looks: whether it is time to
  /// look for room to be born in. Nobody is born while several pieces of the surface consist of newborns alone: what is born
  /// closes a gap between its parents, so that such pieces have come loose, and growth would only feed them.
  Changes update(double time, double step, bool looks, const std::vector<tool::ToolParams>& tools, model::State& state) const;

  /// Grows a surface through the particles there are (sec. 7 of [Szeliski 1991]), with relaxation in between; held (n, 1 = fixed
  /// in place) stay in any case. is_start: all take the shape that is found for their rest shape, and the model the spacing with
  /// which it has no tension; else the new ones alone take theirs. Returns what it did as one sentence, and the changes.
  Changes fit(const model::GrowthParams& growth, const std::vector<char>& held, bool is_start, model::State& state);

  /// Does the edit wholly, or throws InputError with the reason and changes nothing. pinned, pinned_turns: (n), position and
  /// orientation held.
  Changes edit(const ParticleEdit& edit, model::State& state, std::vector<char>& pinned, std::vector<char>& pinned_turns) const;

 private:
  static void takeOut(const std::vector<char>& is_gone, model::State& state, Changes& changes);
  void requireRoom(const model::State& state, const std::vector<Index>& placed) const;
  void heat(double time, double step, const std::vector<tool::ToolParams>& tools, model::State& state) const;
  void remove(double time, const std::vector<tool::ToolParams>& tools, model::State& state, Changes& changes) const;
  void append(const model::NewParticle& particle, model::State& state) const;
  model::GrowthParams growthParams() const;

  Index countDebris(const model::State& state) const;

  model::OrientedParticles& model_;
  mutable bool has_told_debris_ = false;
  mutable std::vector<char> is_gone_, inside_;  // scratch
};

}  // namespace deformable_surface::simulation
