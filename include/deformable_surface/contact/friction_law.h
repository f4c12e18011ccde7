// Coulomb's law of friction with a spring in series: sticking points do not creep.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::contact {

/// The force on a point that touches a body [Cundall and Strack 1979]: -(k t + c v), but at most the limit. t is the distance of
/// the point, along the surface, from the place to which it sticks. v is its sliding velocity. At the limit the place slides
/// along with the point. A sticking point is held by a spring: it yields by F / k and stays there. The limit falls from the
/// static to the kinetic one within a way D of sliding [Ida 1972]. D is ten times the static limit over k, some micrometres.
/// Otherwise a contact that begins, or trembles, would slide for good at the first moment without pressure.
struct FrictionLaw {
  static constexpr double kOnset = 10.0;
  static constexpr double kBuildUp = 2.5;  // times c / k: one over the frequency, with a fifth of critical damping

  double static_limit = 0.0;   // N, mu_s F_n: a sticking point begins to slide there
  double kinetic_limit = 0.0;  // N, mu_k F_n: after sliding by D, not above static_limit
  double stiffness = 0.0;      // k, N/m
  double damping = 0.0;        // c, N s/m

  /// N. slid: m, the way since the point last stuck.
  double limit(double slid) const {
    const double way = stiffness * slid, full = kOnset * static_limit;
    return way < full ? static_limit - way / full * (static_limit - kinetic_limit) : kinetic_limit;
  }
  /// m, of a new pair of parts that already slide on each other: its way while the pressure builds up. Tools do not use it.
  double slidAtFirst(const Vec3& sliding) const {
    return stiffness > 0.0 ? kBuildUp * damping / stiffness * sliding.norm() : 0.0;
  }
  /// The force without the limit, N.
  Vec3 findTrial(const Vec3& stretch, const Vec3& sliding) const { return -(stiffness * stretch + damping * sliding); }
  /// The force with the limit, N.
  Vec3 findForce(const Vec3& stretch, const Vec3& sliding, double slid) const {
    const Vec3 trial = findTrial(stretch, sliding);
    const double size = trial.norm(), most = limit(slid);
    return size > most ? Vec3(most / size * trial) : trial;
  }
  /// Ratio of the force to the trial force, 0 to 1: the factor of stiffness and damping, as a secant.
  double findShare(const Vec3& stretch, const Vec3& sliding, double slid) const {
    const double size = findTrial(stretch, sliding).norm(), most = limit(slid);
    return size > most ? most / size : 1.0;
  }
  /// At the end of a step, s: returns the way slid from now on, 0 if the point sticks, and relaxes the stretch to what is left of
  /// it. Spring and damper bear the limit together, and the place slides by the rest of the way. So friction makes no energy.
  double slide(Vec3& stretch, const Vec3& sliding, double slid, double step) const {
    const Vec3 trial = findTrial(stretch, sliding), before = stretch;
    const double size = trial.norm(), most = limit(slid);
    if (!(size > most)) return 0.0;
    stretch = (damping * (stretch - step * sliding) - step * most / size * trial) / (damping + step * stiffness);
    return slid + (stretch - before).norm();
  }
  /// Of the spring, J.
  double storedEnergy(const Vec3& stretch) const { return 0.5 * stiffness * stretch.squaredNorm(); }
};

}  // namespace deformable_surface::contact
