// Parameters of the interactive markers.
#pragma once

#include "deformable_surface/base/params.h"

#include <string>

namespace deformable_surface::node {

struct MarkerParams {
  std::string surface = "deformable_surface";
  double rate = 10.0;        // Hz, > 0
  OrAuto<double> radius;     // m, > 0
  double strength = 0.0;     // N, >= 0; 0 = any
  double heat = 500.0;       // K above ambient, > 0
  double attraction = 10.0;  // N/m, > 0
  OrAuto<double> speed;      // m/s of simulation time, > 0
};

inline void visit(Fields& fields, MarkerParams& p) {
  fields.text("surface", p.surface, "name of the node of the surface");
  fields.number("rate", p.rate, "Hz", between(0.1, 60.0), "largest rate at which the markers follow the surface");
  fields.number("radius", p.radius, "m", between(1e-6, kMaxLength),
                "radius of a grip, a pin and a trim; `auto` = 1.5 spacings of the simulation points");
  fields.number("strength", p.strength, "N", between(0.0, 1e12), "force at which a pull slips off the surface; 0 = never");
  fields.number("heat", p.heat, "K", between(1e-6, 1e9), "strength of a heating tool, above ambient");
  fields.number("attraction", p.attraction, "N/m", between(1e-9, 1e12), "strength of an attracting tool");
  fields.number("speed", p.speed, "m/s", between(1e-9, 1e6),
                "largest speed at which tools follow their markers, in simulation time; `auto` = 6 spacings of the simulation "
                "points per second for a warm hand, others at once");
  fields.require(!p.surface.empty(), "surface", "found empty text; accepted: the name of a node");
}

}  // namespace deformable_surface::node
