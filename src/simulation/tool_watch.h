// Detects tools that have changed since the last check, and where they act: this wakes a sleeping surface. Contact only asks for
// forces at an instant.
#pragma once

#include "deformable_surface/tool/tool.h"

#include <Eigen/Geometry>

namespace deformable_surface::simulation {

class ToolWatch {
 public:
  /// Forgets all tools.
  void reset() { seen_.clear(); }

  /// Checks the tools at a time (s), the end of a step (s). Returns, for each tool that has changed since the last check (moved,
  /// begun, ended, new, removed or modified), a box (m) around everything it can act on in the step. Empty if none has. Valid
  /// until the next check.
  const std::vector<Eigen::AlignedBox3d>& look(const std::vector<tool::ToolParams>& tools, double time, double step);
  /// The result of the last check.
  const std::vector<Eigen::AlignedBox3d>& changed() const { return changed_; }

  /// Must be in a snapshot.
  struct Seen {
    tool::ToolParams tool;  // without its path
    bool is_active;
    tool::Pose pose;
  };
  const std::vector<Seen>& memory() const { return seen_; }
  void setMemory(const std::vector<Seen>& memory) { seen_ = memory; }

 private:
  std::vector<Seen> seen_;
  std::vector<Eigen::AlignedBox3d> changed_;
};

}  // namespace deformable_surface::simulation
