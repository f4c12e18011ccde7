#include "deformable_surface/cloud/pixel_links.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "k_nearest.h"

#include <algorithm>
#include <string>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 1024;  // points per task: a millisecond of work
// Columns and rows covered by the lists: on a surface seen at 80 degrees, some thirty neighbours lie in seven times as many rows
// as columns.
constexpr Index kReach = 12;
constexpr Index kAcross = 2 * kReach + 3;  // with a border that is never entered
constexpr Index kMostHoles = 4;            // in line between two pixels that are joined by distance

// The pixels around one that can be reached over links, nearer ones in the image first.
class PixelSearch {
 public:
  // Links also lead across pixels without points, between pixels no farther apart than the gap.
  PixelSearch(const PixelLinks& image, const std::vector<Index>& point, const Points& positions, double gap)
      : image_(image), point_(point), positions_(positions), squared_gap_(gap * gap) {
    for (int d = 0; d < 8; ++d) {
      to_pixel_[d] = kPixelSteps[d][1] * image.width + kPixelSteps[d][0];
      to_place_[d] = kPixelSteps[d][1] * kAcross + kPixelSteps[d][0];
    }
    std::fill(unmet_, unmet_ + kAcross * kAcross, 0);
    for (Index row = 1; row + 1 < kAcross; ++row) std::fill(unmet_ + row * kAcross + 1, unmet_ + (row + 1) * kAcross - 1, 1);
  }

  void run(Index pixel, KNearest& nearest) {
    constexpr Index kMiddle = (kReach + 1) * (kAcross + 1);
    const Vec3 origin = positions_[point_[pixel]];
    std::copy(unmet_, unmet_ + kAcross * kAcross, is_unmet_);
    is_unmet_[kMiddle] = 0;
    Index count = 0;
    queue_[count++] = {pixel, kMiddle, point_[pixel], 0.0};
    for (Index next = 0; next < count; ++next) {
      const Met from = queue_[next];
      if (from.squared_distance > nearest.bound()) continue;
      const bool is_hole = point_[from.pixel] < 0;
      for (unsigned left = image_.links[from.pixel]; left != 0; left &= left - 1) {
        const int direction = __builtin_ctz(left);
        const Index place = from.place + to_place_[direction];
        if (!is_unmet_[place]) continue;
        const Index to = from.pixel + to_pixel_[direction], i = point_[to];
        if (i >= 0 && is_hole && (positions_[i] - positions_[from.last]).squaredNorm() > squared_gap_) continue;
        is_unmet_[place] = 0;
        if (i < 0) {
          queue_[count++] = {to, place, from.last, from.squared_distance};
          continue;
        }
        const double squared = (positions_[i] - origin).squaredNorm();
        if (squared > nearest.bound()) continue;
        nearest.add(squared, i);
        queue_[count++] = {to, place, i, squared};
      }
    }
  }

 private:
  struct Met {
    Index pixel, place;  // in the image, and around the centre of the search
    Index last;          // the last point on the path to it, its own if it has one
    double squared_distance;
  };
  const PixelLinks& image_;
  const std::vector<Index>& point_;
  const Points& positions_;
  const double squared_gap_;
  Index to_pixel_[8], to_place_[8];
  char unmet_[kAcross * kAcross], is_unmet_[kAcross * kAcross];
  Met queue_[kAcross * kAcross];
};

}  // namespace

std::vector<Index> PixelLinks::findPoints(const std::vector<Index>& point_of_input) const {
  if (input.empty()) return point_of_input;
  std::vector<Index> points;
  points.reserve(input.size());
  for (const Index i : input) points.push_back(i < 0 ? -1 : point_of_input[i]);
  return points;
}

Lists findNeighbors(const PixelLinks& image, const std::vector<Index>& point, const Points& positions, Index k, double min_gap) {
  const Index n = static_cast<Index>(positions.size()), num_pixels = image.width * image.height;
  if (static_cast<Index>(image.links.size()) != num_pixels || point.size() != image.links.size())
    throw InputError("findNeighbors: found " + std::to_string(image.links.size()) + " links and " + std::to_string(point.size()) +
                     " points for " + std::to_string(num_pixels) + " pixels; accepted: equally many");
  // Of pixels that share a point, only the first counts.
  std::vector<Index> own(num_pixels, -1), pixel(n, -1);
  for (Index p = 0; p < num_pixels; ++p) {
    if (point[p] < 0 || pixel[point[p]] >= 0) continue;
    own[p] = point[p];
    pixel[point[p]] = p;
  }
  PixelLinks joined;
  if (min_gap > 0.0) {
    joined = image;
    for (Index p = 0; p < num_pixels; ++p) {
      for (int d = 0; d < 8 && own[p] >= 0; ++d) {
        // The next pixel with a point in that direction.
        Index steps = 1, u = p % image.width, v = p / image.width, q = -1;
        for (; steps <= kMostHoles + 1; ++steps) {
          u += kPixelSteps[d][0];
          v += kPixelSteps[d][1];
          q = u < 0 || u >= image.width || v < 0 || v >= image.height ? -1 : v * image.width + u;
          if (q < 0 || own[q] >= 0) break;
        }
        if (steps > kMostHoles + 1 || q < 0 || !((positions[own[q]] - positions[own[p]]).norm() <= min_gap)) continue;
        const Index step = kPixelSteps[d][1] * image.width + kPixelSteps[d][0];
        for (Index at = p; at != q; at += step) joined.links[at] |= 1 << d;
      }
    }
  }
  std::vector<std::vector<Index>> blocks((n + kBlock - 1) / kBlock);
  Lists lists;
  lists.offsets.resize(n + 1);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    PixelSearch search(min_gap > 0.0 ? joined : image, own, positions, min_gap);
    std::vector<Index>& items = blocks[begin / kBlock];
    items.reserve(static_cast<std::size_t>(end - begin) * k);
    std::vector<Neighbor> found;
    for (Index i = begin; i < end; ++i) {
      KNearest nearest(k, found);
      if (pixel[i] >= 0) search.run(pixel[i], nearest);
      for (const Neighbor& neighbor : found) items.push_back(neighbor.index);
      lists.offsets[i + 1] = static_cast<Index>(found.size());
    }
  });
  for (Index i = 0; i < n; ++i) lists.offsets[i + 1] += lists.offsets[i];
  lists.items.reserve(lists.offsets[n]);
  for (const std::vector<Index>& block : blocks) lists.items.insert(lists.items.end(), block.begin(), block.end());
  return lists;
}

}  // namespace deformable_surface::cloud
