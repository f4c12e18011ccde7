#include "node_diagnostics.h"

#include "deformable_surface/base/value.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/console.h>

namespace deformable_surface::node {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using std::chrono::steady_clock;

// Diagnostics are expected about once a second. Changes are reported sooner, but a flood of bad clouds must not become one of
// reports.
constexpr std::chrono::milliseconds kPeriod(1000), kShortest(50);
constexpr double kWatchPeriod = 1.0;           // s
constexpr double kLongStep = 1.0;              // s of wall time: a longer step is reported while it runs
constexpr std::chrono::seconds kLogPeriod(5);  // in the log

}  // namespace

NodeDiagnostics::NodeDiagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                                 const ros::NodeHandle& watch_node, const Stepper& stepper, const Inbox& inbox,
                                 const WarningLog& warnings)
    : stepper_(stepper),
      inbox_(inbox),
      warnings_(warnings),
      name_(private_node.getNamespace().substr(1)),
      updater_(node, private_node, private_node.getNamespace()),
      last_time_(steady_clock::now()) {
  topic_ = ros::NodeHandle(node).advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 1);
  updater_.setHardwareID("none");
  updater_.add("input", [this](Status& status) { describeInput(status); });
  updater_.add("simulation", [this](Status& status) { describeSimulation(status); });
  watch_ = watch_node.createWallTimer(ros::WallDuration(kWatchPeriod), [this](const ros::WallTimerEvent&) { watchStep(); });
}

// Replaces the updater's message, which only the simulation thread may make.
void NodeDiagnostics::watchStep() {
  const double seconds = stepper_.secondsInStep();
  if (!(seconds > kLongStep)) return;
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  message.status.resize(1);
  message.status[0].name = name_ + ": simulation";
  message.status[0].hardware_id = "none";
  message.status[0].level = DiagnosticStatus::WARN;
  message.status[0].message = "a step has been going on for " + formatShort(seconds) + " s";
  topic_.publish(message);
  // Not a warning, which would outlast the step. By wall time, since /clock may stand still.
  const auto now = steady_clock::now();
  if (now - last_warning_ < kLogPeriod) return;
  last_warning_ = now;
  ROS_WARN_STREAM(warnings_.name() << ": " << message.status[0].message << "; ~reset ends it");
}

NodeDiagnostics::Happened NodeDiagnostics::observe() const {
  const StepperStatus status = stepper_.status();
  return {status.state,
          status.clouds_accepted + status.clouds_ignored + status.clouds_tracked,
          warnings_.count(Warning::kCloudRefused),
          warnings_.last(),
          status.commands_waiting,
          status.jumps_back};
}

Inbox::SteadyTime NodeDiagnostics::nextTime() const { return last_time_ + (observe() == published_ ? kPeriod : kShortest); }

void NodeDiagnostics::update() {
  const auto now = steady_clock::now();
  if (now < nextTime()) return;
  period_ = std::chrono::duration<double>(now - last_time_).count();
  last_time_ = now;
  published_ = observe();
  now_ = stepper_.status();
  if (topic_.getNumSubscribers() > 0) updater_.force_update();
  last_ = now_;
}

void NodeDiagnostics::describeInput(Status& status) const {
  const int refused = warnings_.count(Warning::kCloudRefused);
  if (warnings_.isRecent()) {
    status.summary(DiagnosticStatus::WARN, warnings_.last());
  } else if (!now_.silent_tools.empty()) {
    status.summary(DiagnosticStatus::WARN, "silent tools: " + now_.silent_tools);
  } else {
    status.summary(DiagnosticStatus::OK, "ok");
  }
  status.add("clouds received", now_.clouds_received);
  status.add("clouds accepted", now_.clouds_accepted);
  status.add("clouds that came again", now_.clouds_again);
  status.add("clouds refused", refused);
  status.add("clouds ignored by policy", now_.clouds_ignored);
  status.add("clouds tracked", now_.clouds_tracked);
  status.add("clouds late", now_.clouds_late);
  status.add("clouds replaced before they were built", inbox_.numCloudsReplaced() + now_.clouds_dropped);
  status.add("commands applied", now_.commands_applied);
  status.add("commands late", now_.commands_late);
  status.add("commands waiting", now_.commands_waiting);
  status.add("commands refused", warnings_.count(Warning::kCommandRefused) + warnings_.count(Warning::kToolsRefused));
  status.add("calls refused", warnings_.count(Warning::kCallRefused));
  status.add("commands dropped", now_.commands_dropped + inbox_.numCommandsDropped());
  status.add("silent tools", now_.silent_tools.empty() ? "none" : now_.silent_tools);
  status.add("last warning", warnings_.last());
}

void NodeDiagnostics::describeSimulation(Status& status) const {
  const double rate = static_cast<double>(now_.steps_taken - last_.steps_taken) / period_;
  const bool is_behind = now_.time_let_go > last_.time_let_go;
  if (now_.is_failed) {
    status.summary(DiagnosticStatus::ERROR, now_.state);
  } else if (is_behind) {
    status.summary(DiagnosticStatus::WARN, "slower than real time");
  } else if (now_.has_snapped) {
    status.summary(DiagnosticStatus::WARN, "snapped: at rest without a load in another shape than its own; ~reset ends it");
  } else if (!now_.lost.empty()) {
    status.summary(DiagnosticStatus::WARN, "lost: " + now_.lost);
  } else {
    status.summary(DiagnosticStatus::OK, now_.state);
  }
  status.add("state", now_.state);
  status.add("step", now_.step);
  status.add("simulation time (s)", formatReal(now_.simulation_time));
  status.add("steps per second", formatReal(rate));
  status.add("real-time factor", formatReal(rate * now_.time_step));
  status.add("lag (s)", formatReal(now_.lag));
  status.add("time not caught up (s)", formatReal(now_.time_let_go));
  status.add("time not caught up after calls (s)", formatReal(now_.time_in_calls));
  status.add("time not caught up after building (s)", formatReal(now_.time_in_builds));
  status.add("frames dropped", now_.frames_dropped);
  status.add("clock jumps back", now_.jumps_back);
  if (!now_.accuracy.empty()) status.add("accuracy", now_.accuracy);
}

}  // namespace deformable_surface::node
