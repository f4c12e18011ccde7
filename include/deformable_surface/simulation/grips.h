// Carried points: tools that move the points inside them when they begin, and pins that follow a path. Unlike contact, a grip
// remembers which points it holds.
#pragma once

#include "deformable_surface/simulation/tool_reaction.h"
#include "deformable_surface/tool/tool.h"

#include "deformable_surface/model/deformable_model.h"

#include <optional>

namespace deformable_surface::simulation {

/// Gripped points are held (see solve::System) and move with the tool: in every step straight from their place to their place
/// in the tool at the end of the step. If the force on a grip exceeds the tool's strength at the beginning of a step, the grip
/// releases all points and does not take hold again.
class Grips {
 public:
  /// Must be in a snapshot.
  struct Grip {
    tool::ToolParams tool;
    bool has_begun = false;
    std::vector<Index> points;             // ascending
    Points places;                         // m, in the tool's frame
    std::vector<model::ClampEdge> edges;   // of a tool: where it clamps, ascending
    std::optional<tool::Pose> carried_to;  // at the end of the last step
    bool is_pin = false;                   // a moving pin; only id and path of its tool are used; it never releases by itself
  };

  /// Takes the tools of mode move. A grip whose tool is unchanged, except for its path, keeps its points.
  void setTools(const std::vector<tool::ToolParams>& tools);
  /// There is no tool that moves points, and no moving pin.
  bool isEmpty() const { return grips_.empty(); }
  /// Whether update() reads the forces.
  bool readForces() const;
  /// Releases everything except pins; tools take hold again.
  void reset();

  /// A pin carries these points of a state from a time on. Pins that carried them release them.
  void addPin(const std::string& id, const std::vector<tool::WaypointParams>& path, double time, std::vector<Index> points,
              const model::State& state);
  void movePin(const std::string& id, const std::vector<tool::WaypointParams>& path);
  const Grip* findPin(const std::string& id) const;
  /// Pins release all points that are not kept (n, 1 = keep).
  void keepOnPins(const std::vector<char>& kept);
  void clearPins();
  bool hasPins() const;
  bool isOnPin(Index point) const;
  /// The points of pins whose path moves between two times.
  void findMovingPins(double from, double to, std::vector<Index>& moving) const;

  /// At the beginning of a step: tools that begin take hold of the points inside them that are not pinned; tools that end
  /// and grips that are too weak release theirs. forces (n x 3): on every point, N. slack, s: a beginning may lie ahead by this
  /// much, so that rounding of times does not lose a step. Returns whether any did, and a notice for the user.
  struct Update {
    bool changed = false;
    std::vector<std::size_t> begun;  // which of all() took hold
    std::string notice;
  };
  Update update(double time, double slack, const model::State& state, const std::vector<char>& pinned, const Points& forces);
  /// Sets where a grip that has just taken hold clamps, and the free points beside it that it carries, too.
  void clamp(std::size_t grip, double time, std::vector<model::ClampEdge> edges, const std::vector<Index>& riding,
             const model::State& state);
  /// Marks the points of each grip as a patch of their own, and adds its edges, ascending (see model::Clamping).
  void addPatches(std::vector<char>& patches, std::vector<model::ClampEdge>& edges) const;
  /// Marks the gripped points in held, and gives them the velocity that takes them to their places within the step. Those that
  /// contact has held back catch up at most twice as fast as the path is at its fastest, unless at_once. Places on a new path,
  /// and on one that rests, are reached at once.
  void carry(double time, double step, bool at_once, model::State& state, std::vector<char>& held);
  /// The indices of points have changed: new_index (of the former points), -1 = removed.
  void renumber(const std::vector<Index>& new_index);

  const std::vector<Grip>& all() const { return grips_; }
  void restore(const std::vector<Grip>& grips) { grips_ = grips; }

  /// forces as in update().
  void addReactions(double time, const model::State& state, const Points& forces, std::vector<ToolReaction>& reactions) const;

 private:
  std::vector<Grip> grips_;
};

}  // namespace deformable_surface::simulation
