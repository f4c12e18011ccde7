// The server of the action ~rollout: each goal becomes a copy of the surface, which a thread of its own steps while the surface
// goes on.
#pragma once

#include "inbox.h"
#include "queue_thread.h"
#include "rollout.h"
#include "stepper.h"
#include "warning_log.h"

#include "deformable_surface/RolloutAction.h"

#include <actionlib/server/action_server.h>
#include <ros/callback_queue.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace deformable_surface::node {

/// Name of the action, and of the parameters below the node that its clients read.
constexpr char kRolloutName[] = "rollout";

class Rollouts {
 public:
  /// num_threads: how many run at once, each in one thread, whose results do not depend on it; >= 1.
  Rollouts(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, const tf2::BufferCore& transforms, WarningLog& warnings,
           int num_threads);
  ~Rollouts();

 private:
  using Server = actionlib::ActionServer<RolloutAction>;
  struct Job {
    Server::GoalHandle goal;
    std::unique_ptr<simulation::Simulation> copy;
    RolloutPlan plan;
    std::string frame;
    std::optional<StepSchedule> schedule;
    std::atomic<bool> is_cancelled{false};
  };

  void start(const ros::NodeHandle& node);
  /// Throws InputError if too many wait already.
  void requireRoom();
  void accept(Server::GoalHandle goal);
  void cancel(const Server::GoalHandle& goal);
  void work();
  void endThreads();
  void run(Job& job);

  Inbox& inbox_;
  Stepper& stepper_;
  const tf2::BufferCore& transforms_;
  WarningLog& warnings_;

  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::shared_ptr<Job>> waiting_;
  std::list<std::shared_ptr<Job>> running_;
  std::atomic<bool> is_ended_{false};
  std::vector<std::thread> threads_;

  ros::CallbackQueue queue_;
  std::unique_ptr<Server> server_;
  QueueThread queue_thread_;
};

}  // namespace deformable_surface::node
