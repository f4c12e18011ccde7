// The way of a dragged marker, which a tool follows at a limited speed. Apart from the server, since it knows no messages.
#pragma once

#include "deformable_surface/tool/tool.h"

#include <deque>

namespace deformable_surface::node {

class MarkerWay {
 public:
  /// start: where the tool is. lever: m, > 0: a turn counts as a way of its angle times the lever. loop: m, > 0, see append().
  MarkerWay(const tool::Pose& start, double lever, double loop) : pose_(start), lever_(lever), loop_(loop) {}

  /// The marker is at a pose (unit quaternion). Where its way comes back to within `loop` of an earlier place that lies ahead of
  /// the tool, the way between is left out: a jerk of the mouse to somewhere else and back leads nowhere.
  void append(const tool::Pose& pose);

  /// Moves the tool along the way, by at most this length (m, >= 0).
  void advance(double length);

  const tool::Pose& pose() const { return pose_; }
  bool hasArrived() const { return ahead_.empty(); }

 private:
  /// m: the longer of the distance and of the turn times the lever.
  double measure(const tool::Pose& a, const tool::Pose& b) const;

  tool::Pose pose_;
  std::deque<tool::Pose> ahead_;
  double lever_, loop_;
};

}  // namespace deformable_surface::node
