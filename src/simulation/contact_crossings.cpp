// Continuous collision detection between solid tools and points, and when a recorded crossing ends. It runs once before and once
// after each step; contact forces act in every sub-step.
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tool_passage.h"
#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

using Moment = ContactLoad::Moment;
using tool::Entry;
using tool::Pose;
using tool::ToolParams;

constexpr double kBack = 0.01;             // of the depth of a passed point: a withdrawal that is as good as none
constexpr std::size_t kUsualMoments = 64;  // of a step, for which memory is taken at once
constexpr double kShallow = 0.1;  // of the way to a point that a flat face pushes: below the same face by more is too deep
constexpr double kFlat = 0.999;   // cosine between normals of a flat face
constexpr double kEven = 1e-3;    // of that way: by how much the face may be uneven
constexpr double kAcross = 0.5;   // cosine between the normals of a face and of one beside it
constexpr double kTurn = 0.2;     // rad between two samples of a turning tool: paths in its frame are then nearly straight

// Poses of a tool at moments of a step between which it moves straight and turns little.
void listMoments(const ToolParams& tool, double time, double step, std::vector<Moment>& moments) {
  moments.clear();
  moments.reserve(kUsualMoments);
  const auto add = [&](double at) { moments.push_back({(at - time) / step, tool::interpolate(tool.path, at)}); };
  double from = time;
  const auto goTo = [&](double corner) {
    const double turn = moments.back().pose.orientation.angularDistance(tool::interpolate(tool.path, corner).orientation);
    const int pieces = 1 + static_cast<int>(turn / kTurn);
    for (int k = 1; k < pieces; ++k) add(from + (corner - from) * k / pieces);
    add(corner);
    from = corner;
  };
  add(time);
  tool::forEachCorner(tool.path, time, time + step, goTo);
  goTo(time + step);
  moments.back() = {1.0, tool::interpolate(tool.path, time + step)};
}

// The first crossing of a point with constant velocity in the world.
std::optional<Entry> findCrossing(const ToolParams& tool, const std::vector<Moment>& moments, const Vec3& from, const Vec3& to) {
  Vec3 last = toTool(moments.front().pose, from);
  for (std::size_t k = 1; k < moments.size(); ++k) {
    const Vec3 next = toTool(moments[k].pose, from + moments[k].share * (to - from));
    if (const std::optional<Entry> entry = tool::findCrossing(tool.shape, last, next)) return entry;
    last = next;
  }
  return std::nullopt;
}

// m, about the tool's place at the beginning: points outside of this ball are not passed over, if none moves farther than
// `travel` (m). Their paths in the frame of a tool that turns are taken as straight between moments, which brings them nearer.
double findSweep(const ToolParams& tool, const std::vector<Moment>& moments, double travel) {
  double way = 0.0, turn = 0.0;
  for (std::size_t k = 1; k < moments.size(); ++k) {
    const Pose &pose = moments[k].pose, &before = moments[k - 1].pose;
    way = std::max(way, (pose.position - moments.front().pose.position).norm());
    turn = std::max(turn, before.orientation.angularDistance(pose.orientation));
  }
  if (!(turn < 1.0)) return std::numeric_limits<double>::infinity();
  return way + (findRadius(tool.shape) + way + travel) / (1.0 - turn);
}

// m, of all points.
double findTravel(const Points& from, const Points& to) {
  double squared = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) squared = std::max(squared, (to[i] - from[i]).squaredNorm());
  return std::sqrt(squared);
}

// A point that has been passed over, at a place of the world. The plane is where the solid alone would push as much.
ContactLoad::Passed findPassed(Index point, const Entry& entry, const ToolParams& tool, const Pose& pose, const Vec3& at,
                               double time) {
  const Vec3 place = toTool(pose, at);
  const double depth = std::max(0.0, -geometry::findSignedDistance(tool.shape, place).distance);
  return {point, entry, {std::max(0.0, -entry.heightOf(place) - depth), time}};
}

// Whether a point that came in by another face lies just below a flat face that already pushes a point near it. The surface then
// runs on below this face, and the tool alone is to push the point. A point is near if the tool is thicker than the way to it:
// thin tools remember by which face all points came in. In the tool's frame.
bool runsBelowFace(const geometry::Solid& shape, const Entry& entry, const Vec3& place, const std::vector<Entry>& pushed) {
  const geometry::SignedDistance now = geometry::findSignedDistance(shape, place);
  if (!(now.distance < 0.0) || std::abs(now.normal.dot(entry.normal)) > kAcross) return false;
  const double thickness = geometry::findSmallestExtent(shape);
  return std::any_of(pushed.begin(), pushed.end(), [&](const Entry& face) {
    const double way = (face.place - place).norm();
    return way < thickness && -now.distance < kShallow * way && now.normal.dot(face.normal) > kFlat &&
           std::abs(face.heightOf(place) - now.distance) < kEven * way;
  });
}

