#include "camera_frames.h"

#include "deformable_surface/cloud/links.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace deformable_surface::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Vec3 kNothing = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

bool isInside(const std::vector<Vec2>& outline, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vec2 &a = outline[i], &b = outline[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
      inside = !inside;
  }
  return inside;
}

// Whether the straight line between two points within the outline stays within it. It may touch corners.
bool isWithin(const std::vector<Vec2>& outline, const Vec2& from, const Vec2& to) {
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vec2 &a = outline[i], &b = outline[j];
    if (cross(to - from, a - from) * cross(to - from, b - from) < 0.0 && cross(b - a, from - a) * cross(b - a, to - a) < 0.0)
      return false;
  }
  return true;
}

Vec3 findNormal(const Sheet& sheet, const Vec2& at) {
  constexpr double kStep = 1e-5;  // m
  const auto derive = [&](const Vec2& step) { return Vec3(sheet.place(at + step) - sheet.place(at - step)); };
  return derive(Vec2(kStep, 0.0)).cross(derive(Vec2(0.0, kStep))).normalized();
}

// A corner of a triangle on the image: px, and the quantities that are linear there.
struct Corner {
  Vec2 pixel;
  double inverse_depth;  // 1/m
  Vec2 place;            // of the unfolded sheet, over the depth
};

Corner project(const DepthCamera& camera, const Sheet& sheet, const Vec2& at) {
  const Vec3 p = sheet.place(at);
  return {camera.focal_length * p.head<2>() / p.z() + camera.center(), 1.0 / p.z(), at / p.z()};
}

// Draws a triangle into the frame where nothing nearer is.
void draw(const Corner& a, const Corner& b, const Corner& c, Index sheet, CameraFrame& frame) {
  const DepthCamera& camera = frame.camera;
  const double area = cross(b.pixel - a.pixel, c.pixel - a.pixel);
  if (area == 0.0) return;
  const Eigen::Array2d low = a.pixel.cwiseMin(b.pixel).cwiseMin(c.pixel).array().ceil().max(0.0);
  const Eigen::Array2d high =
      a.pixel.cwiseMax(b.pixel).cwiseMax(c.pixel).array().floor().min(Eigen::Array2d(camera.width - 1, camera.height - 1));
  for (Index row = static_cast<Index>(low.y()); row <= high.y(); ++row) {
    for (Index column = static_cast<Index>(low.x()); column <= high.x(); ++column) {
      const Vec2 p(column, row);
      const double share_b = cross(p - a.pixel, c.pixel - a.pixel) / area, share_c = cross(b.pixel - a.pixel, p - a.pixel) / area;
      const double share_a = 1.0 - share_b - share_c;
      if (!(share_a >= 0.0 && share_b >= 0.0 && share_c >= 0.0)) continue;
      const double depth = 1.0 / (share_a * a.inverse_depth + share_b * b.inverse_depth + share_c * c.inverse_depth);
      const Index pixel = row * camera.width + column;
      if (frame.sheet[pixel] >= 0 && frame.positions[pixel].z() <= depth) continue;
      const Vec2 at = depth * (share_a * a.place + share_b * b.place + share_c * c.place);
      if (!isInside(frame.sheets[sheet].outline, at)) continue;
      frame.sheet[pixel] = sheet;
      frame.places[pixel] = at;
      frame.positions[pixel] << depth / camera.focal_length * (p - camera.center()), depth;
    }
  }
}

void drawSheet(Index index, CameraFrame& frame) {
  const Sheet& sheet = frame.sheets[index];
  Eigen::AlignedBox2d box;
  for (const Vec2& corner : sheet.outline) box.extend(corner);
  const Vec2 size = box.sizes();
  const auto divide = [&](double length) {
    return sheet.cell > 0.0 ? std::max<Index>(1, static_cast<Index>(std::ceil(length / sheet.cell))) : Index{1};
  };
  const Index columns = divide(size.x()), rows = divide(size.y());
  std::vector<Corner> last, next;
  for (Index j = 0; j <= rows; ++j) {
    next.clear();
    for (Index i = 0; i <= columns; ++i)
      next.push_back(project(frame.camera, sheet, box.min() + Vec2(size.x() * i / columns, size.y() * j / rows)));
    for (Index i = 0; i < columns && j > 0; ++i) {
      draw(last[i], last[i + 1], next[i], index, frame);
      draw(next[i], last[i + 1], next[i + 1], index, frame);
    }
    last.swap(next);
  }
}

