// What surfaces and bodies share on the way from a cloud to what can be simulated. Private.
#pragma once

#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/model/elastic_solid/point_volumes.h"
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
bool isBandOfRows(const Points& points, const PinParams& pin, double spacing);

/// Which simulation points the scene's pins hold, and with input.unheld: freeze those of parts that nothing holds.
void applyPins(const SceneParams& params, RestSurface& s);

/// Pins whose band clamps the surface of these points and is but one row of the simulation points, which turn about it: sets
/// has_hinged_pins and warns.
void findHingedPins(const SceneParams& params, const Points& dense, RestSurface& s);

/// Neighbours, simulation points, model and transfer of an elastic solid, from cleaned points. Throws InputError. O(n k log n).
void buildRestSolid(const SceneParams& params, const cloud::PointCloud& input, RestSurface& s);
/// The same of a body of which the cleaned points are the closed surface: with neighbours over it, and outward normals.
void buildFilledSolid(const SceneParams& params, RestSurface& s);

/// Neighbours of a body's points, in space or over the body, and the weights of their detours (empty: all one). neighbors: their
/// 2k nearest, which are replaced.
std::vector<double> keepNearOverBody(const cloud::NeighborsParams& params, const Points& points, Lists& neighbors,
                                     RestSurface& s);
/// How many simulation points are asked for, of so many; of a threshold as well.
Index findSolidTarget(const cloud::SimplificationParams& how, Index of);
/// Model, pins and notes on the simulation points s.points. across, outline: see model::ElasticSolid.
void finishSolid(const SceneParams& params, const Lists& neighbors, const std::vector<double>& detours, const Vec3& across,
                 model::Outline outline, RestSurface& s);

}  // namespace deformable_surface::simulation
