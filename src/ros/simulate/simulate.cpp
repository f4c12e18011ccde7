#include "simulate.h"

#include "kept_surfaces.h"
#include "progress_bar.h"
#include "simulate_bag.h"
#include "simulate_files.h"
#include "simulate_options.h"
#include "simulate_outputs.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/version.h"
#include "deformable_surface/io/cloud_filters.h"
#include "deformable_surface/io/load_scene.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/scene_old_names.h"
#include "deformable_surface/ros/convert/commands.h"
#include "deformable_surface/ros/convert/find_package.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/robot_tools.h"
#include "deformable_surface/ros/convert/surface_output.h"
#include "deformable_surface/ros/convert/tool_commands.h"
#include "deformable_surface/simulation/expectations.h"
#include "deformable_surface/simulation/loads.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <type_traits>

namespace deformable_surface::node {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr int kDone = 0, kWrongInput = 2, kNoSoundStep = 3, kNotAsExpected = 4, kInterrupted = 128;

// RViz shows nothing without a frame, and this one means "fixed in the world" everywhere (REP 105).
constexpr char kDefaultFrame[] = "map";

// What a scene expects holds for its own cloud and commands, after its own duration.
bool isOtherRun(const SimulateOptions& options, const SceneParams& params) {
  if (!options.bag_in.empty()) return true;
  const Value scene = io::loadYamlFile(options.scene);
  const Value* duration = scene.find("duration");
  if (!duration) return params.duration != SceneParams().duration;
  const double* real = duration->asReal();
  const std::int64_t* integer = duration->asInteger();
  return params.duration != (real ? *real : integer ? static_cast<double>(*integer) : 0.0);
}

SceneParams loadScene(const SimulateOptions& options) {
  SceneParams params = io::loadScene(options.scene, options.assignments, findPackage);
  io::checkForSimulate(params, options.bag_in.empty());
  if (!params.robot.links.empty() && (options.bag_in.empty() || params.robot.file.empty()))
    throw InputError(
        "robot.links: found some without --bag_in, which has their frames, or without robot.file; accepted: both, or no links");
  return params;
}

/// One run: surfaces from the scene or the bag, one after the other, and the outputs.
class Run {
 public:
  Run(const SimulateOptions& options, const Terminal& terminal, KeptSurfaces* kept)
      : options_(options),
        terminal_(terminal),
        kept_(kept),
        params_(loadScene(options)),
        progress_(terminal.err, terminal.show_progress && !options.quiet) {
    setNumThreads(params_.threads);
    const double dt = params_.integrator.time_step;
    if (options.frame_rate * dt > 1.0 + kRounding) {
      throw InputError("--frame_rate: found " + formatReal(options.frame_rate) + "; accepted: at most one frame per step, " +
                       formatReal(1.0 / dt) + " (Hz)");
    }
    checkFilesDiffer(options, params_);
    const bool is_other = isOtherRun(options, params_);
    if (options.strict && (params_.expect.empty() || is_other))
      throw InputError(std::string("--strict: found a scene ") +
                       (is_other ? "with another cloud or duration than its own" : "without expect") +
                       "; accepted: one that expects something of its own cloud and duration");
    if (!params_.expect.empty() && is_other) {
      params_.expect.clear();
      note("what the scene expects is not looked at: it is of the scene's own cloud and duration");
    }
    if (!options.final_file.empty()) checkPointFile("--final", options.final_file);
    if (!options.filtered_file.empty()) checkPointFile("--filtered", options.filtered_file);
    if (!options.statistics_file.empty()) statistics_.emplace(options.statistics_file);
    if (!options.wrenches_file.empty()) wrenches_file_.emplace(options.wrenches_file);
    if (!options.frames_directory.empty()) {
      frames_.emplace(options.frames_directory, options.frame_rate > 0.0 ? options.frame_rate : params_.output.publish_rate, dt);
    }
    if (!options.bag_out.empty()) output_bag_.emplace(options.bag_out, params_.output.publish_rate, dt);
  }

