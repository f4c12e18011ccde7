// Where text stands about a surface in RViz, so that no text lies on another nor on a handle from wherever one looks. A file of
// its own because the node's markers and the hand, two programs, keep to the same places.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>

namespace deformable_surface::node {

// Rows of text above and below the anchor; those next to it stay free.
constexpr int kRowsAbove = 6, kRowsBelow = 4;

struct TextPlace {
  Vec3 anchor = Vec3::Zero();  // m
  double height = 0.0;         // m, of a letter
};

struct Box {
  Vec3 low, high;  // m
  double extent() const { return (high - low).norm(); }
};

/// The bounding box of the points without stray ones, which would make a surface small in its own window: those farther
/// outside the middle eight tenths along an axis than these are wide. points: not empty.
Box findMainBox(const Points& points);

/// Above a surface in this box, so high that kRowsBelow rows find room between them. Up is z, and in a frame with "optical" in
/// its name, as of cameras, -y (REP 103).
TextPlace placeText(const Box& box, const std::string& frame_id);

/// The lines padded with empty ones, so that RViz, which centres a text on its position, shows them from this row on; rows
/// count from the highest, 2 kRowsAbove are centred on the anchor.
std::string showFromRow(int row, const std::string& lines);

/// The sentence in at most kRowsBelow - 1 lines below the anchor; what does not fit is left out with dots in its place.
std::string showBelow(const std::string& sentence);

}  // namespace deformable_surface::node
