// The part of a surface that is awake, simulated as if it were all there is: its own model, loads and march on arrays of its own,
// so that every loop of a step costs what is awake. What surrounds it is held where it sleeps.
#pragma once

#include "deformable_surface/solve/time_march.h"
#include "load_set.h"

#include <memory>

namespace deformable_surface::simulation {

/// Points of three kinds: moving ones; the wall, which is held and has elements in common with them; and what is behind the wall,
/// which shares elements with it, so that the forces on the wall are whole: they say when it should have moved.
class ActivePart {
 public:
  /// moving (n): of the surface, at least one. params is kept by reference. Throws nothing; the model must know parts.
  /// loads: of the surface; damping: 1/s.
  ActivePart(const model::DeformableModel& whole, const std::vector<char>& moving, const SceneParams& params,
             const LoadSet& loads, double damping);

  /// Loads or tools of the surface have changed.
  void setLoads(const LoadSet& loads);

  /// Advances a copy of the moving points by a step from the surface's state; held, held_turns (n): as the surface has it.
  solve::TimeMarch::Outcome step(double time, const State& state, const std::vector<char>& held,
                                 const std::vector<char>& held_turns);
  /// The copy into the surface's state.
  void put(State& state) const;

  /// The points of the surface at which the copy disturbs the wall: those of the wall that are not in balance at a time (s)
  /// within the acceleration (m/s^2), and moving ones beside it that are faster than the speed (m/s). Turns count by what they
  /// move at the spacing (m). Overwritten. Returns the largest acceleration of the wall.
  double findHits(double time, double acceleration, double speed, double spacing, std::vector<Index>& hits);
  /// Whether a moving point of the copy is farther than a distance, m, from where it was, since (n x 3 of the surface).
  bool hasMoved(const Points& since, double distance) const;

  /// (n) As it was made for.
  const std::vector<char>& moving() const { return moving_; }
  /// For looking at the copy.
  const State& state() const { return state_; }
  const solve::System& system() const { return system_; }
  const std::vector<Index>& points() const { return points_; }  // of the surface, ascending
  bool isMoving(Index k) const { return kind_[k] == Kind::kMoving || kind_[k] == Kind::kRim; }

  /// See ContactLoad.
  double takeContactSeconds() const { return loads_.contact.takeSeconds(); }
  solve::TimeMarch& march() { return march_; }
  const solve::TimeMarch& march() const { return march_; }

 private:
  enum class Kind : char { kMoving, kRim, kWall, kBehind };  // rim: moving beside the wall
  struct Made {
    std::vector<char> moving;
    model::Partition::Part part;
    std::vector<Kind> kind;
  };
  void putFriction(std::vector<contact::BodyAnchor>& friction) const;
  static Made make(const model::DeformableModel& whole, const std::vector<char>& moving);
  ActivePart(Made made, const SceneParams& params, const LoadSet& loads, double damping);

  std::vector<char> moving_;
  std::unique_ptr<model::DeformableModel> model_;
  std::vector<Index> points_, new_index_;
  std::vector<Kind> kind_;
  LoadSet loads_;
  std::vector<char> held_, held_turns_, fixed_;  // fixed: held by the surface itself
  solve::System system_;
  solve::TimeMarch march_;
  State state_;
  Points forces_on_all_, torques_on_all_;  // scratch
};

}  // namespace deformable_surface::simulation
