// The result of the last command to each tool, for its sender. It outlives the waiting
// commands.
#pragma once

#include "deformable_surface/Tool.h"
#include "deformable_surface/ToolStatusArray.h"

#include <cstdint>
#include <map>
#include <string>

namespace deformable_surface::node {

class ToolStatuses {
 public:
  void reportWaiting(const Tool& command, const std::string& reason);
  /// step: the first step that it counts for.
  void reportAccepted(const Tool& command, std::uint64_t step);
  void reportRefused(const Tool& command, const std::string& reason);
  void clear();
  /// Fills the list if it has changed since the last call, and the first time; else returns false.
  bool takeChanged(ToolStatusArray& message);

 private:
  void report(const Tool& command, std::uint8_t status, const std::string& reason, std::uint64_t step);

  struct Entry {
    ToolStatus status;
    std::uint64_t order = 0;  // rises with every change
  };
  std::map<std::string, Entry> entries_;  // by id
  std::uint64_t count_ = 0;
  bool has_changed_ = true;
};

}  // namespace deformable_surface::node