// Pixels that the projector does not reach, because in its image (columns p = x - d) a nearer surface to the right covers them.
// Edges lie half-way between pixels.
void castShadows(CameraFrame& frame) {
  const DepthCamera& camera = frame.camera;
  for (Index row = 0; row < camera.height; ++row) {
    double lowest = kInfinity;
    for (Index column = camera.width - 1; column >= 0; --column) {
      const Index pixel = row * camera.width + column;
      if (frame.sheet[pixel] < 0) continue;
      const double projected = column - camera.disparity(frame.positions[pixel].z());
      frame.in_shadow[pixel] = projected > lowest;
      lowest = std::min(lowest, projected - 0.5);
    }
  }
}

// The same on every platform, with the same number of random numbers for every pixel.
class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}
  double uniform() { return (static_cast<double>(random_()) + 0.5) / 4294967296.0; }
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    return radius * std::cos(2.0 * M_PI * uniform());
  }

 private:
  std::mt19937 random_;
};

// Means over 2 radius + 1 values along rows (or columns), which continue at the other end. White noise keeps its deviation.
void smooth(const DepthCamera& camera, bool along_rows, Index radius, std::vector<double>& noise) {
  const Index length = along_rows ? camera.width : camera.height, lines = along_rows ? camera.height : camera.width;
  const Index step = along_rows ? 1 : camera.width, line_step = along_rows ? camera.width : 1;
  std::vector<double> line(length);
  for (Index l = 0; l < lines; ++l) {
    for (Index i = 0; i < length; ++i) {
      line[i] = 0.0;
      for (Index o = -radius; o <= radius; ++o)
        line[i] += noise[l * line_step + ((i + o) % length + length) % length * step] / std::sqrt(2.0 * radius + 1.0);
    }
    for (Index i = 0; i < length; ++i) noise[l * line_step + i * step] = line[i];
  }
}

Points estimatePositions(CameraFrame& frame) {
  const DepthCamera& camera = frame.camera;
  const Index n = frame.size();
  std::vector<double> noise(n), lost(n), flown(n), mixed(n);
  Draws draws(camera.seed);
  for (Index i = 0; i < n; ++i) {
    noise[i] = draws.normal();
    lost[i] = draws.uniform();
    flown[i] = draws.uniform();
    mixed[i] = draws.uniform();
  }
  for (const bool along_rows : {true, false})
    if (camera.smoothing > 0) smooth(camera, along_rows, camera.smoothing, noise);

  Points seen(n, kNothing);
  for (Index i = 0; i < n; ++i) {
    if (frame.sheet[i] < 0 || lost[i] < camera.missing || (camera.has_shadows && frame.in_shadow[i])) continue;
    double disparity = camera.disparity(frame.positions[i].z());
    if (flown[i] < camera.flying) {
      const Index column = i % camera.width, row = i / camera.width;
      const bool has[] = {column > 0, column + 1 < camera.width, row > 0, row + 1 < camera.height};
      const Index beside[] = {i - 1, i + 1, i - camera.width, i + camera.width};
      for (int k = 0; k < 4 && !frame.flies[i]; ++k) {
        if (!has[k] || frame.sheet[beside[k]] < 0 || areTrueNeighbors(frame, i, beside[k])) continue;
        frame.flies[i] = 1;
        disparity += mixed[i] * (camera.disparity(frame.positions[beside[k]].z()) - disparity);
      }
    }
    disparity += camera.noise * noise[i];
    if (camera.quantum > 0.0) disparity = camera.quantum * std::round(disparity / camera.quantum);
    // A cloud's numbers are floats.
    if (disparity > 0.0)
      seen[i] = (frame.positions[i] * (camera.disparity(1.0) / disparity / frame.positions[i].z())).cast<float>().cast<double>();
  }
  return seen;
}

}  // namespace

