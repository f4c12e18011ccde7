// When steps skip parts of a surface that are at rest.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"

namespace deformable_surface::simulation {

/// kAuto: as kAlways, but never with explicit Euler, whose results should be as published.
enum class Sleep { kAuto, kAlways, kNever };

struct SleepParams {
  Sleep mode = Sleep::kAuto;
  OrAuto<double> tolerance;  // m, > 0: the motion that a part may lose by falling asleep; auto: a share of the spacing
  double quiet_time = 0.5;   // s, > 0: for how long it must have been slow
};

inline void visit(Fields& fields, SleepParams& p) {
  fields.choice("mode", p.mode, {{"auto", Sleep::kAuto}, {"always", Sleep::kAlways}, {"never", Sleep::kNever}},
                "regions at rest sleep until something disturbs them; `auto` = always, except with explicit_euler");
  fields.number(
      "tolerance", p.tolerance, "m", between(1e-15, kMaxLength),
      "largest motion that sleeping may suppress. A region sleeps if it moves less than this in quiet_time and is this close to "
      "its equilibrium; `auto` = 1e-4 of the spacing of the simulation points");
  fields.number("quiet_time", p.quiet_time, "s", between(1e-6, 1e6), "time that a region must be slow before it sleeps");
}

}  // namespace deformable_surface::simulation
