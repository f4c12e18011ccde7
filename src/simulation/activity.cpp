#include "activity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace deformable_surface::simulation {
namespace {

constexpr double kCaution = 3.0;     // of estimates of a way by its largest speed and force; measured in docs/sleep.md
constexpr double kTolerance = 1e-4;  // of the spacing: far below the error that the spacing itself causes
constexpr Index kTilePoints = 16;    // four by four: little more than a poke moves, and few enough lists
constexpr int kLooks = 8;            // in a quiet time: a look costs two evaluations of the forces
constexpr double kWorth = 0.25;      // of the moving points: smaller groups wait for others, since a new part costs time
constexpr double kWhole = 0.7;       // of all points: if more move, all do, since a part has its walls beside
constexpr double kRounding = 8.0;    // of the force that is rounding in one sum: forces are sums of sums
constexpr int kMargin = 1;           // rings of awake tiles around those that move
constexpr int kMostMargin = 3;       // largest such margin ahead of a front: more costs more than making parts less often saves

// Halves along the longest axis until few enough are left. Ties by index.
void split(const Points& points, std::vector<Index>::iterator begin, std::vector<Index>::iterator end, Lists& tiles) {
  if (end - begin <= kTilePoints) {
    std::sort(begin, end);
    tiles.items.insert(tiles.items.end(), begin, end);
    tiles.offsets.push_back(static_cast<Index>(tiles.items.size()));
    return;
  }
  Eigen::AlignedBox3d box;
  for (auto i = begin; i != end; ++i) box.extend(points[*i]);
  Eigen::Index axis;
  box.sizes().maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](Index a, Index b) {
    return points[a][axis] != points[b][axis] ? points[a][axis] < points[b][axis] : a < b;
  });
  split(points, begin, middle, tiles);
  split(points, middle, end, tiles);
}

}  // namespace

Activity::Activity(const SleepParams& params, const Points& points, double spacing, double step,
                   const model::DeformableModel& model, bool in_parts)
    : model_(model),
      tolerance_(params.tolerance.valueOr(kTolerance * spacing)),
      quiet_time_(params.quiet_time),
      spacing_(spacing),
      quiet_steps_(static_cast<std::int32_t>(std::min(1e9, std::ceil(quiet_time_ / step)))),
      look_steps_(std::max<std::int32_t>(1, quiet_steps_ / kLooks)) {
  std::vector<char> none(points.size(), 0);
  if (in_parts && model.partition() && model.partition()->markPartners({}, none)) {
    std::vector<Index> all(points.size());
    std::iota(all.begin(), all.end(), 0);
    split(points, all.begin(), all.end(), tiles_);
    first_tile_of_.resize(points.size());
    for (Index t = 0; t < tiles_.size(); ++t)
      for (const Index* i = tiles_.begin(t); i != tiles_.end(t); ++i) first_tile_of_[*i] = t;
  }
  reset();
}

void Activity::setParts(bool in_parts) {
  memory_.is_in_parts = in_parts && !first_tile_of_.empty();
  if (memory_.is_in_parts) {
    tile_of_ = first_tile_of_;
  } else {
    tile_of_.clear();
  }
  const Index num_tiles = tile_of_.empty() ? 1 : tiles_.size();
  memory_.quiet.resize(num_tiles);
  memory_.moves.resize(num_tiles);
  boxes_.resize(num_tiles);
  needed_.resize(num_tiles);
  leaves_.resize(num_tiles);
  moving_points_.resize(tile_of_.size());
  marked_.resize(tile_of_.size());
  needed_points_.reserve(tile_of_.size());
  ring_.reserve(num_tiles);
}

void Activity::leaveParts() {
  setParts(false);
  wakeAll();
}

double Activity::acceleration() const { return 2.0 / kCaution * tolerance_ / (quiet_time_ * quiet_time_); }

// Ends early if visit returns false.
template <class Visit>
void Activity::forEachPoint(Index tile, const State& state, Visit&& visit) const {
  if (tile_of_.empty()) {
    for (Index i = 0; i < state.size(); ++i)
      if (!visit(i)) return;
  } else {
    for (const Index* i = tiles_.begin(tile); i != tiles_.end(tile); ++i)
      if (!visit(*i)) return;
  }
}

