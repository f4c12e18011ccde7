// Friction of the points that solid tools touch, as a load on them.
#pragma once

#include "deformable_surface/contact/friction_law.h"
#include "deformable_surface/simulation/contact_load.h"

#include <cstdint>
#include <vector>

namespace deformable_surface::simulation {

/// Coulomb's friction by contact::FrictionLaw. A point that begins to touch a tool sticks to the place of the tool that it
/// touches; State::friction remembers the place. The spring has the rate of the contact itself, k = m r^2, and is damped by c = m
/// r. In an equilibrium there is none.
class FrictionLoad : public solve::ExternalLoad {
 public:
  explicit FrictionLoad(const ContactLoad& contact) : contact_(contact) {}

  bool isEmpty() const;
  void addForces(double time, const model::State& state, Points& forces) const override;
  /// It takes energy, but where a tool's own motion drags points along, at most friction times the tool's way, and where springs
  /// give back what they have stored.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;
  /// Where points stick from now on.
  void remember(double time, model::State& state) const override;

  /// N, on a touched point.
  Vec3 findForce(std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) const;

 private:
  /// How the point of a touch has moved along the surface of the tool.
  struct Rub {
    contact::FrictionLaw law;
    Vec3 stretch;  // m
    Vec3 sliding;  // m/s
    bool slides;

    Vec3 force() const { return law.findForce(stretch, sliding, slides); }
  };
  /// What is the same for all touches of a body at a time.
  struct Rubbing {
    std::uint64_t key;
    double static_coefficient, kinetic_coefficient;
    tool::Pose pose;
    tool::Motion motion;
  };
  Rubbing beginRubbing(const tool::ToolParams& tool, double time) const;
  Rub findRub(const Rubbing& body, const model::State& state, const ContactLoad::Touch& touch) const;
  double storedEnergyAt(double time, const model::State& state) const;

  mutable std::vector<contact::BodyAnchor> next_;  // scratch
  const ContactLoad& contact_;
};

/// Points have got other indices: new_index (of those before), -1 = gone.
void renumberFriction(const std::vector<Index>& new_index, std::vector<contact::BodyAnchor>& friction);

}  // namespace deformable_surface::simulation
