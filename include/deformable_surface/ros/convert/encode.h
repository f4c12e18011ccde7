// Encodes PointCloud2 messages: the deformed surface with the input's other fields, and the simulation points.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/simulation.h"

#include <sensor_msgs/PointCloud2.h>

#include <vector>

namespace deformable_surface::node {

/// The layout of ~deformed, made once per input cloud, so that a frame only copies. Fields, tightly packed: x y z, normal_x
/// normal_y normal_z (if wanted), displacement, error (if wanted), then the input's extra fields except those with one of these
/// names.
class SurfaceEncoder {
 public:
  SurfaceEncoder(const cloud::PointCloud& input, bool with_normals, bool with_error);

  /// Fills all but the header. The surface must stem from the input given to the constructor, with normals and errors if
  /// they are wanted. Without inserted points the width and height are those of the input, else the height is one. Throws
  /// InputError if the points do not fit in a message.
  void encode(const simulation::Surface& surface, sensor_msgs::PointCloud2& message) const;

 private:
  std::uint32_t width_, height_;
  bool with_normals_, with_error_;
  std::vector<sensor_msgs::PointField> fields_;
  std::uint32_t computed_size_ = 0;        // bytes of a point that change from frame to frame
  std::uint32_t extra_size_ = 0;           // bytes of a point that stay
  std::vector<std::uint8_t> extra_bytes_;  // (n x extra_size_)
};

/// The quantities of ~simulation_points, (m) or (m x 3) each.
struct SimulationPoints {
  const Points& positions;  // m
  const Points& normals;
  const std::vector<double>& masses;                 // kg
  const std::vector<double>& strain;                 // largest |l / l0 - 1| of a point's links
  const std::vector<char>& awake;                    // 0 or 1
  const std::vector<char>& pinned;                   // 0 or 1
  const std::vector<model::ParticleTraits>& traits;  // of oriented particles, else empty
  const std::vector<double>& stress;                 // Pa, von Mises' equivalent of elastic solids, else empty
};

/// Fills all but the header: x y z normal_x normal_y normal_z mass strain as float32, awake and pinned as uint8; for oriented
/// particles also temperature (K above ambient) as float32 and id as uint32; for elastic solids also stress as float32.
void encodeSimulationPoints(const SimulationPoints& points, sensor_msgs::PointCloud2& message);
/// The same for a simulation now. Pinned points are not awake.
void encodeSimulationPoints(const simulation::Simulation& simulation, sensor_msgs::PointCloud2& message);

}  // namespace deformable_surface::node
