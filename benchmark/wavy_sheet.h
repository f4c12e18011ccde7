// A curved sheet whose normals and area are known exactly, and the stages that lead from its points to a simulation, each with
// the error of its result. Times and memory are measured on the same stages.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
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
  Lists neighbors;
  Points normals;
  cloud::Boundary boundary;
  cloud::Simplification simplification;
  cloud::Rings dense_rings;
  std::vector<Index> kept;
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

/// The stages of buildRestSurface, with its defaults.
std::vector<Stage> listStages();

/// How many simulation points a cloud of n is simplified to: a fiftieth.
Index countKept(Index n);

}  // namespace deformable_surface::benchmark