  int run() {
    noteIdleForces();
    if (options_.bag_in.empty()) {
      begin(buildOfScene(), {}, 0);
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
      report("interrupted at t = " + formatReal(runTime()) + " s; nothing is written" +
             (frames_ ? " but the frames until then" : ""));
      return kInterrupted + terminal_.stop.number;
    }
    finish();
    return status_;
  }

 private:
  static constexpr double kRounding = 1e-9;  // of decimal fractions in double, relative

  // The bag's messages in the order of their stamps, and the steps between them.
  void playBag() {
    std::vector<InputBag::Event> waiting;  // commands that came before the first cloud
    for (const auto& [stamp, entry] : bag_->entries()) {
      if (status_ != kDone || (simulation_ && stamp >= end_)) {
        if (not_taken_++ == 0) first_not_taken_ = stamp;
        continue;
      }
      InputBag::Event event = bag_->read(stamp, entry);
      if (auto* cloud = std::get_if<DecodedCloud>(&event.message)) {
        takeCloud(std::move(*cloud), event.stamp);
        if (simulation_) {
          for (const InputBag::Event& command : waiting) takeCommand(command);
          waiting.clear();
        }
      } else if (simulation_) {
        takeCommand(event);
      } else {
        waiting.push_back(std::move(event));
      }
    }
    if (!simulation_) throw InputError(options_.bag_in + ": found no cloud that can be simulated; accepted: at least one");
  }

  // A cloud that is refused changes nothing.
  void takeCloud(DecodedCloud decoded, std::int64_t stamp) {
    if (simulation_ && params_.input.policy == simulation::InputPolicy::kIgnore) return;
    if (simulation_ && params_.input.policy == simulation::InputPolicy::kTrack) return track(decoded, stamp);
    std::unique_ptr<Simulation> simulation;
    const std::string cloud_frame = decoded.header.frame_id;
    try {
      if (!decoded.ok()) throw InputError(decoded.problem);
      bringInto(findFrame(cloud_frame), stamp, decoded);
      simulation = build(std::move(decoded.cloud), cloud_frame, stamp);
    } catch (const InputError& error) {
      return reportRefusal("cloud", stamp, error);
    }
    // The old surface takes the steps that end before the new one is there.
    if (simulation_) stepUntil(stamp);
    if (status_ != kDone) return;
    begin(std::move(simulation), cloud_frame, stamp);
    ++clouds_;
  }

  void track(DecodedCloud& decoded, std::int64_t stamp) {
    while (canStep() && now() < stamp) step();
    try {
      if (!decoded.ok()) throw InputError(decoded.problem);
      bringInto(frame_, stamp, decoded);
      filter(decoded.cloud);
      simulation_->observe(decoded.cloud);
    } catch (const InputError& error) {
      reportRefusal("cloud", stamp, error);
    }
  }

  // Takes effect at the first step that begins at or after the stamp.
  void takeCommand(const InputBag::Event& event) {
    while (canStep() && now() < event.stamp) step();
    const SeenTransform* const seen = event.seen ? &*event.seen : nullptr;
    try {
      if (!event.unknown_frame.empty())
        throw InputError("header.frame_id: found " + quote(event.unknown_frame) + " without a stamp, and no transform to " +
                         quote(frame_) + " when it was recorded or soon after; accepted: frames that tf knows then");
      if (const auto* force = std::get_if<PointForce>(&event.message)) {
        simulation_->setForce(toForce(*force, simulation_->time(), frame_, bag_->transforms(), seen));
        ++forces_;
      } else if (const auto* wrench = std::get_if<geometry_msgs::WrenchStamped>(&event.message)) {
        simulation_->setForce(toForce(*wrench, simulation_->time(), frame_, bag_->transforms(), params_.force, seen));
        ++wrenches_;
      } else {
        const DecodedTools& decoded = std::get<DecodedTools>(event.message);
        if (!decoded.ok()) throw InputError(decoded.problem);
        for (const Tool& tool : decoded.tools) tool_commands_->apply(tool, *simulation_, frame_, seen);
        tools_ += decoded.tools.size();
      }
    } catch (const InputError& error) {
      reportRefusal("command", event.stamp, error);
    }
  }

