// Which parts of a surface are awake: tiles of neighbouring points, how long each has been slow, and the error made by falling
// asleep. It takes no steps and knows no tools; Dynamics::advance() acts on it.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/simulation/sleep_params.h"
#include "deformable_surface/solve/system.h"

#include <Eigen/Geometry>

namespace deformable_surface::simulation {

using model::State;

/// Tiles of points move or sleep. A tile may sleep if all of its points have been slower than tolerance / quiet_time for
/// quiet_time, if no force would move them by more than a share of the tolerance from rest in that time, and if the distance to
/// the place where they would settle is estimated to be below the tolerance. Tiles around a tile that has not been
/// quiet for that long move with it.
class Activity {
 public:
  /// What a snapshot must hold.
  struct Memory {
    std::vector<std::int32_t> quiet;  // (tiles) steps in which all points were slow
    std::vector<char> moves;          // (tiles)
    double lost = 0.0;                // m, the largest motion that falling asleep has taken so far
    double wall = 0.0;                // m/s^2, remaining acceleration of sleeping points beside moving ones
    bool is_in_parts = false;         // by the tiles at first; else all of it is one
    bool is_fresh = true;             // a check for points in balance is due
    std::int32_t looks_in = 0;        // steps until the next check for tiles that may fall asleep
    std::int32_t margin = 1;          // rings of awake tiles around those that are not quiet, ahead of a front
    bool has_grown = false;           // since the last look
  };

  /// points: at rest, with their spacing (m); step (s). model is kept by reference. in_parts: if false, or if the model has no
  /// Partition, the whole surface is one tile, whose number of points may change.
  Activity(const SleepParams& params, const Points& points, double spacing, double step, const model::DeformableModel& model,
           bool in_parts);

  double speed() const { return tolerance_ / quiet_time_; }  // m/s
  double acceleration() const;                               // m/s^2
  double tolerance() const { return tolerance_; }            // m

  /// Everything moves, and a check for points in balance is due at once.
  void reset();
  const Memory& memory() const { return memory_; }
  void setMemory(const Memory& memory, const State& state);

  /// Everything moves.
  void wakeAll();
  /// The tiles of these points are disturbed: they and the tiles around them move.
  void wake(const std::vector<Index>& points);
  /// The same where a wave reached the wall within a step: from now on a wider margin around it moves.
  void widen(const std::vector<Index>& points);
  /// Wakes the sleeping tiles that may have a point in the box.
  void wakeIn(const Eigen::AlignedBox3d& box);

  bool isAsleep() const { return num_moving_ == 0; }
  bool isWhole() const { return num_moving_ == numTiles(); }
  /// (n, 1 = moves), unless all of it moves.
  const std::vector<char>& movingPoints() const { return moving_points_; }
  bool isMoving(Index point) const { return memory_.moves[tileOf(point)] != 0; }
  /// The largest motion lost so far, plus the motion of sleeping points beside moving ones in a quiet time, m.
  double lost() const { return memory_.lost + memory_.wall * quiet_time_ * quiet_time_; }
  void leaveAtWall(double acceleration) { memory_.wall = acceleration; }
  /// Makes the whole surface one tile, until a memory with more is set or a reset: its points change in number. All of it moves.
  void leaveParts();
  bool isInParts() const { return memory_.is_in_parts; }
  double spacing() const { return spacing_; }  // m
  /// From now on only the whole surface may sleep.
  void setOnlyWholly(bool only_wholly) { only_wholly_ = only_wholly; }
  bool isFresh() const { return memory_.is_fresh; }

  /// After a step of a state: counts quiet steps. Returns true if more tiles move than before.
  bool observe(const State& state);

  /// At intervals: true if enough tiles have been quiet for long enough for sleeping to pay.
  bool isLookDue();
  /// Tries to put quiet tiles to sleep, by the forces of the system on a state whose point k is points[k] (null: k).
  /// Points that fall asleep lose their velocity in `whole`. Returns true if fewer tiles move than before.
  bool fallAsleep(const solve::System& system, double time, const State& state, const std::vector<Index>* points, State& whole);
  /// Before the first step, or after a state was set: points at rest, without loads and in balance up to rounding sleep at once.
  bool beginAsleep(const solve::System& system, double time, State& whole);
  /// The whole surface sleeps from now on: a step has changed nothing.
  void sleepWholly(State& whole);

 private:
  void setParts(bool in_parts);
  Index numTiles() const { return static_cast<Index>(memory_.moves.size()); }
  Index tileOf(Index point) const { return tile_of_.empty() ? 0 : tile_of_[point]; }
  bool isQuiet(Index tile) const { return memory_.quiet[tile] >= quiet_steps_; }
  template <class Visit>
  void forEachPoint(Index tile, const State& state, Visit&& visit) const;
  void findNeeded(int rings);
  void addRing();
  void findLeaving(int rings);
  Index countPoints(const std::vector<char>& tiles) const;
  bool grow(int kept, int made);
  void count();
  bool moveOnlyNeeded(State& whole);
  bool isPushed(const solve::System& system, Index k, double force) const;
  double estimateLoss(const solve::System& system, double time, const std::vector<Index>* points);

  const model::DeformableModel& model_;
  // Constants.
  double tolerance_, quiet_time_, spacing_;
  std::int32_t quiet_steps_, look_steps_;
  Lists tiles_;                       // their points, ascending; empty if there is but one tile
  std::vector<Index> first_tile_of_;  // (n) at first; empty if there was but one

  std::vector<Index> tile_of_;  // (n); empty if there is but one

  Memory memory_;
  bool only_wholly_ = false;
  Index num_moving_ = 0, num_quiet_ = 0;  // moving tiles, and quiet ones among them
  std::vector<char> moving_points_;
  std::vector<Eigen::AlignedBox3d> boxes_;  // (tiles) of sleeping tiles
  // Scratch.
  std::vector<char> needed_, leaves_;        // (tiles)
  std::vector<char> marked_;                 // (n)
  std::vector<Index> ring_, needed_points_;  // tiles that are needed since the last ring, and their points
  State still_;
  Points forces_, forces_there_, torques_, way_, loads_;
  std::vector<double> rounding_;
};

}  // namespace deformable_surface::simulation
