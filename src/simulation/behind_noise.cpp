#include "behind_noise.h"

#include "deformable_surface/base/median.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/sensor_noise.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

// Above the share of points at the edges of parts.
constexpr double kMostUnexplained = 0.02;  // of the points
// Factor on the gap that is taken for surface: in synthetic frames, layers farther apart had no links between them at any noise
// (docs/geodesics.md).
constexpr double kSureGap = 3.0;
// Fraction of the spacing, for the noise left by the windows: above it, areas and masses are too large by a tenth or more.
constexpr double kMostLeft = 0.5;

std::string formatLength(double length) {
  return length < 1.0 ? formatShort(1000.0 * length) + " mm" : formatShort(length) + " m";
}

// No depth camera sees so far, and few surfaces and bodies are as large. In millimetres, a metre is a thousand. Points that are
// farther away than any lens shows them apart have the coordinates of a map.
void warnOfUnits(const cloud::SensorNoise& noise, RestSurface& s) {
  constexpr double kFarthest = 50.0, kLargest = 50.0;  // m
  constexpr double kMap = 1000.0;                      // times the length of the cloud
  const char* const kAdvice = ": lengths are in metres, and these look like millimetres (of a file: cloud.scale 0.001)";
  Eigen::AlignedBox3d box;
  for (const Vec3& p : s.dense.positions) box.extend(p);
  const double length = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
  if (noise.is_image) {
    std::vector<double> distances;
    for (const Vec3& p : s.dense.positions) distances.push_back((p - noise.eye).norm());
    const double middle = findMedian(std::move(distances));
    if (middle > std::max(kFarthest, kMap * length))
      s.warnings.push_back("the cloud is " + formatLength(length) + " long, and " + formatLength(middle) +
                           " from where it was seen: coordinates of a map lose digits; subtract an offset from them");
    else if (middle > kFarthest)
      s.warnings.push_back("half of the cloud's points are more than " + formatLength(middle) + " from the eye" + kAdvice);
  } else if (length > kLargest) {
    s.warnings.push_back("the cloud is " + formatLength(length) + " long" + kAdvice);
  }
}

}  // namespace

std::optional<Vec3> moveOntoSurface(const InputParams& params, const cloud::PointCloud& input, RestSurface& s) {
  cloud::SensorNoise noise = cloud::findSensorNoise(input, s.dense, params.noise);
  s.is_thick = noise.is_thick;
  if (noise.is_thick)
    s.warnings.push_back(
        "the cloud's points scatter as far off any surface as along it: neighbours are the nearest in space, "
        "and no gap is told (input.noise 0: the points are exact)");
  warnOfUnits(noise, s);
  if (noise.num_levels > 0)
    s.warnings.push_back("the cloud's depths take only " + std::to_string(noise.num_levels) + " values, " +
                         formatLength(noise.level_step) +
                         " from one to the next: steps of the sensor look like gaps between flat parts, and are taken for "
                         "gaps; if they are steps, input.noise " +
                         formatShort(0.5 * noise.level_step) + " makes them one surface");
  if (noise.surface.empty()) return input.viewpoint;
  for (std::size_t i = 0; i < noise.surface.size(); ++i) s.off_surface.push_back(s.dense.positions[i] - noise.surface[i]);
  s.dense.positions = std::move(noise.surface);
  s.pixel_links = std::move(noise.links);
  const std::string window = noise.is_image ? formatShort(noise.window) + " x " + formatShort(noise.window) + " points"
                                            : "about " + formatShort(std::round(noise.window * noise.window)) + " points";
  s.notes.push_back("noise of " + formatLength(noise.deviation) + " along " +
                    (noise.is_seen ? "the line of sight" : "the normal (from where the points were seen is not known)") + ", " +
                    formatShort(noise.deviation / noise.spacing) + " spacings: the surface is where windows of " + window +
                    " have it; gaps below " + formatLength(noise.least_gap) +
                    " in that direction are taken for surface, and links may lead across those below " +
                    formatLength(kSureGap * noise.least_gap) +
                    (params.noise.is_auto ? "; if the points are exact, input.noise 0" : ""));
  const double left = noise.deviation / noise.window;
  if (left > kMostLeft * noise.spacing)
    s.warnings.push_back(
        "noise of " + formatLength(noise.deviation) + " is too much for windows of " + window + ", which leave about " +
        formatLength(left) + " of it, " + formatShort(left / noise.spacing) +
        " spacings: the surface is rough, and its area too large (fewer pixels with less noise each, or the mean "
        "of several frames)");
  if (noise.unexplained > kMostUnexplained * static_cast<double>(s.dense.positions.size()))
    s.warnings.push_back(formatCount(noise.unexplained, "of ") + std::to_string(s.dense.positions.size()) +
                         " points fit no window that this noise explains, and are moved to the nearest one: there the "
                         "surface is a guess (input.noise)");
  if (noise.is_grid_found)
    s.notes.push_back(
        "the points came without rows and columns, but lie on the lines of sight of a camera's pixels: these are used");
  if (noise.is_eye_found) s.notes.push_back("rows and columns show that the points were seen from " + formatPlace(noise.eye));
  return noise.is_seen ? std::optional<Vec3>(noise.eye) : input.viewpoint;
}

void warnOfUnits(RestSurface& s) { warnOfUnits(cloud::SensorNoise(), s); }

void warnOfNoisyBody(const InputParams& params, const cloud::PointCloud& input, RestSurface& s) {
  const bool is_image = input.height > 1;
  const cloud::SensorNoise noise = is_image ? cloud::findSensorNoise(input, s.dense, params.noise) : cloud::SensorNoise();
  warnOfUnits(noise, s);
  if (!noise.is_image || noise.surface.empty()) return;
  s.warnings.push_back("the cloud is the image of a surface with noise of " + formatLength(noise.deviation) +
                       ", which elastic_solid.fill: false takes for the thickness of a body (accepted: points all through the "
                       "body; or input.noise 0, if they are)");
}

}  // namespace deformable_surface::simulation
