#include "complaints.h"

#include <ros/console.h>

#include <algorithm>

namespace deformable_surface::node {
namespace {

// A line every few seconds is read; one for each message of a camera is not.
constexpr std::chrono::seconds kSilence(5);

// Several problems come in several lines; the log wants one.
std::string inOneLine(std::string text) {
  for (std::size_t at; (at = text.find('\n')) != std::string::npos;) text.replace(at, 1, "; ");
  return text;
}

}  // namespace

void Complaints::report(Complaint complaint, const std::string& sentence) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Kind& kind = kinds_[static_cast<int>(complaint)];
  last_ = inOneLine(sentence);
  last_time_ = Clock::now();
  ++kind.count;
  if (kind.count > 1 && last_time_ - kind.last_line < kSilence) {
    ++kind.left_out;
    return;
  }
  const std::string more = kind.left_out > 0 ? " (" + std::to_string(kind.left_out) + " like it left out)" : "";
  const bool is_error = complaint == Complaint::kStep || complaint == Complaint::kInternal;
  if (is_error) {
    ROS_ERROR_STREAM(name_ << ": " << last_ << more);
  } else {
    ROS_WARN_STREAM(name_ << ": " << last_ << more);
  }
  kind.last_line = last_time_;
  kind.left_out = 0;
}

int Complaints::count(Complaint kind) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return kinds_[static_cast<int>(kind)].count;
}

std::string Complaints::last() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return last_;
}

bool Complaints::isRecent() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !last_.empty() && Clock::now() - last_time_ < kSilence;
}

}  // namespace deformable_surface::node