void Activity::reset() {
  setParts(true);
  std::fill(memory_.quiet.begin(), memory_.quiet.end(), 0);
  std::fill(memory_.moves.begin(), memory_.moves.end(), 1);
  memory_.lost = memory_.wall = 0.0;
  memory_.is_fresh = true;
  memory_.looks_in = look_steps_;
  memory_.margin = kMargin;
  memory_.has_grown = false;
  count();
}

void Activity::setMemory(const Memory& memory, const State& state) {
  setParts(memory.is_in_parts);
  memory_ = memory;
  for (Index t = 0; t < numTiles(); ++t) {
    boxes_[t].setEmpty();
    forEachPoint(t, state, [&](Index i) {
      boxes_[t].extend(state.positions[i]);
      return true;
    });
  }
  count();
}

void Activity::count() {
  num_moving_ = static_cast<Index>(std::count(memory_.moves.begin(), memory_.moves.end(), 1));
  for (std::size_t i = 0; i < moving_points_.size(); ++i) moving_points_[i] = memory_.moves[tile_of_[i]];
}

void Activity::wakeAll() {
  std::fill(memory_.quiet.begin(), memory_.quiet.end(), 0);
  std::fill(memory_.moves.begin(), memory_.moves.end(), 1);
  memory_.wall = 0.0;
  count();
}

void Activity::wake(const std::vector<Index>& points) {
  if (points.empty()) return;
  for (const Index i : points) memory_.quiet[tileOf(i)] = 0;
  grow(kMargin, kMargin);
}

void Activity::widen(const std::vector<Index>& points) {
  for (const Index i : points) memory_.quiet[tileOf(i)] = 0;
  memory_.margin = std::min(memory_.margin + 1, kMostMargin);
  grow(kMargin, memory_.margin);
}

void Activity::wakeIn(const Eigen::AlignedBox3d& given) {
  const Vec3 margin = Vec3::Constant(spacing_);
  const Eigen::AlignedBox3d box(given.min() - margin, given.max() + margin);
  bool any = false;
  for (Index t = 0; t < numTiles(); ++t) {
    if (memory_.moves[t] || !box.intersects(boxes_[t])) continue;
    memory_.quiet[t] = 0;
    any = true;
  }
  if (any) grow(kMargin, kMargin);
}

// Tiles that are not quiet, including disturbed sleepers, and the tiles that share elements with them, `rings` times over.
void Activity::findNeeded(int rings) {
  for (Index t = 0; t < numTiles(); ++t) needed_[t] = !isQuiet(t);
  if (tile_of_.empty()) return;
  if (only_wholly_ && std::count(needed_.begin(), needed_.end(), 1) > 0) std::fill(needed_.begin(), needed_.end(), 1);
  ring_.clear();
  for (Index t = 0; t < numTiles(); ++t)
    if (needed_[t]) ring_.push_back(t);
  for (int ring = 0; ring < rings; ++ring) addRing();
}

// Only partners of the tiles added last can be new.
void Activity::addRing() {
  needed_points_.clear();
  for (const Index t : ring_) needed_points_.insert(needed_points_.end(), tiles_.begin(t), tiles_.end(t));
  std::fill(marked_.begin(), marked_.end(), 0);
  model_.partition()->markPartners(needed_points_, marked_);
  ring_.clear();
  for (std::size_t i = 0; i < marked_.size(); ++i) {
    if (!marked_[i] || needed_[tile_of_[i]]) continue;
    needed_[tile_of_[i]] = 1;
    ring_.push_back(tile_of_[i]);
  }
}

void Activity::findLeaving(int rings) {
  findNeeded(rings);
  for (Index t = 0; t < numTiles(); ++t) leaves_[t] = memory_.moves[t] && !needed_[t];
}

Index Activity::countPoints(const std::vector<char>& tiles) const {
  if (tile_of_.empty()) return tiles[0];
  Index sum = 0;
  for (Index t = 0; t < numTiles(); ++t)
    if (tiles[t]) sum += tiles_.count(t);
  return sum;
}

