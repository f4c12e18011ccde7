#include "simulate_run.h"

#include "simulate_files.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/cloud_filters.h"
#include "deformable_surface/io/load_scene.h"
#include "deformable_surface/io/mesh_output.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/ros/convert/find_package.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/robot_tools.h"
#include "deformable_surface/simulation/model_kind.h"

#include <set>
#include <utility>

namespace deformable_surface::node {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kRounding = 1e-9;  // of decimal fractions in double, relative

// RViz needs a frame; this one means "fixed in the world" everywhere (REP 105).
constexpr char kDefaultFrame[] = "map";

// A scene's expectations are for its own cloud and commands, after its own duration.
bool isOtherRun(const SimulateOptions& options, const SceneParams& params) {
  if (!options.bag_in.empty()) return true;
  const Value scene = io::loadYamlFile(options.scene);
  const Value* duration = scene.find("duration");
  if (!duration) return params.duration != SceneParams().duration;
  const double* real = duration->asReal();
  const std::int64_t* integer = duration->asInteger();
  return params.duration != (real ? *real : integer ? static_cast<double>(*integer) : 0.0);
}

}  // namespace

SceneParams loadScene(const SimulateOptions& options) {
  SceneParams params = io::loadScene(options.scene, options.assignments, findPackage);
  io::checkForSimulate(params, options.bag_in.empty());
  if (!params.robot.links.empty() && (options.bag_in.empty() || params.robot.file.empty()))
    throw InputError(
        "robot.links: found some without --bag_in, which has their frames, or without robot.file; accepted: both, or no links");
  return params;
}

void checkOptions(const SimulateOptions& options, const SceneParams& params) {
  const double dt = params.integrator.time_step;
  if (options.frame_rate * dt > 1.0 + kRounding) {
    throw InputError("--frame_rate: found " + formatReal(options.frame_rate) + "; accepted: at most one frame per step, " +
                     formatReal(1.0 / dt) + " (Hz)");
  }
  checkFilesDiffer(options, params);
  const bool is_other = isOtherRun(options, params);
  if (options.strict && (params.expect.empty() || is_other))
    throw InputError(std::string("--strict: found a scene ") +
                     (is_other ? "with another cloud or duration than its own" : "without expect") +
                     "; accepted: one that expects something of its own cloud and duration");
  if (!options.final_file.empty()) checkPointFile("--final", options.final_file);
  if (!options.mesh_file.empty()) {
    io::checkMeshFileName(options.mesh_file);
    requireWritable("--mesh", options.mesh_file);
    if (!simulation::findModel(params.model).traits().is_oriented)
      throw InputError("--mesh: found a scene of the model " + params.model +
                       "; accepted: " + simulation::listModels(&simulation::ModelTraits::is_oriented));
  }
  if (!options.filtered_file.empty()) checkPointFile("--filtered", options.filtered_file);
}

Run::Run(const SimulateOptions& options, const Terminal& terminal, KeptSurfaces* kept)
    : options_(options),
      terminal_(terminal),
      kept_(kept),
      params_(loadScene(options)),
      progress_(terminal.err, terminal.show_progress && !options.quiet) {
  setNumThreads(params_.threads);
  checkOptions(options, params_);
  if (!params_.expect.empty() && isOtherRun(options, params_)) {
    params_.expect.clear();
    note("expect is not checked: its bounds are for the scene's own cloud and duration");
  }
  if (!options.statistics_file.empty()) statistics_.emplace(options.statistics_file);
  if (!options.wrenches_file.empty()) wrenches_file_.emplace(options.wrenches_file);
  const double dt = params_.integrator.time_step;
  if (!options.frames_directory.empty()) {
    frames_.emplace(options.frames_directory, options.frame_rate > 0.0 ? options.frame_rate : params_.output.publish_rate, dt);
  }
  if (!options.bag_out.empty()) output_bag_.emplace(options.bag_out, params_.output.publish_rate, dt);
}

int Run::run() {
  noteIdleForces();
  if (options_.bag_in.empty()) {
    const Timer timer;
    std::unique_ptr<Simulation> simulation = buildOfScene();
    set_up_seconds_ += timer.seconds();
    begin(std::move(simulation), {}, 0);
  } else {
    bag_.emplace(
        options_.bag_in, options_.topics, options_.given_topics, DecodeLimits{params_.input.max_points},
        toNanoseconds(params_.integrator.time_step), [this](const std::string& cloud_frame) { return findFrame(cloud_frame); },
        params_.input.policy == simulation::InputPolicy::kReplace);
    tool_commands_.emplace(bag_->transforms(), params_.input.tool_timeout);
    if (!params_.robot.links.empty())
      tool_commands_->setStanding(makeRobotTools(readDescription(params_.robot.file), params_.robot.links));
    playBag();
  }
  stepUntil(end_);
  if (status_ == kInterrupted) {
    report("interrupted at t = " + formatShort(runTime()) + " s; no output is written" + keepTables());
    return kInterrupted + terminal_.stop.number;
  }
  finish();
  return status_;
}

// What there is of an interrupted run: it tells where the time went. Returns the end of a sentence about it.
std::string Run::keepTables() {
  std::string kept;
  const auto add = [&kept](const std::string& what) { kept += (kept.empty() ? ", except " : ", ") + what; };
  if (frames_) add("the frames");
  if (statistics_) {
    statistics_->finish();
    add("the rows of --statistics");
  }
  if (wrenches_file_) {
    wrenches_file_->finish();
    add("the rows of --wrenches");
  }
  return kept.empty() ? kept : kept + " until then";
}

