#include "deformable_surface/ros/convert/cloud_updates.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cstring>

namespace deformable_surface::node {
namespace {

constexpr Index kBlock = 16384;  // rows, large enough for negligible overhead

bool haveSameLayout(const sensor_msgs::PointCloud2& a, const sensor_msgs::PointCloud2& b) {
  return a.width == b.width && a.height == b.height && a.point_step == b.point_step && a.fields == b.fields;
}

}  // namespace

bool CloudUpdates::make(const sensor_msgs::PointCloud2ConstPtr& cloud, bool whole, DeformedUpdate& message) {
  message.is_full = message.whole = whole || !last_ || !haveSameLayout(*last_, *cloud);
  message.header = cloud->header;
  message.indices.clear();
  if (message.is_full) {
    message.points = *cloud;
  } else {
    const std::size_t step = cloud->point_step;
    const Index n = static_cast<Index>(cloud->data.size() / step), num_blocks = (n + kBlock - 1) / kBlock;
    found_.resize(num_blocks);
    parallelFor(num_blocks, 1, [&](Index block, Index) {
      std::vector<std::uint32_t>& rows = found_[block];
      rows.clear();
      const Index begin = block * kBlock, end = std::min(n, begin + kBlock);
      const std::uint8_t *now = cloud->data.data(), *before = last_->data.data();
      if (std::memcmp(now + begin * step, before + begin * step, (end - begin) * step) == 0) return;
      for (Index i = begin; i < end; ++i)
        if (std::memcmp(now + i * step, before + i * step, step) != 0) rows.push_back(static_cast<std::uint32_t>(i));
    });
    for (const std::vector<std::uint32_t>& rows : found_) message.indices.insert(message.indices.end(), rows.begin(), rows.end());
    if (message.indices.empty()) return false;

    sensor_msgs::PointCloud2& points = message.points;
    points.header = cloud->header;
    points.height = 1;
    points.width = static_cast<std::uint32_t>(message.indices.size());
    points.fields = cloud->fields;
    points.is_bigendian = cloud->is_bigendian;
    points.point_step = cloud->point_step;
    points.row_step = points.width * points.point_step;
    points.is_dense = cloud->is_dense;
    points.data.resize(points.row_step);
    for (std::size_t k = 0; k < message.indices.size(); ++k)
      std::memcpy(points.data.data() + k * step, cloud->data.data() + message.indices[k] * step, step);
  }
  last_ = cloud;
  message.sequence = sequence_++;
  return true;
}

}  // namespace deformable_surface::node
