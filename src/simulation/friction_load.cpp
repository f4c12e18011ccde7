#include "deformable_surface/simulation/friction_load.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/simulation/contact_damping.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::simulation {
namespace {

using contact::BodyAnchor;

std::uint64_t keyOf(const std::string& id) {
  std::uint64_t hash = kHashBegin;
  for (const char c : id) hash = mixHash(hash, static_cast<unsigned char>(c));
  return hash;
}

using Anchors = std::vector<BodyAnchor>;

// The first anchor that is not before a point of a body.
Anchors::const_iterator findFrom(const Anchors& anchors, std::uint64_t body, Index point) {
  return std::lower_bound(anchors.begin(), anchors.end(), point,
                          [&](const BodyAnchor& a, Index p) { return a.isBefore(body, p); });
}

// The anchor at an iterator, if it is that of the point.
const BodyAnchor* match(const Anchors& anchors, Anchors::const_iterator at, std::uint64_t body, Index point) {
  return at != anchors.end() && at->body == body && at->point == point ? &*at : nullptr;
}

Vec3 alongSurface(const Vec3& v, const Vec3& normal) { return v - v.dot(normal) * normal; }

}  // namespace

FrictionLoad::Rubbing FrictionLoad::beginRubbing(const tool::ToolParams& tool, double time) const {
  return {keyOf(tool.id), tool.friction, tool.kinetic_friction.valueOr(tool.friction), tool::interpolate(tool.path, time),
          tool::findMotion(tool.path, time)};
}

FrictionLoad::Rub FrictionLoad::findRub(const Rubbing& body, const BodyAnchor* anchor, const ContactLoad::Touch& touch) const {
  const double rate = contact_.rate(), pressing = touch.force.norm(), full = contact_.points().massOf(touch.point) * rate * rate;
  const double spring = touch.softness < 1.0 ? std::min(full, touch.stiffness) : full;
  const Vec3 moved = anchor ? Vec3(touch.position - body.pose.position - body.pose.orientation * anchor->place) : Vec3::Zero();
  return {{body.static_coefficient * pressing, body.kinetic_coefficient * pressing, spring,
           2.0 * ContactDamping::kShare * std::sqrt(spring / full) * contact_.points().dampedMassOf(touch.point) * rate},
          alongSurface(moved, touch.normal),
          anchor != nullptr,
          anchor ? anchor->slid : 0.0};
}

Vec3 FrictionLoad::findSliding(const Rubbing& body, const model::State& state, const ContactLoad::Touch& touch) const {
  return alongSurface(contact_.points().findVelocity(touch.point, state.velocities) - body.motion.velocityAt(touch.position),
                      touch.normal);
}

Vec3 FrictionLoad::findForce(std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) const {
  const tool::ToolParams& tool = contact_.all()[body].tool;
  if (!tool::hasFriction(tool)) return Vec3::Zero();
  const Rubbing rubbing = beginRubbing(tool, time);
  const auto at = findFrom(state.friction, rubbing.key, touch.point);
  return findForce(rubbing, state, touch, findRub(rubbing, match(state.friction, at, rubbing.key, touch.point), touch));
}

// The touches of a body are ascending, as are the anchors.
template <typename Visit>
void FrictionLoad::forEachRub(double time, const model::State& state, const Visit& visit) const {
  const Anchors& anchors = state.friction;
  auto at = anchors.end();
  const auto begin = [&](const tool::ToolParams& tool) {
    const Rubbing body = beginRubbing(tool, time);
    at = findFrom(anchors, body.key, 0);
    return body;
  };
  const bool is_known = isKnown(time, state);
  auto known = rubs_.begin();
  contact_.forEachRubbingTouch(time, state, begin, [&](const Rubbing& body, const ContactLoad::Touch& touch) {
    if (is_known) {
      visit(body, touch, *known++);
      return;
    }
    while (at != anchors.end() && at->isBefore(body.key, touch.point)) ++at;
    visit(body, touch, findRub(body, match(anchors, at, body.key, touch.point), touch));
  });
}

void FrictionLoad::addForces(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  forEachRub(time, state, [&](const Rubbing& body, const ContactLoad::Touch& touch, const Rub& rub) {
    contact_.points().addForce(touch.point, state.positions, findForce(body, state, touch, rub), forces);
  });
  contact_.addSeconds(timer.seconds());
}