bool passes(const ContactLoad::Body& body) {
  return body.tool.mode == tool::Mode::kSolid && body.tool.shape.kind != geometry::Solid::Kind::kPlane && *body.acts;
}

}  // namespace

void ContactLoad::predict(double step, const model::State& state) {
  before_ = state.positions;
  boxes_before_.update(before_);
  ahead_.positions.resize(state.positions.size());
  for (Index i = 0; i < state.size(); ++i) ahead_.positions[i] = state.positions[i] + step * state.velocities[i];
  ahead_.escaped = state.escaped;
  if (points_.between() && points_.between()->hasPlaces()) boxes_ahead_.update(ahead_.positions);
}

bool ContactLoad::runsBelow(std::size_t b, double time, const model::State& state, const geometry::PointBoxes& boxes,
                            const tool::Entry& entry, const Vec3& place) {
  const Pose pose = tool::interpolate(bodies_[b].tool.path, time);
  if (!are_faces_known_) {
    listTouches(b, time, state, boxes, false, pressing_);
    faces_.clear();
    faces_.reserve(state.size());
    for (const Touch& touch : pressing_) {
      if (points_.isBetween(touch.point)) break;  // they have no memory of where they came in
      const Vec3 at = touch.position - touch.distance * touch.normal;
      faces_.push_back({toTool(pose, at), pose.orientation.conjugate() * touch.normal});
    }
    are_faces_known_ = true;
  }
  return runsBelowFace(bodies_[b].tool.shape, entry, place, faces_);
}

template <class Visit>
void ContactLoad::visitNear(const Vec3& centre, double radius, const std::vector<Passed>& passed, const Visit& visit) const {
  const Index n = static_cast<Index>(before_.size());
  auto next = passed.begin();
  for (Index begin = 0; begin < n; begin += geometry::PointBoxes::kRun) {
    endIfInterrupted();
    const Index end = std::min(n, begin + geometry::PointBoxes::kRun);
    const bool has_passed = next != passed.end() && next->point < end;
    if (!has_passed && !boxes_before_.mayMeet(begin / geometry::PointBoxes::kRun, centre, radius)) continue;
    for (Index i = begin; i < end; ++i) {
      const bool is_passed = next != passed.end() && next->point == i;
      visit(i, is_passed ? &*next++ : nullptr);
    }
  }
}

bool ContactLoad::beginStep(double time, double step, const model::State& state, const std::vector<char>& held) {
  forgetTouches();
  notice_.clear();
  has_new_arrival_ = has_new_detour_ = false;
  bool any = std::exchange(has_let_go_, false);
  if (bodies_.empty()) return any;
  predict(step, state);
  const double travel = findTravel(before_, ahead_.positions);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    const bool acts = tool::isActive(body.tool, time + kTimeRounding * step);
    any = any || body.acts != acts;
    body.acts = acts;
    if (!acts) body.arrival = {};
    if (acts && !body.arrival.is_known && body.tool.mode != tool::Mode::kAttract) {
      findArrival(time, step, state, held, body);
      has_new_arrival_ = true;
      has_new_detour_ = has_new_detour_ || !body.arrival.offset.isZero(0.0);
    }
    any = any || !body.passed.empty();
    if (!passes(body)) {
      body.passed.clear();
      body.through = {};
      continue;
    }
    listMoments(body.tool, time, step, moments_);
    const tool::Motion motion = tool::findMotion(body.tool.path, time);
    scratch_.clear();
    scratch_.reserve(state.size());
    are_faces_known_ = false;
    visitNear(
        moments_.front().pose.position, findSweep(body.tool, moments_, travel), body.passed, [&](Index i, const Passed* passed) {
          if (held[i]) return;
          if (passed) {
            const Entry& entry = passed->entry;
            const Vec3 place = toTool(moments_.front().pose, state.positions[i]);
            const geometry::SignedDistance now = geometry::findSignedDistance(body.tool.shape, place);
            const double depth = -entry.heightOf(place);
            const Withdrawal withdrawal = passed->withdrawal.goOn(time, depth, motion.velocityAt(state.positions[i]).norm());
            const bool is_back = withdrawal.at(time) <= kBack * depth;
            const bool is_blocked =
                !(is_back && tool::pushesBack(entry, now)) && tool::isHeldUp(body.tool.shape, entry, place, now);
            if (is_blocked && !runsBelow(b, time, state, boxes_before_, entry, place)) {
              scratch_.push_back({i, entry, withdrawal});
              return;
            }
          }
          const std::optional<Entry> entry = findCrossing(body.tool, moments_, state.positions[i], ahead_.positions[i]);
          const Vec3 ahead = toTool(moments_.back().pose, ahead_.positions[i]);
          if (entry && !runsBelow(b, time, state, boxes_before_, *entry, ahead))
            scratch_.push_back(findPassed(i, *entry, body.tool, moments_.front().pose, state.positions[i], time));
        });
    body.passed.swap(scratch_);
    any = any || !body.passed.empty();
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (!grows_ && (!bodies_[b].pressed.empty() || points_.between())) any = updateAlone(time, step, state, held, b) || any;
  forgetTouches();
  return any || has_new_detour_;
}

