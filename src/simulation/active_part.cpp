#include "active_part.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {

ActivePart::Made ActivePart::make(const model::DeformableModel& whole, const std::vector<char>& moving) {
  Made made;
  made.moving = moving;
  const Index n = static_cast<Index>(moving.size());
  std::vector<Index> movers, wall;
  for (Index i = 0; i < n; ++i)
    if (moving[i]) movers.push_back(i);
  std::vector<char> wanted = moving, beside(moving.size(), 0);
  const model::Partition& partition = *whole.partition();
  partition.markPartners(movers, wanted);
  for (Index i = 0; i < n; ++i)
    if (wanted[i] && !moving[i]) wall.push_back(i);
  partition.markPartners(wall, beside);
  made.part = partition.makePart(wanted);
  for (const Index i : made.part.points)
    made.kind.push_back(moving[i] ? (beside[i] ? Kind::kRim : Kind::kMoving) : (wanted[i] ? Kind::kWall : Kind::kBehind));
  return made;
}

ActivePart::ActivePart(const model::DeformableModel& whole, const std::vector<char>& moving, const SceneParams& params,
                       const LoadSet& loads, double damping)
    : ActivePart(make(whole, moving), params, loads, damping) {}

ActivePart::ActivePart(Made made, const SceneParams& params, const LoadSet& loads, double damping)
    : moving_(std::move(made.moving)),
      model_(std::move(made.part.model)),
      points_(std::move(made.part.points)),
      new_index_(moving_.size(), -1),
      kind_(std::move(made.kind)),
      loads_(*model_, params),
      held_(points_.size(), 1),
      held_turns_(points_.size(), 1),
      fixed_(points_.size(), 0),
      system_(*model_, loads_.acting(), held_, damping, &held_turns_),
      march_(system_, *model_, params.integrator) {
  for (std::size_t k = 0; k < points_.size(); ++k) new_index_[points_[k]] = static_cast<Index>(k);
  state_.positions.resize(points_.size());
  state_.velocities.resize(points_.size());
  if (isOriented(*model_)) {
    state_.orientations.resize(points_.size());
    state_.spins.resize(points_.size());
    state_.traits.resize(points_.size());
  }
  setLoads(loads);
}

void ActivePart::setLoads(const LoadSet& loads) {
  loads_.takePart(loads, new_index_);
  march_.loadsChanged();
}

void ActivePart::limitMotion(contact::SelfContact& contact) {
  limit_ = std::make_unique<PartMotionLimit>(contact, points_, static_cast<Index>(moving_.size()));
  system_.setMotionLimit(limit_.get());
}

void ActivePart::watchBreaking(const solve::Breaking* breaking) {
  stretch_watch_.breaking = breaking;
  stretch_watch_.model = model_.get();
  system_.setBreaking(breaking ? &stretch_watch_ : nullptr);
}

solve::TimeMarch::Outcome ActivePart::step(double time, const State& state, const std::vector<char>& held,
                                           const std::vector<char>& held_turns) {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Index i = points_[k];
    const bool moves = isMoving(static_cast<Index>(k));
    state_.positions[k] = state.positions[i];
    state_.velocities[k] = moves ? state.velocities[i] : Vec3::Zero();
    fixed_[k] = held[i];
    held_[k] = !moves || held[i];
    if (!isOriented(*model_)) continue;
    state_.orientations[k] = state.orientations[i];
    state_.spins[k] = moves ? state.spins[i] : Vec3::Zero();
    state_.traits[k] = state.traits[i];
    held_turns_[k] = !moves || held_turns[i];
  }
  stretch_watch_.has_stretched = false;
  state_.escaped.clear();
  state_.escaped.reserve(loads_.contact.isEmpty() ? 0 : points_.size());
  state_.friction.clear();
  for (contact::BodyAnchor anchor : state.friction) {
    anchor.point = loads_.contact.points().numberInPart()[anchor.point];
    if (anchor.point >= 0) state_.friction.push_back(anchor);
  }
  std::sort(state_.friction.begin(), state_.friction.end(),
            [](const contact::BodyAnchor& a, const contact::BodyAnchor& b) { return a.isBefore(b.body, b.point); });
  return march_.step(time, state_);
}

void ActivePart::put(State& state) const {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (!isMoving(static_cast<Index>(k))) continue;
    state.positions[points_[k]] = state_.positions[k];
    state.velocities[points_[k]] = state_.velocities[k];
    if (!isOriented(*model_)) continue;
    state.orientations[points_[k]] = state_.orientations[k];
    state.spins[points_[k]] = state_.spins[k];
  }
  putFriction(state.friction);
  for (const auto& [tool, point] : state_.escaped)
    state.escaped.emplace_back(tool, loads_.contact.points().numberInWhole()[point]);
  std::sort(state.escaped.begin(), state.escaped.end());
}

// Anchors of sleeping points stay.
void ActivePart::putFriction(std::vector<contact::BodyAnchor>& friction) const {
  if (friction.empty() && state_.friction.empty()) return;
  const ContactPoints& points = loads_.contact.points();
  const auto moves = [&](Index p) { return p >= 0 && isMoving(points.simulationPointOf(p)); };
  const auto movesHere = [&](const contact::BodyAnchor& a) { return moves(points.numberInPart()[a.point]); };
  friction.erase(std::remove_if(friction.begin(), friction.end(), movesHere), friction.end());
  for (contact::BodyAnchor anchor : state_.friction) {
    if (!moves(anchor.point)) continue;
    anchor.point = points.numberInWhole()[anchor.point];
    friction.push_back(anchor);
  }
  std::sort(friction.begin(), friction.end(),
            [](const contact::BodyAnchor& a, const contact::BodyAnchor& b) { return a.isBefore(b.body, b.point); });
}

bool ActivePart::hasMoved(const Points& since, double distance) const {
  for (std::size_t k = 0; k < points_.size(); ++k)
    if (isMoving(static_cast<Index>(k)) && !((state_.positions[k] - since[points_[k]]).squaredNorm() <= distance * distance))
      return true;
  return false;
}

double ActivePart::findHits(double time, double acceleration, double speed, double spacing, std::vector<Index>& hits) {
  hits.clear();
  const bool is_oriented = isOriented(*model_);
  if (is_oriented) {
    system_.computeForcesAndTorquesOnAll(time, state_, forces_on_all_, torques_on_all_);
  } else {
    march_.computeForcesOnAll(time, state_, forces_on_all_);
  }
  const auto isFast = [&](std::size_t k) {
    if (!(state_.velocities[k].squaredNorm() <= speed * speed)) return true;
    return is_oriented && !(spacing * spacing * state_.spins[k].squaredNorm() <= speed * speed);
  };
  double largest = 0.0;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (fixed_[k]) continue;
    if (kind_[k] == Kind::kWall) {
      double pushed = forces_on_all_[k].norm() / model_->masses()[k];
      if (is_oriented) pushed = std::max(pushed, spacing * torques_on_all_[k].norm() / model_->orientedPoints()->inertias()[k]);
      if (!(pushed <= acceleration)) {
        hits.push_back(points_[k]);
      } else {
        largest = std::max(largest, pushed);
      }
    } else if (kind_[k] == Kind::kRim && isFast(k)) {
      hits.push_back(points_[k]);
    }
  }
  return largest;
}

}  // namespace deformable_surface::simulation