// Filters the cloud. Returns notices about it.
std::vector<std::string> Run::filter(cloud::PointCloud& cloud) {
  const bool is_shown = !options_.filtered_file.empty() && !is_filtered_written_;
  const cloud::PointCloud before = is_shown ? cloud : cloud::PointCloud();
  io::FilterReport report = io::filterCloud(params_.input.filter, cloud);
  if (is_shown) io::writePointFile(options_.filtered_file, io::withRemovedBy(report, before));
  is_filtered_written_ = is_filtered_written_ || is_shown;
  if (!report.problem.empty()) throw InputError(report.problem);
  return report.notices;
}

std::unique_ptr<Simulation> Run::buildOfScene() {
  std::optional<KeptSurface> found;
  if (kept_ && options_.filtered_file.empty()) found = kept_->take(params_);
  if (!found) return build(io::loadCloud(params_, findPackage), "", 0);
  filter_notices_ = std::move(found->notices);
  return place(std::make_unique<Simulation>(params_, std::move(found->cloud), std::move(found->prepared)), "", 0);
}

std::unique_ptr<Simulation> Run::build(cloud::PointCloud cloud, const std::string& cloud_frame, std::int64_t stamp) {
  const InterruptScope scope(terminal_.stop.has_come);
  endIfInterrupted();
  filter_notices_ = filter(cloud);
  return place(std::make_unique<Simulation>(params_, std::move(cloud)), cloud_frame, stamp);
}

// Gives a surface its frame and its gravity.
std::unique_ptr<Simulation> Run::place(std::unique_ptr<Simulation> simulation, const std::string& cloud_frame,
                                       std::int64_t stamp) {
  simulation->setInterrupt(&terminal_.stop.has_come);
  const std::string frame = findFrame(cloud_frame);
  simulation->setGravity(findGravity(frame, stamp));
  frame_ = frame;
  return simulation;
}

// A surface at rest, whose time 0 is the stamp.
void Run::begin(std::unique_ptr<Simulation> simulation, const std::string& cloud_frame, std::int64_t stamp) {
  if (!simulation_) {
    run_start_ = stamp;
    end_ = stamp + toNanoseconds(params_.duration);
  }
  simulation_ = std::move(simulation);
  if (tool_commands_) tool_commands_->forget();
  start_ = stamp;
  note(std::to_string(simulation_->input().size()) + " input points");
  for (const std::string& line : filter_notices_) note(line);
  for (const std::string& line : simulation_->buildNotes()) note(line);
  for (const std::string& line : simulation_->buildWarnings()) warn(line);
  ++cloud_.number;
  cloud_.stamp.fromNSec(static_cast<std::uint64_t>(stamp));
  cloud_.frame = cloud_frame;
  if (output_bag_) output_bag_->begin(frame_, cloud_, *simulation_);
  writeState();
}

std::string Run::findFrame(const std::string& cloud_frame) const {
  return !params_.frame_id.empty() ? params_.frame_id : !cloud_frame.empty() ? cloud_frame : kDefaultFrame;
}

// In the surface's frame.
Vec3 Run::findGravity(const std::string& frame, std::int64_t stamp) const {
  if (params_.gravity_frame.empty() || params_.gravity_frame == frame) return params_.gravity;
  if (!bag_) {
    throw InputError("gravity_frame: found " + quote(params_.gravity_frame) +
                     " without a bag that has transforms; accepted: the surface's frame, " + quote(frame));
  }
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp));
  return findTransform("gravity_frame", params_.gravity_frame, frame, time, bag_->transforms()).linear() * params_.gravity;
}

// The surface's frame may turn during the simulation. After the last transform the last direction stays.
void Run::updateGravity() {
  if (params_.gravity_frame.empty() || !bag_) return;
  try {
    simulation_->setGravity(findGravity(frame_, now()));
  } catch (const InputError&) {}
}

void Run::moveTools() {
  if (!tool_commands_) return;
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(timeOf(simulation_->stepCount() + 1)));
  for (const std::string& problem : tool_commands_->move(time, *simulation_, frame_)) note(problem);
}

// Takes the steps that end at or before the stamp.
void Run::stepUntil(std::int64_t stamp) {
  const std::int64_t most_of_step = toNanoseconds(0.99 * params_.integrator.time_step);  // the rest is for rounding
  while (canStep() && now() + most_of_step <= stamp) step();
}

bool Run::canStep() const { return status_ == kDone && now() + toNanoseconds(0.99 * params_.integrator.time_step) <= end_; }

void Run::step() {
  if (isInterrupted()) return;
  updateGravity();
  moveTools();
  const simulation::StepOutcome outcome = simulation_->step();
  if (!outcome.notice.empty()) note(outcome.notice);
  if (!outcome.ok && isInterrupted()) return;
  if (!outcome.ok) {
    status_ = kNoSoundStep;
    report(outcome.problem);
    return;
  }
  writeState();
  if (statistics_) statistics_->add(simulation_->statistics());
  if (wrenches_file_) wrenches_file_->add(*simulation_);
  ++steps_;
  progress_.update(runTime(), params_.duration);
}

bool Run::isInterrupted() {
  if (terminal_.stop.has_come) status_ = kInterrupted;
  return status_ == kInterrupted;
}

void Run::writeState() {
  if (frames_) frames_->add(runTime(), *simulation_);
  const std::set<std::string> silent = tool_commands_ ? tool_commands_->silent() : std::set<std::string>();
  if (output_bag_) output_bag_->add(runTime(), now(), silent, *simulation_);
}

}  // namespace deformable_surface::node