std::string ContactLoad::endStep(double time, double step, const model::State& state, const std::vector<char>& held,
                                 const Skin& skin) {
  std::string notice;
  gone_through_.clear();
  forgetTouches();
  if (bodies_.empty()) return notice;
  const double travel = findTravel(before_, state.positions);
  ahead_.positions = before_;  // points that came in within the step do not yet show which face pushes them
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (!passes(body)) continue;
    const bool had_passed = !body.passed.empty();
    listMoments(body.tool, time, step, moments_);
    const Pose &from = moments_.front().pose, &to = moments_.back().pose;
    const double sweep = findSweep(body.tool, moments_, travel);
    const bool is_far = body.passed.empty() && body.pressed.empty() && !body.through.isAny();
    if (is_far && !boxes_before_.mayMeet(from.position, sweep)) continue;
    scratch_.clear();
    scratch_.reserve(state.size());
    are_faces_known_ = false;
    visitNear(from.position, sweep, body.passed, [&](Index i, const Passed* passed) {
      if (passed) {
        if (!state.hasEscaped(static_cast<Index>(b), i)) scratch_.push_back(*passed);
      } else if (!held[i]) {
        const std::optional<Entry> entry = findCrossing(body.tool, moments_, before_[i], state.positions[i]);
        if (entry && !runsBelow(b, time, ahead_, boxes_before_, *entry, toTool(to, state.positions[i])))
          scratch_.push_back(findPassed(i, *entry, body.tool, to, state.positions[i], time + step));
      }
    });
    body.passed.swap(scratch_);

    const AxisPoints axis = listAxisPoints(body.tool.shape);
    AxisPoints axis_before = axis, axis_after = axis;
    for (std::size_t k = 0; k < axis.size(); ++k) {
      axis_before.places[k] = toWorld(from, axis[k]);
      axis_after.places[k] = toWorld(to, axis[k]);
    }
    const EdgePlaces edges = listEdgePlaces(body.tool.shape, skin.spacing);
    EdgePlaces edges_before = edges, edges_after = edges;
    for (std::size_t k = 0; k < edges.places.size(); ++k) {
      edges_before.places.places[k] = toWorld(from, edges.places[k]);
      edges_after.places.places[k] = toWorld(to, edges.places[k]);
    }
    edges_after.across = to.orientation * edges.across;
    const PassageStep passage_step{
        body.tool.shape, to,          axis_before,           axis_after,   skin.triangles, before_, state.positions,
        body.passed,     had_passed,  !body.pressed.empty(), skin.spacing, grows_,         time,    time + step,
        &edges_before,   &edges_after};
    const Passage passage = skin.is_body ? findPassageIntoBody(passage_step) : findPassage(passage_step, body.through);
    if (passage == Passage::kNone) continue;
    gone_through_ = body.tool.id;
    if (!skin.is_body && !body.passed.empty()) {
      body.passed.clear();  // the rest of the surface is on the other side
      has_let_go_ = true;
    }
    if (std::find(reported_.begin(), reported_.end(), body.tool.id) != reported_.end()) continue;
    appendNotice(notice, "tool " + quote(body.tool.id) + " has passed through the surface" + describe(passage, skin.spacing));
    reported_.push_back(body.tool.id);
  }
  return notice;
}

void ContactLoad::reset() {
  for (Body& body : bodies_) {
    body.passed.clear();
    body.pressed.clear();
    body.through = {};
  }
  forgetTouches();
  reported_.clear();
}

void ContactLoad::takePart(const ContactLoad& whole, const std::vector<Index>& new_index) {
  bodies_ = whole.bodies_;
  points_.takePart(whole.points_, new_index);
  renumber(new_index);
  setRate(whole.rate_);
  setStiffening(whole.stiffening_);
  compliance_ = whole.compliance_;
}

void ContactLoad::renumber(const std::vector<Index>& new_index) {
  forgetTouches();
  for (Body& body : bodies_) {
    std::size_t kept = 0;
    for (const Passed& passed : body.passed)
      if (new_index[passed.point] >= 0) body.passed[kept++] = {new_index[passed.point], passed.entry, passed.withdrawal};
    body.passed.resize(kept);
    std::sort(body.passed.begin(), body.passed.end(), [](const Passed& a, const Passed& b) { return a.point < b.point; });
    const std::vector<Index>& new_number = points_.between() ? points_.numberInPart() : new_index;
    kept = 0;
    for (const Pressed& pressed : body.pressed)
      if (new_number[pressed.point] >= 0) body.pressed[kept++] = {new_number[pressed.point], pressed.growth, pressed.withdrawal};
    body.pressed.resize(kept);
    std::sort(body.pressed.begin(), body.pressed.end(), [](const Pressed& a, const Pressed& b) { return a.point < b.point; });
  }
}

}  // namespace deformable_surface::simulation
