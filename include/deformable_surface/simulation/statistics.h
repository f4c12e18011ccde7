// Results and costs of a step: the fields of Statistics.msg and of the CSV, in one list.
#pragma once

#include "deformable_surface/base/types.h"

#include <limits>
#include <string>
#include <vector>

namespace deformable_surface::simulation {

struct Statistics {
  double simulation_time = 0.0;  // s
  std::uint64_t step = 0;
  std::uint32_t points = 0, simulation_points = 0, links = 0, awake = 0;
  double kinetic_energy = 0.0, elastic_energy = 0.0, potential_energy = 0.0;  // J
  double max_stretch = 0.0;                                                   // |l / l0 - 1|
  double max_speed = 0.0;                                                     // m/s
  // m; NaN without an estimate; the sum is infinite where nothing can be said
  double error_estimate = std::numeric_limits<double>::quiet_NaN();
  double error_time = std::numeric_limits<double>::quiet_NaN();
  double error_space = std::numeric_limits<double>::quiet_NaN();
  double error_transfer = std::numeric_limits<double>::quiet_NaN();
  double error_stiffness = std::numeric_limits<double>::quiet_NaN();
  bool error_calibrated = false;  // the numbers of points are such that the estimate was found to cover the error
  bool error_bounded = false;     // the estimate is meant as a bound; if not, small differences may grow beyond it
  bool may_buckle = false;        // where the points do not show it, by the error estimate
  bool has_snapped = false;       // see Simulation::hasSnapped()
  std::uint32_t substeps = 0, solver_iterations = 0;
  bool is_quasi_newton = false;  // these cost a few passes of forces each; not in Statistics.msg
  double solver_residual = 0.0;  // N
  // s of wall time of the last step
  double time_input = 0.0, time_forces = 0.0, time_solve = 0.0, time_contact = 0.0, time_estimate = 0.0, time_transfer = 0.0,
         time_normals = 0.0, time_publish = 0.0, time_total = 0.0;
  double real_time_factor = 0.0;  // time step over time_total
  // m, rms distance from the tracked cloud; NaN without one
  double tracking_residual = std::numeric_limits<double>::quiet_NaN();
  std::uint32_t tracked_points = 0;                                // simulation points that the tracked cloud shows
  std::uint32_t self_contacts = 0;                                 // pairs of parts of the surface that push each other apart
  double self_distance = std::numeric_limits<double>::infinity();  // m, of the nearest of these pairs; infinite: there is none
  std::uint32_t stopped_points = 0;  // simulation points that were stopped short in the last step, before parts met
  // Steps since rest in which contact limited the motion of points; took all motion of the parts that it stopped, in a sub-step
  // at least; that were not sound at first and were taken again; that another integrator than the chosen one took, at least in
  // part.
  std::uint64_t stopped_steps = 0, halted_steps = 0, retried_steps = 0, fallback_steps = 0;
  std::uint64_t state_hash = 0;
  std::vector<std::string> skipped;  // stages that were not run because nobody needed them
};

/// Calls visitor(name, value) for every field in the order of Statistics.msg.
template <class Visitor>
void visitFields(const Statistics& s, Visitor&& visitor) {
  visitor("simulation_time", s.simulation_time);
  visitor("step", s.step);
  visitor("points", s.points);
  visitor("simulation_points", s.simulation_points);
  visitor("links", s.links);
  visitor("awake", s.awake);
  visitor("kinetic_energy", s.kinetic_energy);
  visitor("elastic_energy", s.elastic_energy);
  visitor("potential_energy", s.potential_energy);
  visitor("max_stretch", s.max_stretch);
  visitor("max_speed", s.max_speed);
  visitor("error_estimate", s.error_estimate);
  visitor("error_time", s.error_time);
  visitor("error_space", s.error_space);
  visitor("error_transfer", s.error_transfer);
  visitor("error_stiffness", s.error_stiffness);
  visitor("error_calibrated", s.error_calibrated);
  visitor("error_bounded", s.error_bounded);
  visitor("may_buckle", s.may_buckle);
  visitor("has_snapped", s.has_snapped);
  visitor("substeps", s.substeps);
  visitor("solver_iterations", s.solver_iterations);
  visitor("solver_residual", s.solver_residual);
  visitor("time_input", s.time_input);
  visitor("time_forces", s.time_forces);
  visitor("time_solve", s.time_solve);
  visitor("time_contact", s.time_contact);
  visitor("time_estimate", s.time_estimate);
  visitor("time_transfer", s.time_transfer);
  visitor("time_normals", s.time_normals);
  visitor("time_publish", s.time_publish);
  visitor("time_total", s.time_total);
  visitor("real_time_factor", s.real_time_factor);
  visitor("tracking_residual", s.tracking_residual);
  visitor("tracked_points", s.tracked_points);
  visitor("self_contacts", s.self_contacts);
  visitor("self_distance", s.self_distance);
  visitor("stopped_points", s.stopped_points);
  visitor("stopped_steps", s.stopped_steps);
  visitor("halted_steps", s.halted_steps);
  visitor("retried_steps", s.retried_steps);
  visitor("fallback_steps", s.fallback_steps);
  visitor("state_hash", s.state_hash);
  visitor("skipped", s.skipped);
}

}  // namespace deformable_surface::simulation
