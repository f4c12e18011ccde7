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
  whole.markPartners(movers, wanted);
  for (Index i = 0; i < n; ++i)
    if (wanted[i] && !moving[i]) wall.push_back(i);
  whole.markPartners(wall, beside);
  made.part = whole.makePart(wanted);
  for (const Index i : made.part.points)
    made.kind.push_back(moving[i] ? (beside[i] ? Kind::kRim : Kind::kMoving) : (wanted[i] ? Kind::kWall : Kind::kBehind));
  return made;
}

ActivePart::ActivePart(const model::DeformableModel& whole, const std::vector<char>& moving, const SceneParams& params, const Loads& loads)
    : ActivePart(make(whole, moving), params, loads) {}

ActivePart::ActivePart(Made made, const SceneParams& params, const Loads& loads)
    : params_(params),
      moving_(std::move(made.moving)),
      model_(std::move(made.part.model)),
      points_(std::move(made.part.points)),
      new_index_(moving_.size(), -1),
      kind_(std::move(made.kind)),
      gravity_(model_->masses(), loads.gravity.gravity),
      pressure_(*model_, params.pressure),
      drag_(*model_, params.viscous_drag),
      anchors_({}),
      forces_(model_->masses()),
      contact_(model_->masses()),
      friction_(contact_),
      held_(points_.size(), 1),
      fixed_(points_.size(), 0),
      system_(*model_, loads_, held_, params.material.damping),
      march_(system_, *model_, params.integrator) {
  for (std::size_t k = 0; k < points_.size(); ++k) new_index_[points_[k]] = static_cast<Index>(k);
  state_.positions.resize(points_.size());
  state_.velocities.resize(points_.size());
  setLoads(loads);
}

void ActivePart::setLoads(const Loads& loads) {
  gravity_.gravity = loads.gravity.gravity;
  anchors_ = loads.anchors;
  anchors_.renumber(new_index_);
  // Each point keeps its share of a force of which others sleep.
  std::vector<NamedForces::Named> forces = loads.forces.all();
  for (NamedForces::Named& force : forces) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < force.points.size(); ++k) {
      if (new_index_[force.points[k]] < 0) continue;
      force.points[kept] = new_index_[force.points[k]];
      force.shares[kept++] = force.shares[k];
    }
    force.points.resize(kept);
    force.shares.resize(kept);
  }
  forces_.restore(forces);
  contact_.restore(loads.contact.all());
  contact_.renumber(new_index_);
  contact_.setRate(loads.contact_rate);
  system_.setDamping(loads.damping);
  loads_ = {&gravity_, &forces_};
  if (params_.pressure != 0.0) loads_.push_back(&pressure_);
  if (params_.viscous_drag > 0.0) loads_.push_back(&drag_);
  if (!params_.anchors.empty()) loads_.push_back(&anchors_);
  if (!contact_.isEmpty()) loads_.push_back(&contact_);
  if (!friction_.isEmpty()) loads_.push_back(&friction_);
  march_.loadsChanged();
}

solve::TimeMarch::Outcome ActivePart::step(double time, const State& state, const std::vector<char>& held) {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Index i = points_[k];
    const bool moves = isMoving(static_cast<Index>(k));
    state_.positions[k] = state.positions[i];
    state_.velocities[k] = moves ? state.velocities[i] : Vec3::Zero();
    fixed_[k] = held[i];
    held_[k] = !moves || held[i];
  }
  return march_.step(time, state_);
}

void ActivePart::put(State& state) const {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (!isMoving(static_cast<Index>(k))) continue;
    state.positions[points_[k]] = state_.positions[k];
    state.velocities[points_[k]] = state_.velocities[k];
  }
}

double ActivePart::findHits(double time, double acceleration, double speed, std::vector<Index>& hits) {
  hits.clear();
  system_.computeForcesOnAll(time, state_, forces_on_all_);
  double largest = 0.0;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (fixed_[k]) continue;
    if (kind_[k] == Kind::kWall) {
      const double pushed = forces_on_all_[k].norm() / model_->masses()[k];
      if (!(pushed <= acceleration)) {
        hits.push_back(points_[k]);
      } else {
        largest = std::max(largest, pushed);
      }
    } else if (kind_[k] == Kind::kRim && !(state_.velocities[k].squaredNorm() <= speed * speed)) {
      hits.push_back(points_[k]);
    }
  }
  return largest;
}

}  // namespace deformable_surface::simulation
