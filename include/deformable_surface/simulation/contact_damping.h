// Damping of contact with solid tools, as a load on the points that touch them. The contact springs are
// ContactLoad, which has a potential.
#pragma once

#include "deformable_surface/simulation/contact_load.h"

#include <cmath>

namespace deformable_surface::simulation {

/// F = -c v n on a point that touches a solid tool. v: velocity of the point relative to the tool, along the
/// outward normal n. c = 2 zeta m r, with zeta = kShare and m r^2 the stiffness of the contact spring; on a
/// pad, which makes it softer, times the square root of the ratio. F never exceeds the spring
/// force on the way out, so that contact does not pull; if it is gradual, for methods that search a balance, nor on the way in,
/// so that it does not set in at once. About half of the speed is left after an impact. Without this damping, points pressed
/// between two tools bounced higher and higher, because friction added energy on their way. Contact of surfaces without friction
/// is not damped: it conserves energy. See ContactLoad::isDamped().
class ContactDamping : public solve::ExternalLoad {
 public:
  static constexpr double kShare = 0.2;  // zeta, of critical

  explicit ContactDamping(const ContactLoad& contact, bool is_gradual = false) : contact_(contact), is_gradual_(is_gradual) {}

  /// Whether contact is damped with no tool.
  bool isEmpty() const { return !contact_.hasDamped(); }
  bool isSplitOff() const override { return true; }
  void addForces(double time, const model::State& state, Points& forces) const override;
  bool mayDissipate(double time, double within, const model::State& state) const override {
    return contact_.mayBeDamped(time, within, state);
  }
  /// Dissipative, except where a tool moves along n with speed V: its power is then at most c V^2 / 4.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  double drivingPower(double time, double step, const model::State& state) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  void addIndefiniteStiffness(double time, const model::State& state, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;

  /// Damping force on a touched point, N.
  Vec3 findForce(std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) const;

 private:
  double coefficient(double mass) const { return 2.0 * kShare * mass * contact_.rate(); }  // c without a pad, N s/m
  double coefficient(const ContactLoad::Touch& touch) const {
    return std::sqrt(touch.softness) * coefficient(contact_.points().dampedMassOf(touch.point));
  }
  /// c v, N.
  double findFull(const tool::Motion& motion, const model::State& state, const ContactLoad::Touch& touch) const;
  /// m r^2, or what a pad leaves of it, N/m.
  double springOf(const ContactLoad::Touch& touch) const;
  Vec3 findForce(const tool::Motion& motion, const model::State& state, const ContactLoad::Touch& touch) const;

  const ContactLoad& contact_;
  const bool is_gradual_;
};

}  // namespace deformable_surface::simulation
