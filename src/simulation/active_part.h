// Simulates the part of a surface that is awake as if it were alone: with a model, loads and time march of its own on arrays of
// its own. Every loop of a step then costs only the awake points. The surrounding points are held in place.
#pragma once

#include "deformable_surface/solve/time_march.h"
#include "load_set.h"
#include "part_motion_limit.h"

#include <memory>

namespace deformable_surface::simulation {

/// Its points are of three kinds: moving ones; the wall, held points that share elements with them; and points behind the
/// wall that share elements with it. These make the forces on the wall complete: the forces show when it should have moved.
class ActivePart {
 public:
  /// moving (n): of the surface, at least one. params is kept by reference. Throws nothing; the model must have a Partition.
  /// loads: of the surface; damping: 1/s.
  ActivePart(const model::DeformableModel& whole, const std::vector<char>& moving, const SceneParams& params,
             const LoadSet& loads, double damping);

  /// The loads or tools of the surface have changed.
  void setLoads(const LoadSet& loads);

  /// Parts of the surface must not cross. contact: of the surface, kept by reference.
  void limitMotion(contact::SelfContact& contact);
  /// Null: nothing breaks. Kept by reference, and only asked: the step in which something would break is void.
  void watchBreaking(const solve::Breaking* breaking);
  /// Whether something was stretched too far in the last step.
  bool hasStretched() const { return stretch_watch_.has_stretched; }
  /// Before a step of a time (s) from a state of the surface: whether it can be told of the moving points alone that nothing will
  /// cross. True without limitMotion().
  bool foresee(const State& state, double time) { return !limit_ || limit_->foresee(state, time); }
  /// Whether this could no longer be told in the last step, which is then void.
  bool hasLeftForesight() const { return limit_ && limit_->hasLeft(); }
  /// Advances a copy of the moving points by a step from the surface's state; held, held_turns (n): of the surface.
  solve::TimeMarch::Outcome step(double time, const State& state, const std::vector<char>& held,
                                 const std::vector<char>& held_turns);
  /// Writes the copy into the surface's state.
  void put(State& state) const;

  /// The points of the surface where the copy disturbs the wall: points of the wall whose acceleration at a time (s) exceeds
  /// a limit (m/s^2), and moving points beside it that are faster than the speed (m/s). Turns count by the motion they cause
  /// at the distance of a spacing (m). Overwritten. Returns the largest acceleration of the wall.
  double findHits(double time, double acceleration, double speed, double spacing, std::vector<Index>& hits);
  /// Whether a moving point of the copy is farther than a distance, m, from its place in since (n x 3 of the surface).
  bool hasMoved(const Points& since, double distance) const;

  /// (n) The moving points that it was made for.
  const std::vector<char>& moving() const { return moving_; }
  /// The state of the copy, for display.
  const State& state() const { return state_; }
  const solve::System& system() const { return system_; }
  const std::vector<Index>& points() const { return points_; }  // of the surface, ascending
  bool isMoving(Index k) const { return kind_[k] == Kind::kMoving || kind_[k] == Kind::kRim; }

  /// See ContactLoad.
  double takeContactSeconds() const { return loads_.contact.takeSeconds(); }
  solve::TimeMarch& march() { return march_; }
  const solve::TimeMarch& march() const { return march_; }

 private:
  struct StretchWatch : solve::Breaking {
    bool isAnyStretched(const model::DeformableModel& model, const State& state) const override {
      return breaking->isAnyStretched(model, state);
    }
    std::optional<double> breakStretched(const State& state) override {
      has_stretched = has_stretched || isAnyStretched(*model, state);
      return {};
    }
    void takeBack() override {}
    const solve::Breaking* breaking = nullptr;
    const model::DeformableModel* model = nullptr;
    bool has_stretched = false;
  };
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
  std::unique_ptr<PartMotionLimit> limit_;  // null: none
  StretchWatch stretch_watch_;
  State state_;
  Points forces_on_all_, torques_on_all_;  // scratch
};

}  // namespace deformable_surface::simulation
