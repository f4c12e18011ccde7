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
/// where the contact spring and its damping do not: their row bounds hold for friction, too.
/// Equilibria have no friction.
class FrictionLoad : public solve::ExternalLoad {
 public:
  explicit FrictionLoad(const ContactLoad& contact) : contact_(contact) {}

  bool isEmpty() const { return !contact_.hasFriction(); }
  void addForces(double time, const model::State& state, Points& forces) const override;
  bool mayDissipate(double time, double within, const model::State& state) const override {
    return contact_.mayBeDamped(time, within, state);
  }
  /// Dissipative, except where a tool's own motion drags points along, at most friction times the tool's path, and where springs
  /// return stored energy.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  double drivingPower(double time, double step, const model::State& state) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  /// Updates the places to which points stick.
  void remember(double time, double step, model::State& state) const override;

  /// Of the springs that hold sticking points, at a time (s), J.
  double energy(double time, const model::State& state) const;
  /// Friction force on a touched point, N.
  Vec3 findForce(std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) const;

 private:
  /// Tangential displacement and velocity of the point of a touch relative to the tool.
  struct Rub {
    contact::FrictionLaw law;
    Vec3 stretch;     // m
    Vec3 sliding;     // m/s
    bool has_spring;  // false: a new touch
    double slid;      // m, since the point last stuck

    Vec3 force() const { return law.findForce(stretch, sliding, slid); }
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
  Rub findRub(const Rubbing& body, const contact::BodyAnchor* anchor, const model::State& state,
              const ContactLoad::Touch& touch) const;

  mutable std::vector<contact::BodyAnchor> next_;  // scratch
  const ContactLoad& contact_;
};

/// The indices of points have changed: new_index (of the former points), -1 = removed.
void renumberFriction(const std::vector<Index>& new_index, std::vector<contact::BodyAnchor>& friction);

}  // namespace deformable_surface::simulation
