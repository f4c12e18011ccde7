// Where points between simulation points touch a tool: not where it is so flat that the simulation points are as deep.
#pragma once

#include "deformable_surface/geometry/solid.h"
#include "deformable_surface/tool/tool.h"
#include "deformable_surface/transfer/sampled_points.h"

namespace deformable_surface::simulation {

/// Whether a tool may touch points of a cell without touching its simulation point.
bool mayTouchBetween(const geometry::Solid& shape, const transfer::SampledPoints& between, Index cell);

/// The share with which points of a cell touch a tool beside its simulation point, and its gradient, 1/m.
struct EdgeShare {
  double value = 1.0;
  Vec3 gradient = Vec3::Zero();
};
/// 1 but on faces of boxes and caps of cylinders, where it falls to 0 with the distance of the cell's simulation point from the
/// nearest edge.
/// positions: (n x 3) m, of the simulation points.
EdgeShare findEdgeShare(const geometry::Solid& shape, const tool::Pose& pose, const transfer::SampledPoints& between, Index cell,
                        const Points& positions);

}  // namespace deformable_surface::simulation