// If fewer than `kept` rings move, makes `made` of them move. Returns true if more tiles move.
bool Activity::grow(int kept, int made) {
  if (isWhole()) return false;
  findNeeded(kept);
  bool is_covered = true;
  for (Index t = 0; t < numTiles(); ++t) is_covered = is_covered && (!needed_[t] || memory_.moves[t]);
  if (is_covered) return false;
  for (int ring = kept; ring < made && !tile_of_.empty(); ++ring) addRing();
  const Index before = num_moving_;
  for (Index t = 0; t < numTiles(); ++t) memory_.moves[t] = memory_.moves[t] || needed_[t];
  if (countPoints(memory_.moves) > kWhole * moving_points_.size()) std::fill(memory_.moves.begin(), memory_.moves.end(), 1);
  count();
  memory_.has_grown = true;
  return num_moving_ > before;
}

bool Activity::observe(const State& state) {
  const double squared = speed() * speed(), squared_spin = squared / (spacing_ * spacing_);
  bool is_front = false;
  num_quiet_ = 0;
  for (Index t = 0; t < numTiles(); ++t) {
    if (!memory_.moves[t]) continue;
    bool slow = true;
    forEachPoint(t, state, [&](Index i) {
      slow =
          state.velocities[i].squaredNorm() <= squared && (state.spins.empty() || state.spins[i].squaredNorm() <= squared_spin);
      return slow;
    });
    is_front = is_front || (!slow && isQuiet(t));
    memory_.quiet[t] = slow ? std::min(memory_.quiet[t] + 1, quiet_steps_) : 0;
    num_quiet_ += isQuiet(t);
  }
  return is_front && grow(memory_.margin, memory_.margin + 1);
}

bool Activity::isLookDue() {
  if (--memory_.looks_in > 0) return false;
  memory_.looks_in = look_steps_;
  // A front that has come to rest needs no room.
  if (!memory_.has_grown) memory_.margin = std::max(memory_.margin - 1, kMargin);
  memory_.has_grown = false;
  return num_quiet_ > 0;
}

// Whether a force, N, accelerates a point of the system more than the tolerance allows.
bool Activity::isPushed(const solve::System& system, Index k, double force) const {
  return !system.isHeld(k) && !(force <= acceleration() * system.masses()[k]);
}

bool Activity::fallAsleep(const solve::System& system, double time, const State& state, const std::vector<Index>* points,
                          State& whole) {
  const auto tileAt = [&](Index k) { return tileOf(points ? (*points)[k] : k); };
  for (Index t = 0; t < numTiles(); ++t) leaves_[t] = memory_.moves[t] && isQuiet(t);
  if (countPoints(leaves_) < kWorth * countPoints(memory_.moves)) return false;  // costs nothing while almost nothing is quiet
  findLeaving(memory_.margin);
  if (countPoints(leaves_) < kWorth * countPoints(memory_.moves)) return false;

  // The same state at rest.
  still_ = state;
  for (Index k = 0; k < still_.size(); ++k) {
    if (!leaves_[tileAt(k)]) continue;
    still_.velocities[k].setZero();
    if (!still_.spins.empty()) still_.spins[k].setZero();
  }
  if (system.isOriented()) {
    system.computeForcesAndTorques(time, still_, forces_, torques_);
  } else {
    system.computeForcesOnAll(time, still_, forces_);
  }
  for (Index k = 0; k < still_.size(); ++k) {
    if (!leaves_[tileAt(k)]) continue;
    bool pushed = isPushed(system, k, forces_[k].norm());
    if (system.isOriented() && !system.isTurnHeld(k))
      pushed = pushed || !(spacing_ * torques_[k].norm() <= acceleration() * system.inertias()[k]);
    if (pushed) memory_.quiet[tileAt(k)] = 0;
  }
  findLeaving(memory_.margin);
  if (countPoints(leaves_) < kWorth * countPoints(memory_.moves)) return false;
  for (Index k = 0; k < still_.size(); ++k) still_.velocities[k] = leaves_[tileAt(k)] ? state.velocities[k] : Vec3::Zero();
  const double loss = estimateLoss(system, time, points);
  if (!(loss <= tolerance_)) return false;
  memory_.lost = std::max(memory_.lost, loss);
  return moveOnlyNeeded(whole);
}

