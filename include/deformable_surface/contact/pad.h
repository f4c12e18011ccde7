// The law of soft pads: the same for contact with tools and of a surface with itself.
#pragma once

#include <limits>

namespace deformable_surface::contact {

/// Stiffness, N/m, of the part of a pad that a contact spring stands for: pressure p makes the pad yield by compliance times p.
/// area: m^2; compliance: m/Pa, 0 = there is no pad, whose stiffness is infinite. The spring is the softer of the pad and of the
/// penalty without it.
inline double findPadStiffness(double area, double compliance) {
  return compliance > 0.0 ? area / compliance : std::numeric_limits<double>::infinity();
}

}  // namespace deformable_surface::contact
