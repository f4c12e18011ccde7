// A curved sheet whose normals and area are known exactly, and the stages from its points to a simulation, each with the error of
// its result. Times and memory are measured on the same stages.
#pragma once

#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/cloud/geodesic_cells.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/cloud/simplification.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/transfer/transfer.h"

#include <functional>
#include <memory>
#include <string>

namespace deformable_surface::benchmark {

enum class PointOrder { kScan, kShuffled };  // row by row as scanners give them, or at random

/// One square metre of z = a sin(w x) cos(w y), about n points, jittered within the surface.
cloud::PointCloud makeWavySheet(Index n, PointOrder order);
Vec3 findWavyNormal(const Vec3& point);
double findWavyArea();

/// What the stages make, in their order.
struct Preparation {
  cloud::PointCloud cloud;
  Index target = 0;  // simulation points
  cloud::CleanCloud cleaned;
  Lists neighbors;
  Index num_at_gaps = 0;
  std::vector<char> are_nearest;  // lists that hold the nearest in space
  Points normals;
  cloud::Boundary boundary;
  cloud::Simplification simplification;
  double area = 0.0;  // m^2, of the full cloud
  std::vector<Index> kept;
  cloud::GeodesicCells cells;
  Points points, point_normals;  // of the simulation points
  cloud::Rings rings;
  std::unique_ptr<model::MassSpring> model;
  transfer::Transfer transfer;
};

struct Stage {
  std::string name, error_name;
  std::function<void(Preparation&)> run;
  std::function<double(const Preparation&)> error;
  std::function<std::uint64_t(const Preparation&)> hash;
};

/// The stages of buildRestSurface, with its defaults, in its order.
std::vector<Stage> listStages();

/// How many simulation points a cloud of n is simplified to: a fiftieth.
Index countKept(Index n);

}  // namespace deformable_surface::benchmark
