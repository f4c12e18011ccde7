// Removes points of a cloud that are not the surface: other objects, flying pixels of a depth camera, the table. In io, because
// PCL finds the plane and the outliers.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/input_filter_params.h"

#include <cstdint>
#include <string>
#include <vector>

namespace deformable_surface::io {

/// The filter that removed a point; the values are those of the field in files.
enum class RemovedBy : std::uint8_t { kNone, kCrop, kRange, kFlyingPixels, kPlane, kOtherSide, kOutliers };

struct FilterReport {
  std::vector<RemovedBy> removed_by;  // (n) kNone: stays, or was no point before; empty: no filter is on
  std::vector<std::string> notices;   // what each filter removed, the cloud before and after, the plane; empty: no filter is on
  std::string problem;                // why the remaining points are of no use; empty if they are
};

/// Applies the filters one after the other: crop, range, flying pixels, plane, outliers. A removed point becomes NaN and
/// keeps its place, so that the output has one point per input point. The same cloud gives the same bits with any number of
/// threads.
/// Throws InputError for flying pixels of a cloud that is not organised, and for one side of a plane in which the eye lies.
/// O(n log n).
FilterReport filterCloud(const simulation::InputFilterParams& params, cloud::PointCloud& cloud);

/// The cloud as it was before the filters, with an extra field removed_by (uint8) before the others.
cloud::PointCloud withRemovedBy(const FilterReport& report, cloud::PointCloud before);

}  // namespace deformable_surface::io