  // What became of the cloud, for notices.
  std::vector<std::string> filter(cloud::PointCloud& cloud) {
    const bool is_shown = !options_.filtered_file.empty() && !is_filtered_written_;
    const cloud::PointCloud before = is_shown ? cloud : cloud::PointCloud();
    io::FilterReport report = io::filterCloud(params_.input.filter, cloud);
    if (is_shown) io::writePointFile(options_.filtered_file, io::withRemovedBy(report, before));
    is_filtered_written_ = is_filtered_written_ || is_shown;
    if (!report.problem.empty()) throw InputError(report.problem);
    return report.notices;
  }

  std::unique_ptr<Simulation> buildOfScene() {
    std::optional<KeptSurface> found;
    if (kept_ && options_.filtered_file.empty()) found = kept_->take(params_);
    if (!found) return build(io::loadCloud(params_, findPackage), "", 0);
    filter_notices_ = std::move(found->notices);
    return place(std::make_unique<Simulation>(params_, std::move(found->cloud), std::move(found->prepared)), "", 0);
  }

  std::unique_ptr<Simulation> build(cloud::PointCloud cloud, const std::string& cloud_frame, std::int64_t stamp) {
    const InterruptScope scope(terminal_.stop.has_come);
    endIfInterrupted();
    filter_notices_ = filter(cloud);
    return place(std::make_unique<Simulation>(params_, std::move(cloud)), cloud_frame, stamp);
  }

  // Into its frame.
  std::unique_ptr<Simulation> place(std::unique_ptr<Simulation> simulation, const std::string& cloud_frame, std::int64_t stamp) {
    simulation->setInterrupt(&terminal_.stop.has_come);
    const std::string frame = findFrame(cloud_frame);
    simulation->setGravity(findGravity(frame, stamp));
    frame_ = frame;
    return simulation;
  }

