// What surfaces and bodies share on the way from a cloud to what can be simulated. Private.
#pragma once

#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// "3 points".
std::string count(Index n, const std::string& what);

/// The finite, distinct points of the input. InputError if there are fewer than three.
RestSurface cleanInput(const cloud::PointCloud& input);

/// Whether there are gaps, and not just holes of the sampling.
bool hasGaps(const cloud::GeodesicNeighbors& found, const RestSurface& s);
/// Tells of gaps that the sampling hardly resolves.
void noteGaps(const cloud::GeodesicNeighbors& found, RestSurface& s);

/// Points that no simplification may take: of every pinned region three that are far from each other.
std::vector<Index> choosePinPoints(const SceneParams& params, const Points& dense);

/// Whether points lie in several rows side by side, so that a pin that holds them clamps; spacing: theirs, m. Of all points or of
/// those that a pin holds.
bool isBandOfRows(const Points& points, double spacing);
/// How wide the points are that a pin holds, m, across the way in which they spread most.
double measureBand(const Points& points, const PinParams& pin);
bool isBandOfRows(const Points& points, const PinParams& pin, double spacing);

/// Which simulation points the scene's pins hold, and with input.unconstrained_parts: freeze those of parts that nothing holds.
void applyPins(const SceneParams& params, RestSurface& s);

/// Neighbours of a body's points, in space or over the body, and the weights of their detours (empty: all one). neighbors: their
/// 2k nearest, which are replaced.
std::vector<double> keepNearOverBody(const cloud::NeighborsParams& params, const Points& points, Lists& neighbors,
                                     RestSurface& s);
}  // namespace deformable_surface::simulation
