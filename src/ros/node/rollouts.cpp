#include "rollouts.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

namespace deformable_surface::node {
namespace {

using std::chrono::steady_clock;

// Each holds a copy of the surface while it waits; a planner with more branches sends them as results come.
constexpr std::size_t kMaxWaiting = 256;
// Goals that came and were not read yet, and messages that wait for a slow client.
constexpr int kQueue = 1000;
constexpr double kStatusFrequency = 1.0;  // Hz
// Often enough for a smooth progress bar.
constexpr std::chrono::milliseconds kFeedbackPeriod(100);

RolloutResult makeRefusal(const std::string& message) {
  RolloutResult result;
  result.message = message;
  return result;
}

}  // namespace

Rollouts::Rollouts(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, const tf2::BufferCore& transforms, WarningLog& warnings,
                   int num_threads)
    : inbox_(inbox), stepper_(stepper), transforms_(transforms), warnings_(warnings), queue_thread_(queue_) {
  node.setCallbackQueue(&queue_);
  server_ = std::make_unique<Server>(
      node, kRolloutName, [this](Server::GoalHandle goal) { accept(std::move(goal)); },
      [this](const Server::GoalHandle& goal) { cancel(goal); }, false);
  start(node);
  queue_thread_.start();
  // Last: what is thrown above finds none of them, and those that run end if one cannot be started.
  try {
    for (int k = 0; k < num_threads; ++k) threads_.emplace_back([this] { work(); });
  } catch (...) {
    endThreads();
    throw;
  }
}

// Server and client read these parameters. The server publishes its status regularly, by default so often that it would wake a
// resting node more than anything else; changes of status are published at once in any case. Both drop messages beyond
// a few that wait, so that many goals at once would never be answered.
void Rollouts::start(const ros::NodeHandle& node) {
  const std::string below = std::string(kRolloutName) + "/actionlib_";
  node.setParam(below + "status_frequency", kStatusFrequency);
  node.setParam(below + "server_sub_queue_size", kQueue);
  node.setParam(below + "server_pub_queue_size", kQueue);
  server_->start();
  node.deleteParam(kRolloutName);
  // This one stays, for the clients.
  node.setParam(below + "client_pub_queue_size", kQueue);
}

// The inbox is closed already: no call waits for the simulation thread any more.
Rollouts::~Rollouts() {
  endThreads();
  queue_thread_.stop();
  waiting_.clear();
  server_.reset();
}

void Rollouts::endThreads() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ended_ = true;
    for (const std::shared_ptr<Job>& job : running_) job->is_cancelled = true;
  }
  came_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Rollouts::requireRoom() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (waiting_.size() >= kMaxWaiting)
    throw InputError("busy: " + std::to_string(kMaxWaiting) + " rollouts wait already; accepted: no more at a time");
}

// The copy is made here, of the surface when the goal comes, however long the goal waits then.
void Rollouts::accept(Server::GoalHandle goal) {
  auto job = std::make_shared<Job>();
  CloudId cloud;
  const auto make_copy = [&] {
    const std::string obstacle = stepper_.obstacle();
    if (!obstacle.empty()) throw InputError(obstacle);
    job->copy = std::make_unique<simulation::Simulation>(stepper_.simulation()->fork());
    if (!goal.getGoal()->snapshot.empty()) job->copy->restore(stepper_.snapshots().find(goal.getGoal()->snapshot).snapshot);
    job->frame = stepper_.frame();
    cloud = stepper_.cloud();
    job->schedule.emplace(stepper_.scheduleFrom(job->copy->stepCount()));
  };
  try {
    requireRoom();
    inbox_.perform(make_copy);
    job->plan = prepareRollout(*goal.getGoal(), job->frame, transforms_, *job->copy);
    job->plan.cloud = cloud;
  } catch (const std::exception& error) {
    const std::string problem = toOneLine(error.what());
    warnings_.report(Warning::kCallRefused, "rollout refused: " + problem);
    return goal.setRejected(makeRefusal(problem), problem);
  }
  goal.setAccepted();
  job->goal = std::move(goal);
  const std::lock_guard<std::mutex> lock(mutex_);
  waiting_.push_back(std::move(job));
  came_.notify_one();
}

void Rollouts::cancel(const Server::GoalHandle& goal) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto find = [&](auto& jobs) {
    return std::find_if(jobs.begin(), jobs.end(), [&](const auto& job) { return job->goal == goal; });
  };
  const auto running = find(running_);
  if (running != running_.end()) {
    (*running)->is_cancelled = true;
    return;
  }
  const auto waiting = find(waiting_);
  if (waiting == waiting_.end()) return;
  (*waiting)->goal.setCanceled(makeRefusal("cancelled before it began"), "cancelled before it began");
  waiting_.erase(waiting);
}

void Rollouts::work() {
  // One thread each: several goals use the cores better than one does, and the surface's loops keep the pool to themselves.
  setNumThreads(1);
  for (;;) {
    std::shared_ptr<Job> job;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      came_.wait(lock, [this] { return is_ended_ || !waiting_.empty(); });
      if (is_ended_) return;
      job = std::move(waiting_.front());
      waiting_.pop_front();
      running_.push_back(job);
    }
    run(*job);
    const std::lock_guard<std::mutex> lock(mutex_);
    running_.remove(job);
  }
}

void Rollouts::run(Job& job) {
  auto last_feedback = steady_clock::now();
  const auto goes_on = [&](double progress) {
    if (is_ended_ || job.is_cancelled) return false;
    if (steady_clock::now() - last_feedback < kFeedbackPeriod) return true;
    last_feedback = steady_clock::now();
    RolloutFeedback feedback;
    feedback.progress = progress;
    feedback.simulation_time = job.copy->time();
    job.goal.publishFeedback(feedback);
    return true;
  };
  job.copy->setInterrupt(&job.is_cancelled);
  RolloutResult result;
  RolloutEnd end = RolloutEnd::kFailed;
  try {
    end = runRollout(job.plan, job.frame, *job.schedule, goes_on, *job.copy, result);
  } catch (const std::exception& error) {
    result.message = toOneLine(error.what());
  }
  job.copy.reset();
  if (end == RolloutEnd::kDone) {
    job.goal.setSucceeded(result, result.message);
  } else if (job.is_cancelled && end == RolloutEnd::kStopped) {
    job.goal.setCanceled(result, result.message);
  } else {
    job.goal.setAborted(result, result.message);
  }
}

}  // namespace deformable_surface::node
