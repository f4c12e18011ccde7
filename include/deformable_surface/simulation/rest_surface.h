// From a cloud to a surface that can be simulated, once per accepted cloud, through the rooms cloud, model and transfer.
#pragma once

#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/cloud/geodesic_cells.h"
#include "deformable_surface/cloud/pixel_links.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/cloud/simplification.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/simulation/load_points.h"
#include "deformable_surface/simulation/region_material.h"
#include "deformable_surface/simulation/scene_params.h"
#include "deformable_surface/transfer/sampled_points.h"
#include "deformable_surface/transfer/solid_transfer.h"
#include "deformable_surface/transfer/transfer.h"

#include <functional>
#include <limits>
#include <memory>

namespace deformable_surface::simulation {

/// How a pin holds a point: it lies in the region, or so near to the edge of a clamping region that it moves with it.
enum PinMark : char { kNotPinned = 0, kInPin = 1, kRidesOnPin = 2 };

constexpr Index kMaxIndex = std::numeric_limits<Index>::max();

/// Everything made from the rest state. It does not change afterwards.
struct RestSurface {
  cloud::CleanCloud dense;         // finite distinct points on the surface; normals complete and consistently oriented
  Points off_surface;              // (dense) m, from there to the input's points; empty: they are the same
  cloud::PixelLinks pixel_links;   // of an image whose points were moved onto the surface; else empty
  bool is_thick = false;           // the points fill their neighbourhoods: over the surface is where it is near in space
  Lists dense_neighbors;           // (dense) nearest first
  std::vector<char> is_boundary;   // (dense) of a mass-spring surface until it is finished; empty: not known
  std::vector<Index> leader;       // (dense) the one with which each goes that no list has, -1: with what is near; empty: none
  cloud::Simplification order;     // of the dense points: every coarser set of simulation points is a prefix of it
  Points points, normals;          // (m x 3) simulation points
  std::vector<Index> dense_index;  // (m) the dense point that each simulation point is
  cloud::GeodesicCells cells;      // of the simulation points on the dense ones; empty if neighbourhoods are Euclidean
  cloud::Rings rings;              // of the simulation points
  double area = 0.0;               // m^2, of the dense surface
  double dense_spacing = 0.0;      // m, mean, of the dense points of a mass-spring surface; copies keep it
  Vec3 across = Vec3::Zero();      // unit normal of the plane in which alone its points move; zero: they move in space
  bool closed = false;             // the dense surface has no boundary
  std::unique_ptr<model::DeformableModel> model;  // a simulation takes it out
  transfer::Transfer transfer;
  std::shared_ptr<const transfer::SampledPoints> between;  // of a coarser copy: points of the cloud that touch tools
  std::shared_ptr<const LoadPoints> load_points;           // of a coarser copy: those that carry forces with a radius
  transfer::SolidTransfer solid_transfer;                  // in its place, of a solid; empty where every point is simulated
  Lists solid_neighbors;              // (m) of the simulation points of a solid, over its body, nearest first; else empty
  std::vector<double> detours;        // of these, weights; empty: all one
  std::vector<double> point_volumes;  // (m) of these, m^3, or m^2, of the cloud around each; until they are known: empty
  std::vector<char> pinned;           // (m) by the scene's pins: kInPin or, beside them, kRidesOnPin; else 0
  std::vector<Index> pin_of;          // (m) the first of the scene's pins that each point lies in, where the cloud is; -1: none
  std::vector<model::ClampEdge> clamp_edges;  // where the pins that clamp end
  std::vector<char> pinned_turns;             // (m) points whose orientation is held too
  std::vector<char> creased;                  // (m) particles that are not smooth; empty for other models
  std::vector<PointValues> values;            // (m) of the scene's regions; empty for models without them
  bool has_hinged_pins = false;               // a pin clamps the dense surface and is a hinge to the simulation points
  std::vector<std::string> warnings;          // what will differ from the scene, or not go well
  std::vector<std::string> notes;             // for the user: counts, rules, choices of auto
};

/// Cleans, orients, simplifies, connects and builds the model and the transfer operator. Throws InputError.
/// O(n k log n) for n input points. coarsest: the order of removal is recorded down to this number of simulation points; the
/// result does not depend on it. choose: if given, finds the number of simulation points instead of params.simplification, from
/// the full surface: dense points, order and area, without a model.
RestSurface buildRestSurface(const SceneParams& params, const cloud::PointCloud& input, Index coarsest = kMaxIndex,
                             const std::function<Index(const RestSurface& full)>& choose = nullptr);

/// The surface that buildRestSurface() makes if choose(full) returns this number of points, without its transfer: a trial runs
/// the same surface as the simulation later. Throws InputError.
RestSurface buildTrial(const SceneParams& params, const RestSurface& full, Index points);

/// The same surface with about target simulation points, from the recorded order: model and pins, without dense points or
/// transfer. Its masses sum to those of the full surface. Throws InputError if so few points span no surface.
RestSurface buildCoarser(const SceneParams& params, const RestSurface& of, Index target);

/// A second copy of a coarser surface or solid for another simulation: the same points with a model of its own, at a fraction of
/// the cost.
RestSurface copyCoarser(const SceneParams& params, const RestSurface& of);

}  // namespace deformable_surface::simulation
