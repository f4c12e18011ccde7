// What guides the growth of a surface of oriented particles: an iso-surface of a volume, to which pressure drives it.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/volume.h"

#include <memory>
#include <string>

namespace deformable_surface::model {

/// The inside of an iso-surface: where values are above or below the iso-value.
enum class GuideInside { kAbove, kBelow };

struct GuideParams {
  std::string volume;  // file; empty = no guide
  double scale = 1.0;  // > 0: m per unit of length of the file
  double iso_value = 0.0;
  GuideInside inside = GuideInside::kAbove;
  double pressure = 0.0;                         // Pa, > 0 with a volume
  double reach = 0.5;                            // spacings, > 0: from the iso-surface to where the pressure is whole
  std::shared_ptr<const geometry::Volume> grid;  // what the file holds, once it has been read

  /// m, positive inside.
  double distance(const Vec3& place) const {
    return geometry::findIsoDistance(*grid, iso_value, inside == GuideInside::kAbove ? 1.0 : -1.0, place);
  }
};

inline void visit(Fields& fields, GuideParams& p) {
  fields.text("volume", p.volume, "MetaImage file (`.mha`) with a volume: path or `package://PACKAGE/PATH`; empty = no guide");
  fields.number("scale", p.scale, "", between(1e-9, 1e9), "metres per unit of length of the file");
  fields.number("iso_value", p.iso_value, "", between(-1e30, 1e30), "value on the iso-surface");
  fields.choice("inside", p.inside, {{"above", GuideInside::kAbove}, {"below", GuideInside::kBelow}},
                "the inside has values `above` or `below` iso_value (a distance field, negative inside: `below`)");
  fields.number(
      "pressure", p.pressure, "Pa", between(0.0, 1e12),
      "above 0 with a volume: pushes particles along their normals: outwards inside of the iso-surface, inwards outside of it");
  fields.number("reach", p.reach, "spacings", between(0.01, 10.0),
                "within this distance of the iso-surface the pressure falls linearly, to zero on it");
  fields.require(p.volume.empty() || p.pressure > 0.0, "pressure", "found 0 with a volume; accepted: above 0");
}

}  // namespace deformable_surface::model
