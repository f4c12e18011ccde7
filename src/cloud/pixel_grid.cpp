#include "pixel_grid.h"

#include "deformable_surface/base/median.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::cloud {
namespace {

constexpr Index kMostLines = 8192;  // rows or columns
constexpr double kLineGap = 0.25;   // of the spacing if there were kMostLines: values nearer than that are of one line
constexpr double kOffLine = 0.1;    // of the spacing of lines, as findDepthImage() tolerates
constexpr Index kMostSparse = 4;    // pixels per point: with fewer points, no neighbours are left
constexpr Index kFewestLines = 3;

// Evenly spaced lines on which all values lie; spacing 0: there are none.
struct Lines {
  double first = 0.0, spacing = 0.0;
  Index count = 0;

  Index at(double value) const { return static_cast<Index>(std::lround((value - first) / spacing)); }
};

Lines findLines(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const double least = kLineGap * (values.back() - values.front()) / kMostLines;
  if (!(least > 0.0)) return {};
  std::vector<double> middles, steps;
  double first = values.front();
  for (std::size_t i = 1; i <= values.size(); ++i) {
    if (i < values.size() && values[i] - values[i - 1] <= least) continue;
    middles.push_back(0.5 * (first + values[i - 1]));
    if (i < values.size()) first = values[i];
    if (middles.size() > static_cast<std::size_t>(kMostLines)) return {};
  }
  if (middles.size() < static_cast<std::size_t>(kFewestLines)) return {};
  for (std::size_t m = 1; m < middles.size(); ++m) steps.push_back(middles[m] - middles[m - 1]);
  // From line to line, so that an error of the spacing does not add up; lines may be missing.
  const double step = findMedian(std::move(steps));
  Index last = 0;
  for (std::size_t m = 1; m < middles.size(); ++m) last += static_cast<Index>(std::lround((middles[m] - middles[m - 1]) / step));
  if (last < kFewestLines - 1 || last >= kMostLines) return {};
  const Lines lines{middles.front(), (middles.back() - middles.front()) / last, last + 1};
  for (const double value : values)
    if (!(std::abs(value - lines.first - lines.spacing * lines.at(value)) <= kOffLine * lines.spacing)) return {};
  return lines;
}

}  // namespace

std::optional<PixelGrid> findPixelGrid(const PointCloud& input, const CleanCloud& cloud) {
  std::vector<double> across, down;
  std::vector<Index> seen;
  for (Index i = 0; i < input.size(); ++i) {
    const Vec3 p = input.positions[i] - input.eye();
    if (cloud.point_of_input[i] < 0 || p.isZero(0.0)) continue;
    if (!(p.z() > 0.0)) return std::nullopt;
    across.push_back(p.x() / p.z());
    down.push_back(p.y() / p.z());
    seen.push_back(i);
  }
  if (seen.empty()) return std::nullopt;
  const Lines columns = findLines(across);
  if (columns.count == 0) return std::nullopt;
  const Lines rows = findLines(down);
  if (rows.count == 0 || std::int64_t{columns.count} * rows.count > std::int64_t{kMostSparse} * static_cast<Index>(seen.size()))
    return std::nullopt;

  PixelGrid grid{columns.count, rows.count, std::vector<Index>(std::size_t(columns.count) * rows.count, -1)};
  for (std::size_t s = 0; s < seen.size(); ++s) {
    Index& input_of = grid.input[std::size_t(rows.at(down[s])) * grid.width + columns.at(across[s])];
    // Repeated points are one point of the cleaned cloud.
    if (input_of >= 0 && cloud.point_of_input[input_of] != cloud.point_of_input[seen[s]]) return std::nullopt;
    if (input_of < 0) input_of = seen[s];
  }
  return grid;
}

}  // namespace deformable_surface::cloud
