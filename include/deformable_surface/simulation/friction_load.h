// Friction between solid tools and the points that they touch, as a load.
#pragma once

#include "deformable_surface/contact/friction_law.h"
#include "deformable_surface/simulation/contact_load.h"

#include <cstdint>
#include <vector>

namespace deformable_surface::simulation {

/// Coulomb's friction by contact::FrictionLaw. A point that begins to touch a tool sticks to the touched place of the tool;
/// State::friction stores the place. The spring has the stiffness of the contact spring, k = m r^2, and the damping of
/// ContactDamping. On a pad it is no stiffer than the pad, and the damping follows the square root. Both act along the surface,
/// where the contact spring and its damping do not.
/// Equilibria have no friction.
class FrictionLoad : public solve::ExternalLoad {
 public:
  explicit FrictionLoad(const ContactLoad& contact) : contact_(contact) {}

  bool isEmpty() const { return !contact_.hasFriction(); }
  bool isSplitOff() const override { return true; }
  void addForcesAtRest(double time, const model::State& state, Points& forces) const override;
  void addForces(double time, const model::State& state, Points& forces) const override;
  bool mayDissipate(double time, double within, const model::State& state) const override {
    return contact_.mayBeDamped(time, within, state);
  }
  /// Dissipative, except where a tool's own motion drags points along, at most friction times the tool's path, and where springs
  /// return stored energy.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  double drivingPower(double time, double step, const model::State& state) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  /// Of the springs: the damping has the bounds of ContactDamping.
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;
  /// Updates the places to which points stick.
  void remember(double time, double step, model::State& state) const override;

  /// Of the springs that hold sticking points, at a time (s), J.
  double energy(double time, const model::State& state) const;
  /// Friction force on a touched point, N.
  Vec3 findForce(std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) const;

 private:
  /// What a touch has beside its velocity.
  struct Rub {
    contact::FrictionLaw law;
    Vec3 stretch;     // m, tangential, of the point relative to the tool
    bool has_spring;  // false: a new touch
    double slid;      // m, since the point last stuck
  };
  /// Values shared by all touches of a body at a time.
  struct Rubbing {
    std::uint64_t key;
    double static_coefficient, kinetic_coefficient;
    tool::Pose pose;
    tool::Motion motion;
  };
  Rubbing beginRubbing(const tool::ToolParams& tool, double time) const;
  template <typename Visit>  // visit(rubbing, touch, rub)
  void forEachRub(double time, const model::State& state, const Visit& visit) const;
  /// anchor: of the touched point, or null.
  Rub findRub(const Rubbing& body, const contact::BodyAnchor* anchor, const ContactLoad::Touch& touch) const;

  /// m/s, along the surface, of the point of a touch relative to the tool.
  Vec3 findSliding(const Rubbing& body, const model::State& state, const ContactLoad::Touch& touch) const;
  Vec3 findForce(const Rubbing& body, const model::State& state, const ContactLoad::Touch& touch, const Rub& rub) const {
    return rub.law.findForce(rub.stretch, findSliding(body, state, touch), rub.slid);
  }
  /// Whether rubs_ are those of this state: Verlet asks for forces at rest, for all forces, and for the memory, in this order.
  bool isKnown(double time, const model::State& state) const {
    return known_positions_ == state.positions.data() && known_friction_ == state.friction.data() && known_time_ == time;
  }

  mutable std::vector<contact::BodyAnchor> next_;  // scratch
  mutable std::vector<Rub> rubs_;                  // of addForcesAtRest(), until remember()
  mutable const Vec3* known_positions_ = nullptr;
  mutable const contact::BodyAnchor* known_friction_ = nullptr;
  mutable double known_time_ = 0.0;  // s
  const ContactLoad& contact_;
};

/// The indices of points have changed: new_index (of the former points), -1 = removed.
void renumberFriction(const std::vector<Index>& new_index, std::vector<contact::BodyAnchor>& friction);

}  // namespace deformable_surface::simulation
