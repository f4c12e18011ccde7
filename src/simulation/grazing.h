// A tool that slides over a surface on another tool without touching it, through a gap thinner than the surface.
#pragma once

#include "deformable_surface/simulation/contact_load.h"

namespace deformable_surface::simulation {

struct Grazing {
  const tool::ToolParams* slider = nullptr;  // the tool that moves; null: none
  const tool::ToolParams* support = nullptr;
  double gap = 0.0;  // m, between a point on the support and the slider
};

/// The first solid tool that touches nothing and slides, at a time (s), within a thickness (m) over a point that another tool
/// pushes towards it. Simulation points have no thickness: the slider passes over them, where a real surface would be pushed
/// along.
Grazing findGrazing(const ContactLoad& contact, double time, const model::State& state, double thickness);

}  // namespace deformable_surface::simulation
