// The pass over the rows of a transfer operator: all that a frame runs. Apart from the operator, which is fitted once, because it
// knows plain arrays only and is compiled for wider instructions than the rest.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::transfer {

/// Dense points that lie behind each other and are made side by side.
constexpr Index kLanes = 8;

/// Per point at rest: the fitted tangents T = t + s n (t and n are the surface's own frame, s the slope of the fitted plane
/// against it), these slopes, the normal, and the height over the fitted plane.
enum FrameRow { kTangentX = 0, kTangentY = 3, kNormal = 6, kSlopeX = 9, kSlopeY = 10, kHeight = 11, kFrameRows = 12 };

/// An operator on n points, in groups of kLanes in which each quantity of the points lies side by side; see Transfer.
struct PassRows {
  Index n, k;           // points, and how many each follows
  const Index* index;   // (groups x k x kLanes)
  const float* weight;  // (groups x k x 3 x kLanes)
  const float* frame;   // (groups x kFrameRows x kLanes)
  const double* rest;   // (n x 3) m
};

/// Of the simulation points.
struct PassMotion {
  const float* displacements;  // (m x 4) m, less the reference; the last is no number of use
  double reference[3];         // m
};

/// What a pass writes.
struct PassOutput {
  double* positions;  // (n x 3) m
  float* normals;     // (n x 3), or null
  float* ratio;       // (n): local change of area, and nothing else; or null
};

/// Makes the points of the groups from begin to end. The bits do not depend on the instructions that the processor has.
void runGroups(Index begin, Index end, const PassRows& rows, const PassMotion& motion, const PassOutput& output);

/// Sets the normals in the frames of a group to those that runGroups() finds at rest.
void settleNormals(float* frame);

}  // namespace deformable_surface::transfer
