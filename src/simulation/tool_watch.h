// Which tools have changed their place since the last look, and where that can be felt: what wakes a surface that sleeps. Apart
// from contact, which asks for forces at an instant.
#pragma once

#include "deformable_surface/tool/tool.h"

#include <Eigen/Geometry>

namespace deformable_surface::simulation {

class ToolWatch {
 public:
  /// Has seen no tool.
  void reset() { seen_.clear(); }

  /// Looks at the tools as they are at a time (s), the end of a step (s). Returns a box (m) around what each can act on in the
  /// step for those that are other than at the last look: moved, begun, ended, new, gone or made another. Empty if none is. Valid
  /// until the next look.
  const std::vector<Eigen::AlignedBox3d>& look(const std::vector<tool::ToolParams>& tools, double time, double step);
  /// What the last look returned.
  const std::vector<Eigen::AlignedBox3d>& changed() const { return changed_; }

  /// What a snapshot must hold.
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
