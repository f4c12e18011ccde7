// Where contact of a surface with itself stopped points in the last step, and what pushes or holds there: for the notice of it.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

struct Jam {
  struct Actor {
    enum class Act { kPushes, kPulls, kIsNear, kHolds };  // near: it pushes no point at the end of the step, as after a bounce

    std::string name;  // "tool 'table'", "pins[0]", "a pin set by a command"
    Act act;
    bool moves;  // else it rests
  };

  Index points = 0;           // that were stopped
  Vec3 place = Vec3::Zero();  // m, of the one nearest to the middle of all
  bool are_near = false;      // the actors; else none is, and these act on the same part of the surface elsewhere
  std::vector<Actor> actors;  // each once, tools that push or pull first, then those that are near, then what holds
};

/// "contact limited the motion of 12 points, one of them at (0, 0, 0.1) m, where moving tool 'upper' pushes".
std::string describeJam(const Jam& jam);

}  // namespace deformable_surface::simulation
