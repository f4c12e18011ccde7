// Steps that surfaces and bodies share when they are made from a cloud. Private.
#pragma once

#include "deformable_surface/base/notice.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// The finite, distinct points of the input. InputError if there are fewer than three.
RestSurface cleanInput(const cloud::PointCloud& input);

/// Warns of simulation points that are almost the same, for which steps are short. O(m log m).
void warnOfClosePoints(RestSurface& s);

/// Whether there are gaps, not only holes of the sampling.
bool hasGaps(const cloud::GeodesicNeighbors& found, const RestSurface& s);
/// Adds a note about gaps that the sampling hardly resolves.
void noteGaps(const cloud::GeodesicNeighbors& found, RestSurface& s);

/// Points that simplification must keep: of every pinned region three that are far from each other.
std::vector<Index> choosePinPoints(const SceneParams& params, const Points& dense);

/// The same, and of what each `move` tool holds from the beginning.
std::vector<Index> chooseHeldPoints(const SceneParams& params, const Points& dense);
/// Where the `move` tools are that hold points of the rest shape from the beginning; without their paths and strengths.
std::vector<tool::ToolParams> findGripsAtRest(const SceneParams& params);

/// Width of points across the direction in which they spread most, m: rows of points side by side have one, a single row has
/// almost none.
double measureBand(const Points& points);
/// Whether points lie in several rows side by side, so that a pin that holds them clamps; spacing: theirs, m. For all points or
/// for those that a pin holds.
bool isBandOfRows(const Points& points, double spacing);
/// The width of the points that a pin holds, m, across the direction in which they spread most.
double measureBand(const Points& points, const PinParams& pin);
bool isBandOfRows(const Points& points, const PinParams& pin, double spacing);

/// Marks the simulation points that the scene's pins hold and, with input.unconstrained_parts: freeze, those of unheld parts.
void applyPins(const SceneParams& params, RestSurface& s);

/// Neighbours of a body's points, in space or over the body, and the weights of their detours (empty: all one). neighbors: their
/// 2k nearest, which are replaced.
std::vector<double> keepNearOverBody(const cloud::NeighborsParams& params, const Points& points, Lists& neighbors,
                                     RestSurface& s);
}  // namespace deformable_surface::simulation
