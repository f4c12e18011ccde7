// The end of a run: files, quantities and expectations, and the lines that a run prints.
#include "simulate_run.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/io/mesh_output.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/io/scene_old_names.h"
#include "deformable_surface/model/curved_triangles.h"
#include "deformable_surface/simulation/expectations.h"
#include "deformable_surface/simulation/loads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace deformable_surface::node {

void Run::finish() {
  const double wall_time = timer_.seconds();
  progress_.clear();
  const std::string lasting = simulation_->lastingNotices();
  if (!lasting.empty()) note("until the end of the run: " + lasting);
  if (!options_.final_file.empty()) {
    const simulation::Surface& surface = simulation_->surface(true);
    io::writePointFile(options_.final_file, makeOutputCloud(surface, simulation_->input()), surface.displacement);
  }
  if (!options_.mesh_file.empty()) writeMesh();
  if (statistics_) statistics_->finish();
  if (wrenches_file_) wrenches_file_->finish();
  if (output_bag_) output_bag_->finish();
  measure();
  if (options_.quiet && !options_.strict) return;
  if (bag_) noteBag();
  if (status_ == kDone) checkExpectations();
  if (options_.quiet) return;

  const simulation::Statistics statistics = simulation_->statistics();
  float largest = 0.0f;
  for (const float displacement : simulation_->surface(false).displacement) largest = std::max(largest, displacement);
  char text[500];
  std::snprintf(text, sizeof text,
                "points                %u\nsimulation points     %u\nsteps                 %llu\nsimulated time        %g s\n"
                "wall time             %.3f s, %.3f s of it for set-up\nreal-time factor      %.3g (without set-up)\n"
                "largest displacement  %.6g m (at the end)\n"
                "state hash            %016llx\n"
                "  as in messages      %llu\n",
                statistics.points, statistics.simulation_points, steps_, runTime(), wall_time, set_up_seconds_,
                runTime() / (wall_time - set_up_seconds_), largest, static_cast<unsigned long long>(statistics.state_hash),
                static_cast<unsigned long long>(statistics.state_hash));
  terminal_.out << text << std::flush;
}

void Run::writeMesh() {
  const model::State& state = simulation_->state();
  if (const model::Links* links = simulation_->model().links()) links->refreshDisplay(state);
  Points normals;
  for (const Quaternion& q : state.orientations) normals.push_back(q * Vec3::UnitZ());
  const model::CurvedTriangles curved =
      model::curveTriangles(state.positions, normals, trianglesOf(simulation_->model()), options_.mesh_pieces);
  std::vector<std::array<Index, 3>> triangles;
  for (const model::WeightedTriangle& t : curved.triangles) triangles.push_back({t.corner[0], t.corner[1], t.corner[2]});
  io::writeMeshFile(options_.mesh_file, curved.positions, curved.normals, triangles);
}

// A quantity that does not exist, such as the volume of an open surface, is a note.
void Run::measure() {
  for (const std::string& name : options_.measured) {
    const std::string quantity = io::findNewQuantity(name);
    if (quantity != name) note(io::describeNewName("the quantity " + name, quantity));
    try {
      const double found = simulation::computeQuantity(quantity, *simulation_);
      terminal_.out << "measured " << name << ' ' << formatExactly(found) << '\n';
      const simulation::Statistics now = simulation_->statistics();
      if (quantity == "error_estimate" && std::isinf(found))
        note("error_estimate is measured as infinite: " +
             (std::isfinite(now.error_estimate)
                  ? "error_bounded is false, so that the estimate, " + formatReal(now.error_estimate) + " m, is no bound"
                  : std::string("nothing can be said about the error (docs/faq.md)")));
    } catch (const InputError& error) {
      for (const std::string& problem : error.problems()) note("--measure: " + problem);
    }
  }
}

void Run::checkExpectations() {
  std::vector<std::string> violations;
  try {
    violations = simulation::checkExpectations(*simulation_);
  } catch (const InputError& error) {
    violations = error.problems();
  }
  for (const std::string& violation : violations)
    options_.strict ? report("not as expected: " + violation) : note("not as expected: " + violation);
  if (options_.strict && !violations.empty() && status_ == kDone) status_ = kNotAsExpected;
}

void Run::noteIdleForces() {
  for (const simulation::ForceParams& force : params_.forces) {
    if (simulation::actsInAStep(force, params_.integrator.time_step, params_.duration)) continue;
    note("force " + quote(force.id) + " acts in no step: its time begins at " + formatReal(force.start) + " s and ends at " +
         formatReal(force.end) + " s, the run has steps of " + formatReal(params_.integrator.time_step) + " s from 0 s to " +
         formatReal(params_.duration) + " s");
  }
}

void Run::warn(const std::string& line) {
  progress_.clear();
  if (!options_.quiet) terminal_.out << "warning: " << line << '\n';
}

void Run::note(const std::string& line) {
  progress_.clear();
  if (!options_.quiet && line != last_note_) terminal_.out << "note: " << line << '\n';
  last_note_ = line;
}

void Run::report(const std::string& line) {
  progress_.clear();
  terminal_.err << "simulate: " << line << '\n';
}

void Run::reportRefusal(const std::string& what, std::int64_t stamp, const InputError& error) {
  for (const std::string& problem : error.problems()) {
    report(options_.bag_in + ", " + what + " with the stamp " + formatReal(static_cast<double>(stamp) * 1e-9) + " s: " + problem);
  }
}

}  // namespace deformable_surface::node
