// Whether a solid tool passes through a surface in a step although contact keeps points from it: between its points, or because
// the surface is stretched more than contact can hold, and snaps over the tool.
#pragma once

#include "deformable_surface/simulation/contact_load.h"

#include <string>
#include <vector>

#include "tool_reach.h"

namespace deformable_surface::simulation {

/// A step in which a tool and a surface move straight.
struct PassageStep {
  const geometry::Solid& shape;
  const tool::Pose& pose;                                 // of the tool, at the end
  const AxisPoints &from, &to;                            // of the tool, m, in the world
  const std::vector<model::WeightedTriangle>& triangles;  // of the surface, or around a body
  const Points &before, &after;                           // (n x 3) m
  const std::vector<ContactLoad::Passed>& passed;         // points that the tool has passed over and pushes back, at the end
  bool had_passed;                                        // whether there were any at the beginning
  bool has_pressed;                                       // whether it pushes places between the points
  double spacing;                                         // m, of the points at rest
  bool is_equilibrium;                                    // at the end
  double begins, ends;                                    // s
  // Places near the edges of a flat tool, as from and to; null: none.
  const EdgePlaces *edges_from = nullptr, *edges_to = nullptr;
};

enum class Passage { kNone, kNarrow, kThin, kSnapped, kSearched, kIntoBody };

/// Of an open surface. kNarrow, kThin, kSnapped: the width of the tool is below the spacing, its thickness is, or neither.
/// kSearched: neither, in an equilibrium, and a tool at rest that no point touched before. A surface that is passed over comes
/// back before the tool, unless no point is pushed any more. It stays behind the tool if it is in equilibrium, or has not come
/// back for 0.2 s. In a thin tool points may always be deeper than its middle, so there they must also be deeper than it by half,
/// or in a narrow one a quarter, of the spacing. An edge of a flat tool passes where a place near it goes through a triangle that
/// stands steep on the tool, while the tool pushes no passed points back. through: before the step, and after it.
Passage findPassage(const PassageStep& step, ContactLoad::Through& through);

/// Into a closed surface: kIntoBody or kNone.
Passage findPassageIntoBody(const PassageStep& step);

/// What a notice says after "has passed through the surface". spacing: m, of the points at rest.
std::string describe(Passage passage, double spacing);

}  // namespace deformable_surface::simulation
