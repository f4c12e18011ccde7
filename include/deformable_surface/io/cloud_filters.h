// Takes away from a cloud what is not the surface: what lies elsewhere, what a depth camera makes up, the table. In io, because
// the plane and the outliers are found by PCL.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/input_filter_params.h"

#include <cstdint>
#include <string>
#include <vector>

namespace deformable_surface::io {

/// By which filter a point went; the values are those of the field that files have.
enum class RemovedBy : std::uint8_t { kNone, kCrop, kRange, kFlyingPixels, kPlane, kOtherSide, kOutliers };

struct FilterReport {
  std::vector<RemovedBy> removed_by;  // (n) kNone: stays, or was no point before; empty: no filter is on
  std::vector<std::string> notices;   // what went by which filter, the cloud before and after, the plane; empty: no filter is on
  std::string problem;                // why nothing can be made of what stays; empty if something can
};

/// Carries out the filters one after the other: crop, range, flying pixels, plane, outliers. A point that goes becomes NaN and
/// keeps its place, so that the output has one point per input point. The same cloud gives the same bits with any number of
/// threads.
/// Throws InputError for flying pixels of a cloud that is not organised, and for one side of a plane in which the eye lies.
/// O(n log n).
FilterReport filterCloud(const simulation::InputFilterParams& params, cloud::PointCloud& cloud);

/// The cloud as it was before the filters, with a field removed_by (uint8) in front of those that it brings.
cloud::PointCloud withRemovedBy(const FilterReport& report, cloud::PointCloud before);

}  // namespace deformable_surface::io
