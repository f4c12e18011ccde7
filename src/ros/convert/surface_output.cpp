#include "deformable_surface/ros/convert/surface_output.h"

#include <algorithm>

namespace deformable_surface::node {

cloud::PointCloud makeOutputCloud(const simulation::Surface& surface, const cloud::PointCloud& input) {
  cloud::PointCloud output;
  output.positions = surface.positions;
  for (const Eigen::Vector3f& normal : surface.normals) output.normals.push_back(normal.cast<double>());
  output.extra_fields = input.extra_fields;
  for (cloud::ExtraField& field : output.extra_fields) {
    const std::size_t bytes = cloud::sizeOf(field.type) * field.count, before = field.bytes.size();
    field.bytes.resize(before + bytes * surface.source.size());
    std::uint8_t* row = field.bytes.data() + before;
    for (const Index source : surface.source) row = std::copy_n(field.bytes.data() + source * bytes, bytes, row);
  }
  if (!surface.error.empty()) {
    auto& fields = output.extra_fields;
    const auto isError = [](const cloud::ExtraField& field) { return field.name == "error"; };
    fields.erase(std::remove_if(fields.begin(), fields.end(), isError), fields.end());
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(surface.error.data());
    fields.insert(fields.begin(),
                  {"error", cloud::ScalarType::kFloat32, 1, {bytes, bytes + surface.error.size() * sizeof(float)}});
  }
  output.width = surface.source.empty() ? input.width : static_cast<std::uint32_t>(output.positions.size());
  output.height = surface.source.empty() ? input.height : 1;
  output.viewpoint = input.viewpoint;
  return output;
}

void encodeStatistics(const simulation::Statistics& statistics, const CloudId& cloud, Statistics& message) {
  message.cloud = cloud.number;
  message.cloud_stamp = cloud.stamp;
  message.cloud_frame = cloud.frame;
  message.simulation_time = statistics.simulation_time;
  message.step = statistics.step;
  message.points = statistics.points;
  message.simulation_points = statistics.simulation_points;
  message.links = statistics.links;
  message.awake = statistics.awake;
  message.kinetic_energy = statistics.kinetic_energy;
  message.elastic_energy = statistics.elastic_energy;
  message.potential_energy = statistics.potential_energy;
  message.max_stretch = statistics.max_stretch;
  message.max_speed = statistics.max_speed;
  message.error_estimate = statistics.error_estimate;
  message.error_time = statistics.error_time;
  message.error_space = statistics.error_space;
  message.error_transfer = statistics.error_transfer;
  message.error_stiffness = statistics.error_stiffness;
  message.error_calibrated = statistics.error_calibrated;
  message.error_bounded = statistics.error_bounded;
  message.may_buckle = statistics.may_buckle;
  message.has_snapped = statistics.has_snapped;
  message.substeps = statistics.substeps;
  message.solver_iterations = statistics.solver_iterations;
  message.solver_residual = statistics.solver_residual;
  message.time_input = statistics.time_input;
  message.time_forces = statistics.time_forces;
  message.time_solve = statistics.time_solve;
  message.time_contact = statistics.time_contact;
  message.time_estimate = statistics.time_estimate;
  message.time_transfer = statistics.time_transfer;
  message.time_normals = statistics.time_normals;
  message.time_publish = statistics.time_publish;
  message.time_total = statistics.time_total;
  message.real_time_factor = statistics.real_time_factor;
  message.tracking_residual = statistics.tracking_residual;
  message.tracked_points = statistics.tracked_points;
  message.self_contacts = statistics.self_contacts;
  message.self_distance = statistics.self_distance;
  message.stopped_points = statistics.stopped_points;
  message.stopped_steps = statistics.stopped_steps;
  message.halted_steps = statistics.halted_steps;
  message.retried_steps = statistics.retried_steps;
  message.fallback_steps = statistics.fallback_steps;
  message.state_hash = statistics.state_hash;
  message.skipped = statistics.skipped;
  // Under their old names.
  message.springs = message.links;
  message.error_softening = message.error_stiffness;
  message.track_residual = message.tracking_residual;
  message.track_points = message.tracked_points;
}

}  // namespace deformable_surface::node
