#include "deformable_surface/simulation/contact_damping.h"

#include "deformable_surface/base/timer.h"

#include <algorithm>

namespace deformable_surface::simulation {

double ContactDamping::findFull(const tool::Motion& motion, const model::State& state, const ContactLoad::Touch& touch) const {
  const Vec3 relative = contact_.points().findVelocity(touch.point, state.velocities) - motion.velocityAt(touch.position);
  return -coefficient(touch) * relative.dot(touch.normal);
}

double ContactDamping::springOf(const ContactLoad::Touch& touch) const {
  return touch.softness * contact_.points().massOf(touch.point) * contact_.rate() * contact_.rate();
}

Vec3 ContactDamping::findForce(const tool::Motion& motion, const model::State& state, const ContactLoad::Touch& touch) const {
  const double force = findFull(motion, state, touch), spring = touch.force.norm();
  return std::max(is_gradual_ ? std::min(force, spring) : force, -spring) * touch.normal;
}

Vec3 ContactDamping::findForce(std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) const {
  const tool::ToolParams& tool = contact_.all()[body].tool;
  return contact_.isDamped(tool) ? findForce(tool::findMotion(tool.path, time), state, touch) : Vec3::Zero();
}

void ContactDamping::addForces(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  const auto begin = [&](const tool::ToolParams& tool) { return tool::findMotion(tool.path, time); };
  contact_.forEachDampedTouch(time, state, begin, [&](const tool::Motion& motion, const ContactLoad::Touch& touch) {
    contact_.points().addForce(touch.point, state.positions, findForce(motion, state, touch), forces);
  });
  contact_.addSeconds(timer.seconds());
}

double ContactDamping::estimateWork(double from, double to, const model::State&, const model::State& after) const {
  double work = 0.0;
  const auto begin = [&](const tool::ToolParams& tool) { return tool::findMotion(tool.path, from); };
  contact_.forEachDampedTouch(to, after, begin, [&](const tool::Motion& motion, const ContactLoad::Touch& touch) {
    const double speed = motion.velocityAt(touch.position).dot(touch.normal);
    work += 0.25 * coefficient(touch) * speed * speed * (to - from);
  });
  return work;
}

double ContactDamping::drivingPower(double time, double, const model::State& state) const {
  double power = 0.0;
  const auto begin = [&](const tool::ToolParams& tool) { return tool::findMotion(tool.path, time); };
  contact_.forEachDampedTouch(time, state, begin, [&](const tool::Motion& motion, const ContactLoad::Touch& touch) {
    power += findForce(motion, state, touch).dot(motion.velocityAt(touch.position));
  });
  return power;
}

// Where the force equals that of the spring it has the spring's stiffness, on the way in, or cancels it, on the way out.
void ContactDamping::addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const {
  if (!(step > 0.0)) return;
  const auto begin = [&](const tool::ToolParams& tool) { return tool::findMotion(tool.path, time); };
  contact_.forEachDampedTouch(time, state, begin, [&](const tool::Motion& motion, const ContactLoad::Touch& touch) {
    const double full = findFull(motion, state, touch), spring = touch.force.norm();
    double along = coefficient(touch) / step;
    if (is_gradual_ && full > spring) along = springOf(touch);
    if (full < -spring) along = 0.0;
    contact_.points().addStiffness(touch.point, along * touch.normal * touch.normal.transpose(), stiffness);
  });
}

void ContactDamping::addIndefiniteStiffness(double time, const model::State& state, BlockSparse& stiffness) const {
  const auto begin = [&](const tool::ToolParams& tool) { return tool::findMotion(tool.path, time); };
  contact_.forEachDampedTouch(time, state, begin, [&](const tool::Motion& motion, const ContactLoad::Touch& touch) {
    const double along = findFull(motion, state, touch) < -touch.force.norm() ? -springOf(touch) : 0.0;
    contact_.points().addStiffness(touch.point, along * touch.normal * touch.normal.transpose(), stiffness);
  });
}

void ContactDamping::addRowBounds(double time, const model::State& state, std::vector<double>&,
                                  std::vector<double>& damping) const {
  contact_.forEachNearDamped(
      time, state, [&](Index i) { damping[i] += coefficient(contact_.points().dampedShare() * contact_.points().massOf(i)); });
}

}  // namespace deformable_surface::simulation
