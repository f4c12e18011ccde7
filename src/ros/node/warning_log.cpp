#include "warning_log.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <ros/console.h>

#include <iterator>

namespace deformable_surface::node {
namespace {

// Lines every few seconds are read; one for each message of a camera is not.
constexpr std::chrono::seconds kSilence(5);
// More causes than a user's mistakes make; changing names must fill neither the memory nor the log.
constexpr std::size_t kMaxCauses = 32;

}  // namespace

void WarningLog::report(Warning warning, const std::string& sentence) {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_ = toOneLine(sentence);
  last_time_ = Clock::now();
  ++counts_[static_cast<int>(warning)];
  Cause& cause = findCause(warning, last_);
  if (cause.was_logged && last_time_ - cause.last_line < kSilence) {
    ++cause.left_out;
    return;
  }
  const std::string more = cause.left_out > 0 ? " (" + std::to_string(cause.left_out) + " similar messages were not logged)" : "";
  const bool is_error = warning == Warning::kStep || warning == Warning::kInternal;
  if (is_error) {
    ROS_ERROR_STREAM(name_ << ": " << last_ << more);
  } else {
    ROS_WARN_STREAM(name_ << ": " << last_ << more);
  }
  cause = {true, 0, last_time_};
}

/// Beyond kMaxCauses, all sentences of a kind count as one cause.
WarningLog::Cause& WarningLog::findCause(Warning warning, const std::string& sentence) {
  const std::string kind = std::to_string(static_cast<int>(warning));
  const std::string key = kind + withoutNumbers(sentence);
  if (causes_.size() < kMaxCauses || causes_.count(key) > 0) return causes_[key];
  for (auto entry = causes_.begin(); entry != causes_.end();) {
    entry = last_time_ - entry->second.last_line >= kSilence ? causes_.erase(entry) : std::next(entry);
  }
  return causes_[causes_.size() < kMaxCauses ? key : kind];
}

int WarningLog::count(Warning kind) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_[static_cast<int>(kind)];
}

std::string WarningLog::last() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return last_;
}

bool WarningLog::isRecent() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !last_.empty() && Clock::now() - last_time_ < kSilence;
}

}  // namespace deformable_surface::node
