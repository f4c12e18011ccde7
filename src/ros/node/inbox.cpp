#include "inbox.h"

#include "deformable_surface/base/error.h"

#include <ros/time.h>

#include <algorithm>
#include <utility>

namespace deformable_surface::node {
namespace {

// More than a second of forces at the highest usual rates; more than that is a fault of the sender.
constexpr std::size_t kMaxCommands = 4096;
// Each waiting call holds a thread of its caller; more than this is a flood.
constexpr std::size_t kMaxJobs = 16;
constexpr char kShuttingDown[] = "the node is shutting down";

}  // namespace

std::int64_t Inbox::now() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return readClock();
}

void Inbox::put(DecodedCloud&& cloud, std::int64_t arrival) {
  const std::lock_guard<std::mutex> lock(mutex_);
  num_clouds_replaced_ += cloud_.has_value();
  cloud_ = IncomingCloud{std::move(cloud), arrival};
  came_.notify_one();
}

void Inbox::put(const PointForceConstPtr& force) {
  putCommand({static_cast<std::int64_t>(force->header.stamp.toNSec()), force, nullptr, nullptr, true, {}});
}

void Inbox::put(const geometry_msgs::WrenchStampedConstPtr& wrench) {
  putCommand({static_cast<std::int64_t>(wrench->header.stamp.toNSec()), nullptr, wrench, nullptr, true, {}});
}

void Inbox::put(const ToolConstPtr& tool) {
  putCommand({static_cast<std::int64_t>(tool->header.stamp.toNSec()), nullptr, nullptr, tool, true, {}});
}

void Inbox::putCommand(Command command) {
  const std::lock_guard<std::mutex> lock(mutex_);
  command.is_stamped = command.stamp != 0;
  if (!command.is_stamped) {
    command.stamp = readClock();
    command.seen = seeTransform(command.header().frame_id, surface_frame_, transforms_);
  }
  if (commands_.size() >= kMaxCommands) {
    commands_.pop_front();
    ++num_commands_dropped_;
  }
  commands_.push_back(std::move(command));
  came_.notify_one();
}

void Inbox::putRefusedTools(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  tools_refused_ = reason;
  was_woken_ = true;
  came_.notify_one();
}

void Inbox::observeClock(std::int64_t now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  observe(now, 0);
  was_woken_ = true;
  came_.notify_one();
}

std::int64_t Inbox::readClock() {
  if (clock_.isSimulated()) return clock_.now();
  const auto steady = std::chrono::steady_clock::now().time_since_epoch();
  observe(static_cast<std::int64_t>(ros::Time::now().toNSec()), std::chrono::nanoseconds(steady).count());
  return clock_.now();
}

void Inbox::observe(std::int64_t now, std::int64_t steady) {
  // Commands sent before a jump back belong to a run that is over.
  if (clock_.observe(now, steady)) commands_.clear();
}

void Inbox::wantFrame() {
  const std::lock_guard<std::mutex> lock(mutex_);
  frame_wanted_ = true;
  came_.notify_one();
}

void Inbox::wake() {
  const std::lock_guard<std::mutex> lock(mutex_);
  was_woken_ = true;
  came_.notify_one();
}

// Between steps only: a step that has begun to end must end.
void Inbox::updateEndsStep() {
  ends_step_ = closed_ || std::any_of(jobs_.begin(), jobs_.end(), [](const Job* job) { return job->ends_step; });
}

void Inbox::perform(const std::function<void()>& work, bool ends_step) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (closed_) throw InputError(kShuttingDown);
  if (jobs_.size() >= kMaxJobs) throw InputError("busy: too many calls wait already");
  Job job{&work, ends_step};
  jobs_.push_back(&job);
  if (ends_step) ends_step_ = true;
  came_.notify_one();
  answered_.wait_for(lock, patience_, [&] { return job.state != Job::State::kWaiting; });
  if (job.state == Job::State::kWaiting) {
    jobs_.erase(std::find(jobs_.begin(), jobs_.end(), &job));
    throw InputError("busy: the simulation did not get to it in time; try again");
  }
  // Running work uses its caller's data, so that the caller must wait; the work checks isClosed() itself.
  answered_.wait(lock, [&] { return job.state != Job::State::kRunning; });
  if (job.state == Job::State::kRefused) throw InputError(kShuttingDown);
  if (job.problem) std::rethrow_exception(job.problem);
}

void Inbox::setSurfaceFrame(const std::string& frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  surface_frame_ = frame;
}

void Inbox::doJobs() {
  std::unique_lock<std::mutex> lock(mutex_);
  updateEndsStep();
  while (!jobs_.empty() && !closed_) {
    Job& job = *jobs_.front();
    jobs_.pop_front();
    updateEndsStep();
    job.state = Job::State::kRunning;
    lock.unlock();
    try {
      (*job.work)();
    } catch (...) {
      job.problem = std::current_exception();
    }
    lock.lock();
    job.state = Job::State::kDone;
    answered_.notify_all();
  }
}

void Inbox::close() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = true;
  for (Job* job : jobs_) job->state = Job::State::kRefused;
  jobs_.clear();
  updateEndsStep();
  came_.notify_all();
  answered_.notify_all();
}

Inbox::Content Inbox::take(SteadyTime until) {
  std::unique_lock<std::mutex> lock(mutex_);
  came_.wait_until(lock, until,
                   [&] { return closed_ || cloud_ || !commands_.empty() || !jobs_.empty() || frame_wanted_ || was_woken_; });
  readClock();
  Content content;
  content.cloud = std::exchange(cloud_, std::nullopt);
  content.commands.assign(std::make_move_iterator(commands_.begin()), std::make_move_iterator(commands_.end()));
  commands_.clear();
  content.tools_refused = std::exchange(tools_refused_, "");
  content.frame_wanted = std::exchange(frame_wanted_, false);
  content.closed = closed_;
  content.clock = clock_.take();
  was_woken_ = false;
  return content;
}

int Inbox::numCloudsReplaced() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return num_clouds_replaced_;
}

int Inbox::numCommandsDropped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return num_commands_dropped_;
}

}  // namespace deformable_surface::node
