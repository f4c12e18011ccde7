// Filters of a cloud before it becomes a surface or is tracked; all are off by default. io::filterCloud() applies them, with PCL,
// called by `simulate` and by the node. The core reads these values and removes nothing.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/region_params.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

/// Keeps only points in the region.
struct CropParams {
  geometry::Region region;
};

/// Distances from the eye, PointCloud::eye().
struct RangeParams {
  double min = 0.0, max = 1e9;  // m, 0 <= min < max; the defaults remove nothing
};

/// Removes the plane with the most points: the table under a towel.
struct PlaneFilterParams {
  enum class Keep { kBoth, kNearSide, kFarSide };
  double distance = 0.0;    // m, >= 0; points within it are removed; 0 = no plane is searched
  double radius = 0.0;      // m, >= 0; the median height of the points within it decides; 0 = each point's own
  double min_share = 0.1;   // of the points; a plane that holds fewer stays
  Keep keep = Keep::kBoth;  // of its sides; the near one is that of the eye
};

/// Removes isolated points.
struct OutlierParams {
  enum class Method { kNone, kRadius, kStatistical };
  Method method = Method::kNone;
  Index neighbors = 8;      // >= 1
  double radius = 0.0;      // m, kRadius: > 0
  double deviations = 2.0;  // kStatistical: >= 0
};

/// In the order of their application.
struct InputFilterParams {
  std::vector<CropParams> crop;  // a point stays if it is in all of them
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
  fields.number("min", p.min, "m", accepted, "closer points are removed");
  fields.number("max", p.max, "m", accepted, "farther points are removed; the default removes none");
  fields.require(p.min < p.max, "max",
                 "found " + formatReal(p.max) + ", which is not above min, " + formatReal(p.min) + "; accepted: min < max");
}

inline void visit(Fields& fields, PlaneFilterParams& p) {
  fields.number("distance", p.distance, "m", between(0.0, kMaxLength),
                "points within this distance of the plane are removed; 0 = off. For a towel on a table: half of the towel's "
                "thickness, if the table is flatter than that");
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength),
                "radius of the median filter on the heights. It separates layers that are thinner than the noise; 0 = no filter");
  fields.number("min_share", p.min_share, "", between(0.02, 1.0),
                "smallest fraction of the remaining points on the plane. A plane with fewer points is kept, with a message");
  using Keep = PlaneFilterParams::Keep;
  fields.choice("keep", p.keep, {{"both", Keep::kBoth}, {"near_side", Keep::kNearSide}, {"far_side", Keep::kFarSide}},
                "side of the plane that is kept, seen from the viewpoint. `both` = only the plane is removed. `near_side` also "
                "removes the floor around a table, noise below its top, and the part of a towel that hangs over the edge. "
                "`far_side` is for a cloud frame with its origin below the table");
  const PlaneFilterParams off;
  const bool is_asked = p.radius != off.radius || p.min_share != off.min_share || p.keep != off.keep;
  fields.require(p.distance > 0.0 || !is_asked, "distance",
                 "found 0, which turns the filter off, beside its other parameters; accepted: above 0 and at most " +
                     formatReal(kMaxLength) + " (m), or none of the others");
}

inline void visit(Fields& fields, OutlierParams& p) {
  using Method = OutlierParams::Method;
  fields.choice("method", p.method, {{"none", Method::kNone}, {"radius", Method::kRadius}, {"statistical", Method::kStatistical}},
                "`radius` removes points with fewer than `neighbors` others within `radius`. `statistical` removes points whose "
                "mean distance to the nearest `neighbors` exceeds the overall mean by `deviations` standard deviations");
  fields.integer("neighbors", p.neighbors, "", between(1, 1000), "number of neighbours");
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength), "for `radius`: a few point spacings");
  fields.require(p.method != Method::kRadius || p.radius > 0.0, "radius",
                 "found 0 with the method radius; accepted: above 0 and at most " + formatReal(kMaxLength) + " (m)");
  fields.number("deviations", p.deviations, "", between(0.0, 1e6), "for `statistical`: number of standard deviations");
  const OutlierParams off;
  fields.require(p.method == Method::kRadius || p.radius == off.radius, "radius",
                 "found " + formatReal(p.radius) + " without the method that uses it; accepted: method radius beside it, or 0");
  fields.require(p.method == Method::kStatistical || p.deviations == off.deviations, "deviations",
                 "found " + formatReal(p.deviations) +
                     " without the method that uses it; accepted: method statistical beside it, or " +
                     formatReal(off.deviations));
  fields.require(p.method != Method::kNone || p.neighbors == off.neighbors, "neighbors",
                 "found " + std::to_string(p.neighbors) +
                     " without a method that uses it; accepted: method radius or statistical beside it, or " +
                     std::to_string(off.neighbors));
}

inline void visit(Fields& fields, InputFilterParams& p) {
  fields.list("crop", p.crop, "Only points inside all of these closed boxes and spheres are kept.");
  fields.section("range", p.range,
                 "Distance from the viewpoint: the cloud's own viewpoint if it has one, else the origin of the cloud's frame.");
  fields.number("flying_pixels", p.flying_pixels, "m", between(0.0, kMaxLength),
                "organised clouds: removes points between two surfaces if both are farther away than this along the line of "
                "sight. The value is for 1 m distance. It grows with the square of the distance, like noise and depth steps; 0 = "
                "off");
  fields.section("plane", p.plane, "Removes the plane with the most points, such as a table (RANSAC with a fixed seed).");
  fields.section("outliers", p.outliers, "Removes isolated points.");
}

}  // namespace deformable_surface::simulation
