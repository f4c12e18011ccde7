#include "settle_pixels.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/pixel_links.h"

#include <algorithm>
#include <cmath>

#include "link_pixels.h"

namespace deformable_surface::cloud {
namespace {

constexpr Index kRowsPerTask = 8;
constexpr int kRounds = 4;  // a wrong pixel is corrected after one round; more than two adjacent ones are rare
// Squared deviations that one vote outweighs. Of 1, 2, 3, 5 and 8 for synthetic frames with layers four and five deviations
// apart, 2 and 3 left the fewest pixels on the wrong side: with more, corners are removed.
constexpr double kVote = 2.0;

// The plane that a pixel took, or would take, at that place.
struct Taken {
  double value;
  PixelPlane plane;
};

bool agree(const Taken& a, const Taken& b, double least_step) {
  return std::abs(a.value - b.value) <= std::max(least_step, sureStep(a.plane, b.plane));
}

}  // namespace

void settlePixels(const DepthImage& image, const NoiseProfile& noise, FittedDepths& fitted) {
  const Index width = image.width, height = image.height;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> values = fitted.inverse_depth;
    const std::vector<PixelPlane> planes = fitted.planes;
    parallelFor(height, kRowsPerTask, [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        for (Index u = 0; u < width; ++u) {
          const std::size_t p = std::size_t(v) * width + u;
          if (!(values[p] > 0.0)) continue;
          // Values that the surrounding pixels predict at this one.
          Taken around[9] = {{values[p], planes[p]}};
          int count = 1;
          bool is_beside_step = false;
          const double step = leastStep(image, values[p]);
          for (const auto& to : kPixelSteps) {
            const Index x = u + to[0], y = v + to[1];
            if (x < 0 || x >= width || y < 0 || y >= height) continue;
            const std::size_t q = std::size_t(y) * width + x;
            if (!(values[q] > 0.0)) continue;
            const double there = values[q] - planes[q].along_u * to[0] - planes[q].along_v * to[1];
            if (!(there > 0.0)) continue;
            around[count++] = {there, planes[q]};
            is_beside_step = is_beside_step || !agree(around[0], around[count - 1], step);
          }
          if (!is_beside_step) continue;
          const double deviation = fitted.factor * noise.at(image.inverse_depth[p]);
          double least = 0.0;
          int best = 0;
          for (int c = 0; c < count; ++c) {
            if (c > 0 && agree(around[0], around[c], step)) continue;
            const double misfit = (around[c].value - image.inverse_depth[p]) / deviation;
            if (c > 0 && !(std::abs(misfit) < kOutlier)) continue;
            double cost = misfit * misfit;
            for (int k = 1; k < count; ++k) cost -= kVote * agree(around[k], around[c], step);
            if (c == 0 || cost < least) {
              least = cost;
              best = c;
            }
          }
          if (best == 0) continue;
          fitted.inverse_depth[p] = around[best].value;
          fitted.planes[p] = around[best].plane;
        }
      }
    });
  }
}

}  // namespace deformable_surface::cloud