  // A surface at rest, whose time 0 is the stamp.
  void begin(std::unique_ptr<Simulation> simulation, const std::string& cloud_frame, std::int64_t stamp) {
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

  std::string findFrame(const std::string& cloud_frame) const {
    return !params_.frame_id.empty() ? params_.frame_id : !cloud_frame.empty() ? cloud_frame : kDefaultFrame;
  }

  // A recorded cloud, by the transforms of its bag.
  void bringInto(const std::string& frame, std::int64_t stamp, DecodedCloud& decoded) const {
    ros::Time time;
    time.fromNSec(static_cast<std::uint64_t>(stamp));
    transformCloud(findTransform("header.frame_id", decoded.header.frame_id, frame, time, bag_->transforms()), decoded.cloud);
  }

  // In the surface's frame.
  Vec3 findGravity(const std::string& frame, std::int64_t stamp) const {
    if (params_.gravity_frame.empty() || params_.gravity_frame == frame) return params_.gravity;
    if (!bag_) {
      throw InputError("gravity_frame: found " + quote(params_.gravity_frame) +
                       " without a bag that has transforms; accepted: the surface's frame, " + quote(frame));
    }
    ros::Time time;
    time.fromNSec(static_cast<std::uint64_t>(stamp));
    return findTransform("gravity_frame", params_.gravity_frame, frame, time, bag_->transforms()).linear() * params_.gravity;
  }

  // The surface's frame may turn while it is simulated. Beyond the last transform the last direction stays.
  void updateGravity() {
    if (params_.gravity_frame.empty() || !bag_) return;
    try {
      simulation_->setGravity(findGravity(frame_, now()));
    } catch (const InputError&) {}
  }

  void moveTools() {
    if (!tool_commands_) return;
    ros::Time time;
    time.fromNSec(static_cast<std::uint64_t>(timeOf(simulation_->stepCount() + 1)));
    for (const std::string& problem : tool_commands_->move(time, *simulation_, frame_)) note(problem);
  }

  // Takes the steps that end at or before the stamp.
  void stepUntil(std::int64_t stamp) {
    const std::int64_t most_of_step = toNanoseconds(0.99 * params_.integrator.time_step);  // the rest is for rounding
    while (canStep() && now() + most_of_step <= stamp) step();
  }

  bool canStep() const { return status_ == kDone && now() + toNanoseconds(0.99 * params_.integrator.time_step) <= end_; }

  void step() {
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

  bool isInterrupted() {
    if (terminal_.stop.has_come) status_ = kInterrupted;
    return status_ == kInterrupted;
  }

  void writeState() {
    if (frames_) frames_->add(runTime(), *simulation_);
    const std::set<std::string> silent = tool_commands_ ? tool_commands_->silent() : std::set<std::string>();
    if (output_bag_) output_bag_->add(runTime(), now(), silent, *simulation_);
  }

  void finish() {
    const double wall_time = timer_.seconds();
    progress_.clear();
    if (!options_.final_file.empty()) {
      const simulation::Surface& surface = simulation_->surface(true);
      io::writePointFile(options_.final_file, makeOutputCloud(surface, simulation_->input()), surface.displacement);
    }
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
    char text[400];
    std::snprintf(text, sizeof text,
                  "points                %u\nsimulation points     %u\nsteps                 %llu\nsimulated time        %g s\n"
                  "wall time             %.3f s\nreal-time factor      %.3g\nlargest displacement  %.6g m (at the end)\n"
                  "state hash            %016llx\n",
                  statistics.points, statistics.simulation_points, steps_, runTime(), wall_time, runTime() / wall_time, largest,
                  static_cast<unsigned long long>(statistics.state_hash));
    terminal_.out << text << std::flush;
  }

  void noteIdleForces() {
    for (const simulation::ForceParams& force : params_.forces) {
      if (simulation::actsInAStep(force, params_.integrator.time_step, params_.duration)) continue;
      note("force " + quote(force.id) + " acts in no step: its time begins at " + formatReal(force.start) + " s and ends at " +
           formatReal(force.end) + " s, the run has steps of " + formatReal(params_.integrator.time_step) + " s from 0 s to " +
           formatReal(params_.duration) + " s");
    }
  }

  // What was taken of the bag, and what was not.
  void noteBag() {
    note("taken from " + options_.bag_in + ": clouds " + std::to_string(clouds_) + ", forces " + std::to_string(forces_) +
         ", wrenches " + std::to_string(wrenches_) + ", commands to tools " + std::to_string(tools_));
    if (not_taken_ == 0) return;
    const auto findTime = [this](std::int64_t stamp) { return formatShort(static_cast<double>(stamp - run_start_) * 1e-9); };
    note("not taken from " + options_.bag_in + ": " + std::to_string(not_taken_) + " of " +
         std::to_string(bag_->entries().size()) + " clouds and commands, from " + findTime(first_not_taken_) + " to " +
         findTime(bag_->entries().rbegin()->first) + " s after the first cloud; the run ended at " + formatShort(runTime()) +
         " s; --duration S sets its end");
  }

  // What there is not, such as the volume of an open surface, is a note.
  void measure() {
    for (const std::string& name : options_.measured) {
      const std::string quantity = io::findNewQuantity(name);
      if (quantity != name) note(io::tellNewName("the quantity " + name, quantity));
      char text[32];
      try {
        std::snprintf(text, sizeof text, "%.17g", simulation::computeQuantity(quantity, *simulation_));
        terminal_.out << "measured " << name << ' ' << text << '\n';
      } catch (const InputError& error) {
        for (const std::string& problem : error.problems()) note("--measure: " + problem);
      }
    }
  }

  void checkExpectations() {
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

  // Stamp of the state, ns, and time since the run began, s.
  std::int64_t now() const { return timeOf(simulation_->stepCount()); }
  // When a step begins, as the node has it.
  std::int64_t timeOf(std::uint64_t step) const {
    return start_ + toNanoseconds(static_cast<double>(step) * params_.integrator.time_step);
  }
  double runTime() const { return static_cast<double>(start_ - run_start_) * 1e-9 + simulation_->time(); }
  static std::int64_t toNanoseconds(double seconds) { return std::llround(seconds * 1e9); }

  void warn(const std::string& line) {
    progress_.clear();
    if (!options_.quiet) terminal_.out << "warning: " << line << '\n';
  }
  void note(const std::string& line) {
    progress_.clear();
    if (!options_.quiet && line != last_note_) terminal_.out << "note: " << line << '\n';
    last_note_ = line;
  }
  void report(const std::string& line) {
    progress_.clear();
    terminal_.err << "simulate: " << line << '\n';
  }
  void reportRefusal(const std::string& what, std::int64_t stamp, const InputError& error) {
    for (const std::string& problem : error.problems()) {
      report(options_.bag_in + ", " + what + " with the stamp " + formatReal(static_cast<double>(stamp) * 1e-9) +
             " s: " + problem);
    }
  }

  const SimulateOptions& options_;
  const Terminal& terminal_;
  KeptSurfaces* const kept_;
  SceneParams params_;
  ProgressBar progress_;
  std::optional<StatisticsFile> statistics_;
  std::optional<WrenchesFile> wrenches_file_;
  std::optional<FrameFiles> frames_;
  std::optional<OutputBag> output_bag_;

  std::optional<InputBag> bag_;
  std::optional<ToolCommands> tool_commands_;  // with the bag
  std::unique_ptr<Simulation> simulation_;
  std::vector<std::string> filter_notices_;  // of its cloud
  bool is_filtered_written_ = false;
  CloudId cloud_;
  std::string frame_;
  std::int64_t run_start_ = 0, start_ = 0, end_ = 0;  // ns: time 0 of the run and of this surface, and the end
  unsigned long long steps_ = 0, clouds_ = 0, forces_ = 0, wrenches_ = 0, tools_ = 0;  // taken; all but the first from the bag
  std::size_t not_taken_ = 0;                                                          // of the bag, since the run ended before
  std::int64_t first_not_taken_ = 0;                                                   // ns
  int status_ = kDone;
  std::string last_note_;
  Timer timer_;
};

}  // namespace

namespace {

// What other programs ask for before they run many scenes: the columns of numbers that --statistics writes.
void listColumns(std::ostream& out) {
  simulation::visitFields(simulation::Statistics(), [&](const std::string& name, const auto& value) {
    if constexpr (std::is_arithmetic<std::decay_t<decltype(value)>>::value) out << "statistics " << name << '\n';
  });
}

}  // namespace

void prepare(const std::vector<std::string>& arguments, KeptSurfaces& kept) {
  try {
    const SimulateOptions options = parseOptions(arguments);
    if (options.bag_in.empty() && !options.check) kept.make(loadScene(options));
  } catch (const std::exception&) {}
}

int simulate(const std::vector<std::string>& arguments, const Terminal& terminal, KeptSurfaces* kept) {
  const auto report = [&](const std::string& line) { terminal.err << "simulate: " << line << '\n'; };
  try {
    const SimulateOptions options = parseOptions(arguments);
    if (options.help) {
      terminal.out << describeOptions();
      return kDone;
    }
    if (options.version) {
      terminal.out << version() << '\n';
      return kDone;
    }
    if (options.check) {
      loadScene(options);
      listColumns(terminal.out);
      return kDone;
    }
    return Run(options, terminal, kept).run();
  } catch (const InputError& error) {
    for (const std::string& problem : error.problems()) report(problem);
  } catch (const Interrupted&) {
    report("interrupted while a surface was built; no state of it is written");
    return kInterrupted + terminal.stop.number;
  } catch (const std::exception& error) {
    report(std::string("stopped: ") + error.what());
  }
  return kWrongInput;
}

}  // namespace deformable_surface::node