// Distance from here to where the leaving points would settle: with the acceleration r of a point at rest, its velocity v, and
// the frequency w of its motion, v / w + r / w^2. w^2 is Rayleigh's quotient of the path d = T v + T^2 r / 2 that they would take
// at first, from the change of forces along it. Infinite without a restoring force. still_: with velocities; forces_: at rest.
double Activity::estimateLoss(const solve::System& system, double time, const std::vector<Index>* points) {
  const Index n = still_.size();
  const std::vector<double>& masses = system.masses();
  const auto isLeaving = [&](Index k) { return leaves_[tileOf(points ? (*points)[k] : k)] && !system.isHeld(k); };
  way_.assign(n, Vec3::Zero());
  double speed = 0.0, pushed = 0.0, longest = 0.0;
  for (Index k = 0; k < n; ++k) {
    if (!isLeaving(k)) continue;
    const Vec3 acceleration = forces_[k] / masses[k];
    way_[k] = quiet_time_ * still_.velocities[k] + 0.5 * quiet_time_ * quiet_time_ * acceleration;
    speed = std::max(speed, still_.velocities[k].norm());
    pushed = std::max(pushed, acceleration.norm());
    longest = std::max(longest, way_[k].norm());
  }
  if (!(longest > 0.0)) return 0.0;
  double inertia = 0.0, stiffness = 0.0;
  const double scale = tolerance_ / longest;
  for (Index k = 0; k < n; ++k) {
    way_[k] *= scale;
    inertia += masses[k] * way_[k].squaredNorm();
    stiffness += way_[k].dot(forces_[k]);
    still_.positions[k] += way_[k];
    still_.velocities[k].setZero();
  }
  system.computeForcesOnAll(time, still_, forces_there_);
  for (Index k = 0; k < n; ++k) stiffness -= way_[k].dot(forces_there_[k]);
  if (!(stiffness > 0.0)) return std::numeric_limits<double>::infinity();
  const double squared_frequency = stiffness / inertia;
  return kCaution * (speed / std::sqrt(squared_frequency) + pushed / squared_frequency);
}

// Returns true if fewer tiles move than before.
bool Activity::moveOnlyNeeded(State& whole) {
  const Index before = num_moving_;
  for (Index t = 0; t < numTiles(); ++t) {
    if (!memory_.moves[t] || needed_[t]) continue;
    memory_.moves[t] = 0;
    boxes_[t].setEmpty();
    forEachPoint(t, whole, [&](Index i) {
      whole.velocities[i].setZero();
      if (!whole.spins.empty()) whole.spins[i].setZero();
      boxes_[t].extend(whole.positions[i]);
      return true;
    });
  }
  count();
  return num_moving_ < before;
}

bool Activity::beginAsleep(const solve::System& system, double time, State& whole) {
  memory_.is_fresh = false;
  still_ = whole;  // which looks need without allocating
  forces_there_ = way_ = whole.positions;
  const auto rests = [&](Index i) {
    return whole.velocities[i].isZero(0.0) && (whole.spins.empty() || whole.spins[i].isZero(0.0));
  };
  if (system.isOriented()) {
    system.computeForcesAndTorques(time, whole, forces_, torques_);
  } else {
    system.computeForcesOnAll(time, whole, forces_);
  }
  system.computeRounding(time, whole, rounding_);
  loads_.assign(whole.size(), Vec3::Zero());
  system.addLoadsOnAll(time, whole, loads_);
  for (Index t = 0; t < numTiles(); ++t) {
    bool balanced = true;
    forEachPoint(t, whole, [&](Index i) {
      const double rounding = kRounding * rounding_[i];
      balanced = rests(i) && (system.isHeld(i) || (loads_[i].isZero(0.0) && forces_[i].norm() <= rounding));
      if (balanced && system.isOriented()) balanced = system.isTurnHeld(i) || torques_[i].norm() <= rounding * spacing_;
      return balanced;
    });
    memory_.quiet[t] = balanced ? quiet_steps_ : 0;
  }
  findLeaving(memory_.margin);
  const bool pays = countPoints(leaves_) >= kWorth * countPoints(memory_.moves);
  const bool any = pays && moveOnlyNeeded(whole);
  // Moving tiles may not go to sleep because they were in balance before they were pushed.
  for (Index t = 0; !any && t < numTiles(); ++t) memory_.quiet[t] = 0;
  return any;
}

void Activity::sleepWholly(State& whole) {
  std::fill(memory_.quiet.begin(), memory_.quiet.end(), quiet_steps_);
  std::fill(needed_.begin(), needed_.end(), 0);
  moveOnlyNeeded(whole);
}

}  // namespace deformable_surface::simulation
