#include "deformable_surface/ros/convert/text_place.h"

#include <algorithm>
#include <vector>

namespace deformable_surface::node {
namespace {

// Letters that are readable in a window with the whole surface; on small surfaces large enough for RViz's line spacing.
constexpr double kLetterShare = 0.035, kSmallestLetter = 0.004;
// RViz sets lines of any height this far apart, m.
constexpr double kLineSpacing = 0.01;
// About as wide as the surface.
constexpr std::size_t kColumns = 44;

}  // namespace

Box findMainBox(const Points& points) {
  Box box;
  std::vector<double> all(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), all.begin(), [axis](const Vec3& p) { return p[axis]; });
    std::sort(all.begin(), all.end());
    const double lower = all[all.size() / 10], upper = all[all.size() - 1 - all.size() / 10], width = upper - lower;
    box.low[axis] = *std::lower_bound(all.begin(), all.end(), lower - width);
    box.high[axis] = *std::prev(std::upper_bound(all.begin(), all.end(), upper + width));
  }
  return box;
}

TextPlace placeText(const Box& box, const std::string& frame_id) {
  const Vec3 up = frame_id.find("optical") == std::string::npos ? Vec3::UnitZ() : Vec3(-Vec3::UnitY());
  TextPlace place;
  place.height = std::max(kLetterShare * box.extent(), kSmallestLetter);
  // Outside the ball around the surface: not in front of it from the side, nor from above at half a right angle.
  place.anchor = 0.5 * (box.low + box.high) + (0.5 * box.extent() + kRowsBelow * (place.height + kLineSpacing)) * up;
  return place;
}

std::string showFromRow(int row, const std::string& lines) {
  const int after = 2 * kRowsAbove - 1 - row - static_cast<int>(std::count(lines.begin(), lines.end(), '\n'));
  return std::string(row, '\n') + lines + std::string(std::max(0, after), '\n');
}

std::string showBelow(const std::string& sentence) {
  std::string lines;
  std::size_t column = 0, num_rows = 1;
  for (std::size_t begin = 0; begin < sentence.size();) {
    const std::size_t end = std::min(sentence.find_first_of(" \n", begin), sentence.size());
    const std::size_t length = std::min(end - begin, kColumns);
    if (column > 0 && column + 1 + length > kColumns) {
      if (++num_rows == kRowsBelow) {
        lines += " ...";
        break;
      }
      lines += '\n';
      column = 0;
    }
    if (column > 0) lines += ' ';
    lines += sentence.substr(begin, length);
    column += length + (column > 0);
    begin = end + 1;
  }
  return showFromRow(kRowsAbove + 1, lines);
}

}  // namespace deformable_surface::node
