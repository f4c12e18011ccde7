#include "deformable_surface/cloud/flying_pixels.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <cmath>
#include <limits>
#include <string>

namespace deformable_surface::cloud {
namespace {

constexpr int kWidest = 2;  // pixels of a mixed edge: blur of the optics, or interpolation of a resampled frame
// How far to search for points on a side: the shadow of a projector beside an outline is some dozens of pixels wide.
constexpr int kReach = 48;
constexpr Index kBlock = 4;  // rows

/// The first points on one side of a pixel: distances in pixels, and 1 / distance from the eye.
struct Side {
  int step[kWidest + 1];
  double w[kWidest + 1];
  int count = 0;

  /// Extrapolates the surface that begins with its g-th point to the pixel.
  double extrapolate(int g) const {
    const double slope = (w[g + 1] - w[g]) / (step[g + 1] - step[g]);
    return w[g] - slope * step[g];
  }
};

class Grid {
 public:
  explicit Grid(const PointCloud& cloud) : width_(static_cast<int>(cloud.width)), height_(static_cast<int>(cloud.height)) {
    const Vec3 eye = cloud.eye();
    w_.resize(cloud.positions.size());
    for (std::size_t i = 0; i < w_.size(); ++i) w_[i] = 1.0 / (cloud.positions[i] - eye).norm();
  }

  int width() const { return width_; }
  int height() const { return height_; }
  double at(int row, int column) const { return w_[static_cast<std::size_t>(row) * width_ + column]; }

  Side look(int row, int column, int down, int right) const {
    Side side;
    for (int step = 1; step <= kReach && side.count <= kWidest; ++step) {
      const int r = row + step * down, c = column + step * right;
      if (r < 0 || r >= height_ || c < 0 || c >= width_) break;
      const double w = at(r, c);
      if (!std::isfinite(w)) continue;
      side.step[side.count] = step;
      side.w[side.count++] = w;
    }
    return side;
  }

  bool flies(int row, int column, double jump) const {
    const double w = at(row, column);
    if (!std::isfinite(w)) return false;
    // Every outline crosses rows or columns. Diagonals would only look past corners.
    for (const bool along_row : {true, false}) {
      const Side one = look(row, column, !along_row, along_row);
      const Side other = look(row, column, -!along_row, -along_row);
      // The surfaces begin next to the pixel, or behind a second mixed pixel. Anything wider is an object.
      for (int g = 0; g < kWidest && g + 1 < one.count && g + 1 < other.count; ++g) {
        const bool is_wide = !(std::abs(one.w[0] - w) > jump) && !(std::abs(other.w[0] - w) > jump);
        const bool is_between = (one.w[g] > w) != (other.w[g] > w);
        const double tolerance = (g + 1) * jump;  // the error of extrapolation grows with the distance
        const auto continues = [&](const Side& side) {
          return !(std::abs(side.w[g] - w) > tolerance) || !(std::abs(side.extrapolate(g) - w) > tolerance);
        };
        if (!is_wide && is_between && !continues(one) && !continues(other)) return true;
      }
    }
    return false;
  }

 private:
  int width_, height_;
  std::vector<double> w_;  // 1/m; not finite without a point
};

}  // namespace

std::vector<char> findFlyingPixels(const PointCloud& cloud, double jump) {
  if (cloud.width < 2 || cloud.height < 2) {
    throw InputError("flying pixels: found a cloud of " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                     " points; accepted: organised clouds, with the rows and columns of a camera");
  }
  if (!(jump > 0.0)) throw InputError("flying pixels: found a jump of " + std::to_string(jump) + " m; accepted: above 0");
  const Grid grid(cloud);
  std::vector<char> flying(cloud.positions.size(), 0);
  parallelFor(grid.height(), kBlock, [&](Index begin, Index end) {
    for (int row = begin; row < end; ++row)
      for (int column = 0; column < grid.width(); ++column)
        flying[static_cast<std::size_t>(row) * grid.width() + column] = grid.flies(row, column, jump);
  });
  return flying;
}

}  // namespace deformable_surface::cloud
