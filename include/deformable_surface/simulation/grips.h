// What carries points: tools that move what is inside them when they begin, and pins that go along a path. Apart from contact,
// because a grip remembers what it holds.
#pragma once

#include "deformable_surface/simulation/tool_reaction.h"
#include "deformable_surface/tool/tool.h"

#include "deformable_surface/model/deformable_model.h"

namespace deformable_surface::simulation {

/// Gripped points are held (see solve::System) and move with the tool: in every step straight from where they are to their place
/// in the tool at its end. Where the force that the grip has to bear exceeds the tool's strength at the beginning of a step it
/// lets go of all, and does not take hold again.
class Grips {
 public:
  /// What a snapshot must hold.
  struct Grip {
    tool::ToolParams tool;
    bool has_begun = false;
    std::vector<Index> points;  // ascending
    Points places;              // m, in the tool's frame
    bool is_pin = false;        // a pin in motion, of whose tool only id and path count; it never lets go by itself
  };

  /// Those of mode move; a grip whose tool is there as before, but for its path, keeps what it holds.
  void setTools(const std::vector<tool::ToolParams>& tools);
  /// No tool that moves, and no pin in motion.
  bool isEmpty() const { return grips_.empty(); }
  /// Whether update() looks at the forces.
  bool readForces() const;
  /// Lets go of everything but of pins, to take hold anew.
  void reset();

  /// A pin carries these points of a state from a time on. They leave the pins that carry them.
  void addPin(const std::string& id, const std::vector<tool::WaypointParams>& path, double time, std::vector<Index> points,
              const model::State& state);
  void movePin(const std::string& id, const std::vector<tool::WaypointParams>& path);
  const Grip* findPin(const std::string& id) const;
  /// Points (n, 1 = keep) that are not kept leave the pins that carry them.
  void keepOnPins(const std::vector<char>& kept);
  void clearPins();
  bool hasPins() const;
  bool isOnPin(Index point) const;
  /// The points of pins whose path leads elsewhere between two times.
  void findMovingPins(double from, double to, std::vector<Index>& moving) const;

  /// At the beginning of a step: tools whose time has come take hold of the points inside them that are not pinned, those whose
  /// time is over or whose grip is too weak let go. forces (n x 3): what acts on every point, N. slack, s: by which a beginning
  /// may lie ahead: rounding of times must not lose a step. Returns whether any did, and what a user should know.
  struct Update {
    bool changed = false;
    std::string notice;
  };
  Update update(double time, double slack, const model::State& state, const std::vector<char>& pinned, const Points& forces);
  /// Marks the gripped points in held, and gives them the velocity that takes them to their places within the step.
  void carry(double time, double step, model::State& state, std::vector<char>& held) const;
  /// Points have got other indices: new_index (of those before), -1 = gone.
  void renumber(const std::vector<Index>& new_index);

  const std::vector<Grip>& all() const { return grips_; }
  void restore(const std::vector<Grip>& grips) { grips_ = grips; }

  /// forces as in update().
  void addReactions(double time, const model::State& state, const Points& forces, std::vector<ToolReaction>& reactions) const;

 private:
  std::vector<Grip> grips_;
};

}  // namespace deformable_surface::simulation
