// Coulomb's law of friction with a spring in series: what sticks does not creep.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::contact {

/// The force on a point that touches a body [Cundall and Strack 1979]: -(k t + c v), but at most the limit. t is how far the
/// point is, along the surface, from the place to which it sticks; v is its sliding velocity. Where the limit is reached the
/// place slides along. A point that sticks is held by a spring: it yields by F / k and stays there.
struct FrictionLaw {
  double static_limit = 0.0;   // N, mu_s F_n: a point that sticks begins to slide there
  double kinetic_limit = 0.0;  // N, mu_k F_n: of one that slides, at most the other
  double stiffness = 0.0;      // k, N/m
  double damping = 0.0;        // c, N s/m

  double limit(bool slides) const { return slides ? kinetic_limit : static_limit; }
  /// N, without the limit.
  Vec3 findTrial(const Vec3& stretch, const Vec3& sliding) const { return -(stiffness * stretch + damping * sliding); }
  /// N.
  Vec3 findForce(const Vec3& stretch, const Vec3& sliding, bool slides) const {
    const Vec3 trial = findTrial(stretch, sliding);
    const double size = trial.norm(), most = limit(slides);
    return size > most ? Vec3(most / size * trial) : trial;
  }
  /// Of the force over the trial one, 0 to 1: what the limit leaves of stiffness and damping, as a secant.
  double findShare(const Vec3& stretch, const Vec3& sliding, bool slides) const {
    const double size = findTrial(stretch, sliding).norm(), most = limit(slides);
    return size > most ? most / size : 1.0;
  }
  /// Once a point has got there: whether it slides from now on. The stretch is what is left of it.
  bool slide(Vec3& stretch, const Vec3& sliding, bool slid) const {
    const Vec3 trial = findTrial(stretch, sliding);
    const double size = trial.norm();
    if (!(size > limit(slid))) return false;
    stretch = -(kinetic_limit / (stiffness * size)) * trial;
    return true;
  }
};

}  // namespace deformable_surface::contact
