#include "deformable_surface/simulation/grips.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

#include "renumber_points.h"

namespace deformable_surface::simulation {
namespace {

constexpr char kAnew[] =
    "on a running node a tool that is deleted and added again takes hold anew (a warm hand in RViz: Take hold)";

constexpr Index kLook = 1024;  // points between two checks for an interrupt
// Numbers of patches: 1 is that of the fixed points. Those of grips come in turn up to the largest char.
constexpr int kFirstPatch = 2, kLastPatch = 127;

constexpr double kCatchUp = 2.0;    // times the largest speed of the path
constexpr double kRounding = 1e-9;  // of the coordinates

// The largest speeds of a path, m/s and rad/s.
struct Fastest {
  double linear = 0.0, angular = 0.0;
};
Fastest findFastest(const std::vector<tool::WaypointParams>& path) {
  Fastest fastest;
  for (const tool::WaypointParams& w : path) {
    const tool::Motion motion = tool::findMotion(path, w.time);
    fastest.linear = std::max(fastest.linear, motion.velocity.norm());
    fastest.angular = std::max(fastest.angular, motion.angular_velocity.norm());
  }
  return fastest;
}

bool areEqual(const tool::Pose& a, const tool::Pose& b) {
  return (a.position - b.position).norm() <= kRounding * (a.position.norm() + b.position.norm()) &&
         1.0 - std::abs(a.orientation.dot(b.orientation)) <= kRounding;
}

void release(Grips::Grip& grip) {
  grip.points.clear();
  grip.places.clear();
  grip.edges.clear();
}

}  // namespace

void Grips::setTools(const std::vector<tool::ToolParams>& tools) {
  std::vector<Grip> grips;
  for (const tool::ToolParams& tool : tools) {
    if (tool.mode != tool::Mode::kMove) continue;
    Grip grip;
    const auto before =
        std::find_if(grips_.begin(), grips_.end(), [&](const Grip& g) { return !g.is_pin && g.tool.id == tool.id; });
    if (before != grips_.end() && before->tool.start == tool.start) grip = *before;
    grip.tool = tool;
    grips.push_back(std::move(grip));
  }
  for (Grip& grip : grips_)
    if (grip.is_pin) grips.push_back(std::move(grip));
  grips_ = std::move(grips);
}

void Grips::addPin(const std::string& id, const std::vector<tool::WaypointParams>& path, double time, std::vector<Index> points,
                   const model::State& state) {
  std::vector<char> kept(state.positions.size(), 1);
  for (const Index i : points) kept[i] = 0;
  keepOnPins(kept);
  Grip grip;
  grip.is_pin = grip.has_begun = true;
  grip.tool.mode = tool::Mode::kMove;
  grip.tool.id = id;
  grip.tool.path = path;
  const tool::Pose pose = tool::interpolate(path, time);
  for (const Index i : points) grip.places.push_back(pose.orientation.conjugate() * (state.positions[i] - pose.position));
  grip.points = std::move(points);
  grips_.push_back(std::move(grip));
}

void Grips::movePin(const std::string& id, const std::vector<tool::WaypointParams>& path) {
  for (Grip& grip : grips_)
    if (grip.is_pin && grip.tool.id == id) grip.tool.path = path;
}

const Grips::Grip* Grips::findPin(const std::string& id) const {
  for (const Grip& grip : grips_)
    if (grip.is_pin && grip.tool.id == id) return &grip;
  return nullptr;
}

void Grips::keepOnPins(const std::vector<char>& kept) {
  for (Grip& grip : grips_) {
    if (!grip.is_pin) continue;
    std::size_t count = 0;
    for (std::size_t k = 0; k < grip.points.size(); ++k) {
      if (!kept[grip.points[k]]) continue;
      grip.points[count] = grip.points[k];
      grip.places[count++] = grip.places[k];
    }
    grip.points.resize(count);
    grip.places.resize(count);
  }
  const auto isGone = [](const Grip& grip) { return grip.is_pin && grip.points.empty(); };
  grips_.erase(std::remove_if(grips_.begin(), grips_.end(), isGone), grips_.end());
}

void Grips::clearPins() {
  grips_.erase(std::remove_if(grips_.begin(), grips_.end(), [](const Grip& grip) { return grip.is_pin; }), grips_.end());
}

bool Grips::hasPins() const {
  return std::any_of(grips_.begin(), grips_.end(), [](const Grip& grip) { return grip.is_pin; });
}

bool Grips::isOnPin(Index point) const {
  return std::any_of(grips_.begin(), grips_.end(), [&](const Grip& grip) {
    return grip.is_pin && std::binary_search(grip.points.begin(), grip.points.end(), point);
  });
}

void Grips::findMovingPins(double from, double to, std::vector<Index>& moving) const {
  moving.clear();
  for (const Grip& grip : grips_) {
    if (!grip.is_pin) continue;
    const tool::Pose before = tool::interpolate(grip.tool.path, from), after = tool::interpolate(grip.tool.path, to);
    if (before.position == after.position && before.orientation.coeffs() == after.orientation.coeffs()) continue;
    moving.insert(moving.end(), grip.points.begin(), grip.points.end());
  }
}

bool Grips::readForces() const {
  return std::any_of(grips_.begin(), grips_.end(), [](const Grip& grip) { return grip.tool.strength > 0.0; });
}

void Grips::reset() {
  for (Grip& grip : grips_) {
    if (grip.is_pin) continue;
    grip.has_begun = false;
    release(grip);
  }
}

Grips::Update Grips::update(double time, double slack, const model::State& state, const std::vector<char>& pinned,
                            const Points& forces) {
  Update update;
  const auto letGo = [&](Grip& grip) {
    release(grip);
    update.changed = true;
  };
  for (Grip& grip : grips_) {
    if (grip.is_pin) continue;
    const bool active = tool::isActive(grip.tool, time + slack);
    if (!active && !grip.points.empty()) letGo(grip);
    if (active && !grip.has_begun) {
      grip.has_begun = true;
      const tool::Pose pose = tool::interpolate(grip.tool.path, time);
      for (Index i = 0; i < state.size(); ++i) {
        endIfInterrupted(i, kLook);
        if (pinned[i] || !(tool::findSignedDistance(grip.tool.shape, pose, state.positions[i], 0.0).distance <= 0.0)) continue;
        grip.points.push_back(i);
        grip.places.push_back(pose.orientation.conjugate() * (state.positions[i] - pose.position));
      }
      update.changed = true;
      update.begun.push_back(&grip - grips_.data());
      if (grip.points.empty())
        appendNotice(update.notice,
                     "tool " + quote(grip.tool.id) + " takes hold of nothing: no free point is inside it; " + kAnew);
    }
    if (!(grip.tool.strength > 0.0) || grip.points.empty()) continue;
    Vec3 force = Vec3::Zero();
    for (const Index i : grip.points) force += forces[i];
    if (force.norm() <= grip.tool.strength) continue;
    letGo(grip);
    appendNotice(update.notice, "tool " + quote(grip.tool.id) + " has lost its grip: it would have had to hold " +
                                    formatShort(force.norm()) + " N; " + kAnew);
  }
  return update;
}

void Grips::clamp(std::size_t index, double time, std::vector<model::ClampEdge> edges, const std::vector<Index>& riding,
                  const model::State& state) {
  Grip& grip = grips_[index];
  grip.edges = std::move(edges);
  const tool::Pose pose = tool::interpolate(grip.tool.path, time);
  for (const Index i : riding) {
    const auto at = std::lower_bound(grip.points.begin(), grip.points.end(), i);
    grip.places.insert(grip.places.begin() + (at - grip.points.begin()),
                       pose.orientation.conjugate() * (state.positions[i] - pose.position));
    grip.points.insert(at, i);
  }
}

void Grips::addPatches(std::vector<char>& patches, std::vector<model::ClampEdge>& edges) const {
  const std::size_t num_before = edges.size();
  int patch = kLastPatch;
  for (const Grip& grip : grips_) {
    if (grip.points.empty()) continue;
    patch = patch < kLastPatch ? patch + 1 : kFirstPatch;
    for (const Index i : grip.points) patches[i] = static_cast<char>(patch);
    edges.insert(edges.end(), grip.edges.begin(), grip.edges.end());
  }
  if (edges.size() == num_before) return;
  // For a point on two edges, the later one counts.
  const auto isBefore = [](const model::ClampEdge& a, const model::ClampEdge& b) { return a.point < b.point; };
  std::stable_sort(edges.begin(), edges.end(), isBefore);
}

void Grips::carry(double time, double step, bool at_once, model::State& state, std::vector<char>& held) {
  for (Grip& grip : grips_) {
    const tool::Pose before = tool::interpolate(grip.tool.path, time), pose = tool::interpolate(grip.tool.path, time + step);
    // Where the path does not go on from the last step, it has been given anew.
    const bool goes_on = grip.carried_to && areEqual(*grip.carried_to, before);
    std::optional<Fastest> fastest;
    for (std::size_t k = 0; k < grip.points.size(); ++k) {
      const Index i = grip.points[k];
      const Vec3 &place = grip.places[k], there = pose.position + pose.orientation * place;
      held[i] = 1;
      Vec3& velocity = state.velocities[i];
      velocity = (there - state.positions[i]) / step;
      if (at_once || !goes_on) continue;
      const Vec3 here = before.position + before.orientation * place;
      if ((state.positions[i] - here).norm() <= kRounding * here.norm()) continue;
      if (!fastest) fastest = findFastest(grip.tool.path);
      const double most = kCatchUp * (fastest->linear + fastest->angular * place.norm()), speed = velocity.norm();
      if (most > 0.0 && speed > most) velocity *= most / speed;
    }
    grip.carried_to = pose;
  }
}

void Grips::renumber(const std::vector<Index>& new_index) {
  for (Grip& grip : grips_) renumberPoints(new_index, grip.points, grip.places);
}

void Grips::addReactions(double time, const model::State& state, const Points& forces,
                         std::vector<ToolReaction>& reactions) const {
  for (const Grip& grip : grips_) {
    if (grip.is_pin) continue;
    const auto found =
        std::find_if(reactions.begin(), reactions.end(), [&](const ToolReaction& r) { return r.id == grip.tool.id; });
    if (found == reactions.end()) continue;
    const tool::Pose pose = tool::interpolate(grip.tool.path, time);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const Index i : grip.points) {
      force += forces[i];
      torque += (state.positions[i] - pose.position).cross(forces[i]);
    }
    found->force += pose.orientation.conjugate() * force;
    found->torque += pose.orientation.conjugate() * torque;
    found->contacts += static_cast<Index>(grip.points.size());
  }
}

}  // namespace deformable_surface::simulation