double DepthCamera::depthNoise(double depth) const {
  return depth * depth / (focal_length * baseline) * std::sqrt(noise * noise + quantum * quantum / 12.0);
}

CameraFrame takeFrame(const DepthCamera& camera, const std::vector<Sheet>& sheets) {
  CameraFrame frame;
  frame.camera = camera;
  frame.sheets = sheets;
  const Index n = camera.width * camera.height;
  frame.sheet.assign(n, -1);
  frame.positions.assign(n, kNothing);
  frame.normals.assign(n, kNothing);
  frame.places.assign(n, Vec2::Zero());
  frame.flies.assign(n, 0);
  frame.in_shadow.assign(n, 0);
  for (std::size_t s = 0; s < sheets.size(); ++s) drawSheet(static_cast<Index>(s), frame);
  for (Index i = 0; i < n; ++i)
    if (frame.sheet[i] >= 0) frame.normals[i] = findNormal(sheets[frame.sheet[i]], frame.places[i]);
  castShadows(frame);
  frame.cloud.width = static_cast<std::uint32_t>(camera.width);
  frame.cloud.height = static_cast<std::uint32_t>(camera.height);
  frame.clean = frame.cloud;
  frame.cloud.positions = estimatePositions(frame);
  frame.clean.positions = frame.positions;
  for (Index i = 0; i < n; ++i)
    if (!frame.isSeen(i)) frame.clean.positions[i] = kNothing;
  return frame;
}

double findTrueDistance(const CameraFrame& frame, Index pixel, Index other) {
  if (frame.sheet[pixel] != frame.sheet[other] || frame.sheet[pixel] < 0) return kInfinity;
  const Sheet& sheet = frame.sheets[frame.sheet[pixel]];
  const Vec2 &from = frame.places[pixel], &to = frame.places[other];
  const auto measure = [&](const Vec2& a, const Vec2& b) {
    constexpr int kPieces = 6;  // chords of a half circle that are 1 % shorter
    double length = 0.0;
    Vec3 last = sheet.place(a);
    for (int k = 1; k <= kPieces; ++k) {
      const Vec3 next = sheet.place(a + (b - a) * k / kPieces);
      length += (next - last).norm();
      last = next;
    }
    return length;
  };
  if (isWithin(sheet.outline, from, to)) return measure(from, to);
  double shortest = kInfinity;
  for (const Vec2& corner : sheet.outline)
    if (isWithin(sheet.outline, from, corner) && isWithin(sheet.outline, corner, to))
      shortest = std::min(shortest, measure(from, corner) + measure(corner, to));
  return shortest;
}

bool areTrueNeighbors(const CameraFrame& frame, Index pixel, Index other) {
  if (frame.sheet[pixel] != frame.sheet[other] || frame.sheet[pixel] < 0) return false;
  const Vec3 &a = frame.positions[pixel], &b = frame.positions[other];
  return findTrueDistance(frame, pixel, other) < 2.0 * ((a - b).norm() + std::max(a.z(), b.z()) / frame.camera.focal_length);
}

std::vector<Index> findTruePieces(const CameraFrame& frame, Index min_size) {
  const Index width = frame.camera.width, height = frame.camera.height;
  constexpr Index kReach = 2;  // px, over a pixel that is missing
  std::vector<std::pair<Index, Index>> links;
  for (Index i = 0; i < frame.size(); ++i) {
    if (!frame.isSeen(i)) continue;
    for (Index row = i / width; row <= std::min(height - 1, i / width + kReach); ++row)
      for (Index column = std::max(0, i % width - kReach); column <= std::min(width - 1, i % width + kReach); ++column) {
        const Index j = row * width + column;
        if (j > i && frame.isSeen(j) && areTrueNeighbors(frame, i, j)) links.emplace_back(i, j);
      }
  }
  Index count = 0;
  const std::vector<Index> piece = cloud::labelComponents(frame.size(), links, count);
  std::vector<Index> sizes(count, 0);
  for (const Index p : piece) ++sizes[p];
  sizes.erase(std::remove_if(sizes.begin(), sizes.end(), [&](Index size) { return size < min_size; }), sizes.end());
  std::sort(sizes.rbegin(), sizes.rend());
  return sizes;
}

}  // namespace deformable_surface::test