void FrictionLoad::addForcesAtRest(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  known_positions_ = nullptr;
  rubs_.clear();
  rubs_.reserve(contact_.all().size() * contact_.points().size());
  forEachRub(time, state, [&](const Rubbing&, const ContactLoad::Touch& touch, const Rub& rub) {
    rubs_.push_back(rub);
    if (rub.has_spring)
      contact_.points().addForce(touch.point, state.positions, rub.law.findForce(rub.stretch, Vec3::Zero(), rub.slid), forces);
  });
  known_positions_ = state.positions.data();
  known_friction_ = state.friction.data();
  known_time_ = time;
  contact_.addSeconds(timer.seconds());
}

double FrictionLoad::energy(double time, const model::State& state) const {
  double sum = 0.0;
  forEachRub(time, state,
             [&](const Rubbing&, const ContactLoad::Touch&, const Rub& rub) { sum += rub.law.storedEnergy(rub.stretch); });
  return sum;
}

double FrictionLoad::estimateWork(double from, double to, const model::State& before, const model::State& after) const {
  double work = std::max(0.0, energy(from, before) - energy(to, after));
  const auto begin = [&](const tool::ToolParams& tool) { return std::pair(tool.friction, tool::findMotion(tool.path, from)); };
  contact_.forEachRubbingTouch(to, after, begin, [&](const auto& body, const ContactLoad::Touch& touch) {
    work += body.first * touch.force.norm() * (to - from) * body.second.velocityAt(touch.position).norm();
  });
  return work;
}

double FrictionLoad::drivingPower(double time, double, const model::State& state) const {
  double power = 0.0;
  forEachRub(time, state, [&](const Rubbing& body, const ContactLoad::Touch& touch, const Rub& rub) {
    power += findForce(body, state, touch, rub).dot(body.motion.velocityAt(touch.position));
  });
  return power;
}

void FrictionLoad::addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const {
  if (!(step > 0.0)) return;
  forEachRub(time, state, [&](const Rubbing& body, const ContactLoad::Touch& touch, const Rub& rub) {
    const double spring = rub.has_spring ? rub.law.stiffness : 0.0;
    const double share = rub.law.findShare(rub.stretch, findSliding(body, state, touch), rub.slid);
    contact_.points().addStiffness(
        touch.point, share * (spring + rub.law.damping / step) * (Mat3::Identity() - touch.normal * touch.normal.transpose()),
        stiffness);
  });
}

void FrictionLoad::addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                                std::vector<double>&) const {
  if (isEmpty()) return;
  const double per_mass = contact_.rate() * contact_.rate();
  contact_.forEachNearDamped(time, state, [&](Index i) { stiffness[i] += per_mass * contact_.points().massOf(i); });
}

void FrictionLoad::remember(double time, double step, model::State& state) const {
  next_.clear();
  next_.reserve(contact_.all().size() * contact_.points().size());
  forEachRub(time, state, [&](const Rubbing& body, const ContactLoad::Touch& touch, const Rub& rub) {
    Vec3 stretch = rub.stretch;
    const double slid = rub.law.slide(stretch, findSliding(body, state, touch), rub.slid, rub.has_spring ? step : 0.0);
    const Vec3 place = body.pose.orientation.conjugate() * (touch.position - stretch - body.pose.position);
    next_.push_back({body.key, touch.point, place, slid});
  });
  // Those of one tool are in order already.
  const auto isBefore = [](const BodyAnchor& a, const BodyAnchor& b) { return a.isBefore(b.body, b.point); };
  if (!std::is_sorted(next_.begin(), next_.end(), isBefore)) std::sort(next_.begin(), next_.end(), isBefore);
  state.friction = next_;
  known_positions_ = nullptr;
}

void renumberFriction(const std::vector<Index>& new_index, std::vector<BodyAnchor>& friction) {
  for (BodyAnchor& anchor : friction) anchor.point = new_index[anchor.point];
  friction.erase(std::remove_if(friction.begin(), friction.end(), [](const BodyAnchor& a) { return a.point < 0; }),
                 friction.end());
  std::sort(friction.begin(), friction.end(),
            [](const BodyAnchor& a, const BodyAnchor& b) { return a.isBefore(b.body, b.point); });
}

}  // namespace deformable_surface::simulation
