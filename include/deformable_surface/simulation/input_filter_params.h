// What is taken away from a cloud before it becomes a surface or something to track; all off by default. io::filterCloud() does
// it, with PCL, and is called by `simulate` and by the node. The core reads these values and takes nothing away.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/region_params.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

/// Only what lies in the region stays.
struct CropParams {
  geometry::Region region;
};

/// Distances from the eye, PointCloud::eye().
struct RangeParams {
  double min = 0.0, max = 1e9;  // m, 0 <= min < max; the defaults take nothing
};

/// The plane that most points lie on: the table under a towel.
struct PlaneFilterParams {
  enum class Keep { kBoth, kNearSide, kFarSide };
  double distance = 0.0;    // m, >= 0; what lies within it goes; 0 = no plane is looked for
  double radius = 0.0;      // m, >= 0; the median height of the points within it decides; 0 = each point's own
  double min_share = 0.1;   // of the points; a plane that holds fewer stays
  Keep keep = Keep::kBoth;  // of its sides; the near one is that of the eye
};

/// Points that are alone.
struct OutlierParams {
  enum class Method { kNone, kRadius, kStatistical };
  Method method = Method::kNone;
  Index neighbors = 8;      // >= 1
  double radius = 0.0;      // m, kRadius: > 0
  double deviations = 2.0;  // kStatistical: >= 0
};

/// In the order in which they are carried out.
struct InputFilterParams {
  std::vector<CropParams> crop;  // what stays lies in all of them
  RangeParams range;
  double flying_pixels = 0.0;  // m at a distance of 1 m, >= 0; 0 = off
  PlaneFilterParams plane;
  OutlierParams outliers;

  bool isOn() const {
    const RangeParams none;
    return !crop.empty() || range.min > none.min || range.max < none.max || flying_pixels > 0.0 || plane.distance > 0.0 ||
           outliers.method != OutlierParams::Method::kNone;
  }
};

inline void visit(Fields& fields, CropParams& p) { geometry::visitRegion(fields, p.region); }

inline void visit(Fields& fields, RangeParams& p) {
  const Range accepted = between(0.0, RangeParams().max);
  fields.number("min", p.min, "m", accepted, "nearer points go");
  fields.number("max", p.max, "m", accepted, "farther points go; the default takes none");
  fields.require(
      p.min < p.max, "max",
      "found " + formatReal(p.max) + ", which is not above min, " + formatReal(p.min) + "; accepted: min < max");
}

inline void visit(Fields& fields, PlaneFilterParams& p) {
  fields.number("distance", p.distance, "m", between(0.0, kMaxLength),
                "what lies within it of the plane goes; 0 = no plane is looked for. For a towel on a table: half of the towel's "
                "thickness, if that is more than the table is bent");
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength),
                "the median of the heights of the points within it decides, which tells layers apart that are thinner than the "
                "noise; 0 = each point's own height");
  fields.number("min_share", p.min_share, "", between(0.02, 1.0),
                "of the points that the filters before have left: a plane that fewer lie on stays, which the build says");
  using Keep = PlaneFilterParams::Keep;
  fields.choice("keep", p.keep, {{"both", Keep::kBoth}, {"near_side", Keep::kNearSide}, {"far_side", Keep::kFarSide}},
                "`near_side`: what lies on the other side of the plane than the eye goes as well: the floor around a table, "
                "noise below its top, and of a towel what hangs over the edge. `far_side`: for a cloud that came in a frame "
                "whose origin is below the table");
}

inline void visit(Fields& fields, OutlierParams& p) {
  using Method = OutlierParams::Method;
  fields.choice("method", p.method, {{"none", Method::kNone}, {"radius", Method::kRadius}, {"statistical", Method::kStatistical}},
                "points that are alone go: `radius`: those with fewer than `neighbors` others within `radius`; `statistical`: "
                "those whose mean distance to the nearest `neighbors` is above that of all by `deviations` standard deviations");
  fields.integer("neighbors", p.neighbors, "", between(1, 1000), "how many others are looked at");
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength), "`radius`: some spacings of the points");
  fields.require(p.method != Method::kRadius || p.radius > 0.0, "radius",
                 "found 0 with the method radius; accepted: above 0 and at most " + formatReal(kMaxLength) + " (m)");
  fields.number("deviations", p.deviations, "", between(0.0, 1e6), "`statistical`: of the mean distances");
}

inline void visit(Fields& fields, InputFilterParams& p) {
  fields.list("crop", p.crop, "Points that do not lie in every one of these closed boxes and spheres go.");
  fields.section("range", p.range,
                 "How far from the eye points may be: the viewpoint that the cloud brings, else the origin of the frame that it "
                 "came in.");
  fields.number("flying_pixels", p.flying_pixels, "m", between(0.0, kMaxLength),
                "of an organised cloud: points that hang between two surfaces go, if both are farther off than this along the "
                "line of sight. Stated for a distance of 1 m, it grows with the square of the distance, as noise and steps of "
                "depth do; 0 = off");
  fields.section("plane", p.plane, "The plane that most points lie on, as a table (RANSAC, with a fixed seed).");
  fields.section("outliers", p.outliers, "Points that are alone.");
}

}  // namespace deformable_surface::simulation
