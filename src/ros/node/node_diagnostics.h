// The node's messages on /diagnostics.
#pragma once

#include "inbox.h"
#include "stepper.h"
#include "warning_log.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <chrono>
#include <string>
#include <tuple>

namespace deformable_surface::node {

/// For the simulation thread. During a long step this thread is busy; a timer then reports it on the queue
/// of watch_node.
class NodeDiagnostics {
 public:
  NodeDiagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const ros::NodeHandle& watch_node,
                  const Stepper& stepper, const Inbox& inbox, const WarningLog& warnings);

  /// Publishes if it is time: regularly, and soon after an event. By wall time, since a clock that stands still or
  /// jumps back must be reported too.
  void update();
  /// When update() is to be called next, at the latest.
  Inbox::SteadyTime nextTime() const;

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;
  // Changes that are reported soon: state, clouds accepted and refused, warnings, commands waiting.
  using Happened = std::tuple<std::string, int, int, std::string, int, int>;

  void watchStep();
  void describeInput(Status& status) const;
  void describeSimulation(Status& status) const;
  Happened observe() const;

  const Stepper& stepper_;
  const Inbox& inbox_;
  const WarningLog& warnings_;
  const std::string name_;
  ros::Publisher topic_;  // of the updater's messages, to see whether anybody listens
  ros::WallTimer watch_;
  Inbox::SteadyTime last_warning_;
  diagnostic_updater::Updater updater_;
  Happened published_;
  Inbox::SteadyTime last_time_;
  StepperStatus last_, now_;  // at the last two updates
  double period_ = 0.0;       // s between them
};

}  // namespace deformable_surface::node
