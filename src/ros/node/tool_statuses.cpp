#include "tool_statuses.h"

#include "deformable_surface/ros/convert/tool_decoder.h"

#include <algorithm>

namespace deformable_surface::node {
namespace {

constexpr std::size_t kShownId = 64;  // letters of an id that is wrong

}  // namespace

void ToolStatuses::reportWaiting(const Tool& command, const std::string& reason) {
  report(command, ToolStatus::WAITING, reason, 0);
}

void ToolStatuses::reportAccepted(const Tool& command, std::uint64_t step) {
  if (command.action == Tool::DELETEALL) clear();
  report(command, ToolStatus::ACCEPTED, "", step);
}

void ToolStatuses::reportRefused(const Tool& command, const std::string& reason) {
  report(command, ToolStatus::REFUSED, reason, 0);
}

void ToolStatuses::clear() {
  has_changed_ = has_changed_ || !entries_.empty();
  entries_.clear();
}

void ToolStatuses::report(const Tool& command, std::uint8_t status, const std::string& reason, std::uint64_t step) {
  const std::string id = command.action == Tool::DELETEALL ? "" : command.id.substr(0, kShownId);
  if (entries_.size() >= kMaxTools && entries_.count(id) == 0) {
    const auto is_older = [](const auto& a, const auto& b) { return a.second.order < b.second.order; };
    entries_.erase(std::min_element(entries_.begin(), entries_.end(), is_older));
  }
  Entry& entry = entries_[id];
  entry.order = ++count_;
  entry.status.header = command.header;
  entry.status.id = id;
  entry.status.action = command.action;
  entry.status.status = status;
  entry.status.message = reason;
  entry.status.step = step;
  has_changed_ = true;
}

bool ToolStatuses::takeChanged(ToolStatusArray& message) {
  if (!has_changed_) return false;
  has_changed_ = false;
  message.tools.clear();
  for (const auto& [id, entry] : entries_) message.tools.push_back(entry.status);
  return true;
}

}  // namespace deformable_surface::node
