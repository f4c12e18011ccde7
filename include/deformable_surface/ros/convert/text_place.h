// Places of texts around a surface in RViz, so that no text covers another or a handle from any side. The
// node's markers and the interactive markers, two programs, use the same places.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>

namespace deformable_surface::node {

// Rows of text above and below the anchor; the rows next to it stay free.
constexpr int kRowsAbove = 6, kRowsBelow = 4;

struct TextPlace {
  Vec3 anchor = Vec3::Zero();  // m
  double height = 0.0;         // m, of a letter
};

struct Box {
  Vec3 low, high;  // m
  double extent() const { return (high - low).norm(); }
};

/// The bounding box of the points without stray ones, which would make the surface small in its window: points farther
/// outside the middle eight tenths along an axis than these are wide. points: not empty.
Box findMainBox(const Points& points);

/// A place above a surface in this box, high enough for kRowsBelow rows between them. Up is z; in a frame with "optical" in
/// its name, as of cameras, it is -y (REP 103).
TextPlace placeText(const Box& box, const std::string& frame_id);

/// The lines padded with empty ones, so that RViz, which centres a text on its position, shows them from this row on. Rows
/// count from the highest; 2 kRowsAbove are centred on the anchor.
std::string showFromRow(int row, const std::string& lines);

/// The sentence in at most kRowsBelow - 1 lines below the anchor; dots replace what does not fit.
std::string showBelow(const std::string& sentence);

}  // namespace deformable_surface::node
