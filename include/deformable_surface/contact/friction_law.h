// Coulomb's law of friction with a spring in series: sticking points do not creep.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::contact {

/// The force on a point that touches a body [Cundall and Strack 1979]: -(k t + c v), but at most the limit. t is the distance of
/// the point, along the surface, from the place to which it sticks. v is its sliding velocity. At the limit the place slides
/// along with the point. A sticking point is held by a spring: it yields by F / k and stays there.
struct FrictionLaw {
  double static_limit = 0.0;   // N, mu_s F_n: a sticking point begins to slide there
  double kinetic_limit = 0.0;  // N, mu_k F_n: of a sliding point, not above static_limit
  double stiffness = 0.0;      // k, N/m
  double damping = 0.0;        // c, N s/m

  double limit(bool slides) const { return slides ? kinetic_limit : static_limit; }
  /// The force without the limit, N.
  Vec3 findTrial(const Vec3& stretch, const Vec3& sliding) const { return -(stiffness * stretch + damping * sliding); }
  /// The force with the limit, N.
  Vec3 findForce(const Vec3& stretch, const Vec3& sliding, bool slides) const {
    const Vec3 trial = findTrial(stretch, sliding);
    const double size = trial.norm(), most = limit(slides);
    return size > most ? Vec3(most / size * trial) : trial;
  }
  /// Ratio of the force to the trial force, 0 to 1: the factor of stiffness and damping, as a secant.
  double findShare(const Vec3& stretch, const Vec3& sliding, bool slides) const {
    const double size = findTrial(stretch, sliding).norm(), most = limit(slides);
    return size > most ? most / size : 1.0;
  }
  /// At the end of a step, s: returns whether the point slides from now on, and relaxes the stretch to what is left of it. Spring
  /// and damper bear the limit together, and the place slides by the rest of the way. So friction makes no energy.
  bool slide(Vec3& stretch, const Vec3& sliding, bool slid, double step) const {
    const Vec3 trial = findTrial(stretch, sliding);
    const double size = trial.norm();
    if (!(size > limit(slid))) return false;
    stretch = (damping * (stretch - step * sliding) - step * kinetic_limit / size * trial) / (damping + step * stiffness);
    return true;
  }
  /// Of the spring, J.
  double storedEnergy(const Vec3& stretch) const { return 0.5 * stiffness * stretch.squaredNorm(); }
};

}  // namespace deformable_surface::contact
