#include "deformable_surface/cloud/sensor_noise.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"

#include <algorithm>
#include <cmath>

#include "depth_windows.h"
#include "link_pixels.h"
#include "scattered_windows.h"
#include "settle_pixels.h"

namespace deformable_surface::cloud {
namespace {

constexpr Index kMostRadius = 8;  // pixels
constexpr Index kFewestInWindow = 16, kMostInWindow = 128;
constexpr double kMostUnexplained = 0.015;  // fraction of the points: with more, the surface is curved within its windows
constexpr double kMostShape = 0.05;
// Fraction of the distance to the surface: two points seen in the same direction stay separate.
constexpr double kWay = 0.999;
// A step seen through the middle of a window of n samples adds a sixteenth of its square to their variance. Noise makes three
// standard deviations of its own, sigma^2 sqrt(18 / n). Below 3.5 sigma, no window separated steps.
constexpr double kStepShare = 16.0, kLeastStep = 3.5;
// Mean number of the eight neighbours of a pixel that have a depth: with fewer, the links fall into pieces at missing pixels. A
// random half of missing pixels left dozens of pieces, a third none.
constexpr double kFewestBeside = 5.0;

bool isNoticed(const SensorNoise& noise) {
  return noise.spacing > 0.0 && noise.deviation > 0.0 && noise.deviation >= kNoticed * noise.spacing;
}

double findLeastGap(double deviation, double samples) {
  return deviation * std::max(kLeastStep, std::sqrt(kStepShare * kSurprise * std::sqrt(2.0 / samples)));
}

bool isDense(const DepthImage& image) {
  const Index width = image.width, height = image.height;
  std::int64_t seen = 0, beside = 0;
  for (Index p = 0; p < width * height; ++p) {
    if (!(image.inverse_depth[p] > 0.0)) continue;
    ++seen;
    for (const auto& step : kPixelSteps) {
      const Index u = p % width + step[0], v = p / width + step[1];
      beside += u >= 0 && u < width && v >= 0 && v < height && image.inverse_depth[std::size_t(v) * width + u] > 0.0;
    }
  }
  return static_cast<double>(beside) >= kFewestBeside * static_cast<double>(seen);
}

// Returns false and does nothing if too few pixels have depths around them.
bool fitImage(const DepthImage& image, const CleanCloud& cloud, const OrAuto<double>& deviation, SensorNoise& noise) {
  NoiseProfile profile = measureNoise(image);
  if (profile.isEmpty()) return false;
  noise.is_image = noise.is_seen = true;
  noise.eye = image.eye;
  noise.is_eye_found = image.is_eye_found;
  noise.is_grid_found = image.is_grid_found;
  std::vector<double> deviations, spacings;
  for (const double w : image.inverse_depth) {
    if (!(w > 0.0)) continue;
    deviations.push_back(profile.at(w) / (w * w));
    spacings.push_back(image.pixel() / w);
  }
  noise.deviation = findMedian(std::move(deviations));
  noise.spacing = findMedian(std::move(spacings));
  if (!deviation.is_auto) {
    const double depth = noise.spacing / image.pixel();
    if (noise.deviation > 0.0)
      profile.scale(deviation.value / noise.deviation);
    else
      profile = NoiseProfile(deviation.value / (depth * depth));
    noise.deviation = deviation.value;
  }
  if (deviation.is_auto) {
    const double depth = noise.spacing / image.pixel();
    noise.num_levels = static_cast<Index>(profile.numFewLevels());
    noise.level_step = profile.fewLevelsStep() * depth * depth;
  }
  if (!isNoticed(noise)) return true;

  const double wanted = std::ceil(0.5 * (noise.deviation / (kNoticed * noise.spacing) - 1.0));
  Index radius = static_cast<Index>(std::clamp(wanted, 1.0, static_cast<double>(kMostRadius)));
  FittedDepths fitted = fitWindows(image, profile, radius);
  const double most = kMostUnexplained * static_cast<double>(cloud.positions.size());
  while (radius > 1 && fitted.unexplained > most) fitted = fitWindows(image, profile, --radius);
  noise.unexplained = fitted.unexplained;
  noise.window = 2 * radius + 1;
  noise.least_gap = findLeastGap(fitted.factor * noise.deviation, noise.window * noise.window);
  settlePixels(image, profile, fitted);
  if (isDense(image)) {
    noise.links = linkPixels(image, fitted);
    if (image.is_grid_found) noise.links.input = image.input;
  }
  noise.surface = cloud.positions;
  for (Index v = 0; v < image.height; ++v) {
    for (Index u = 0; u < image.width; ++u) {
      const std::size_t pixel = std::size_t(v) * image.width + u;
      const Index i = image.input[pixel] < 0 ? -1 : cloud.point_of_input[image.input[pixel]];
      const double before = image.inverse_depth[pixel], after = fitted.inverse_depth[pixel];
      // A point that several pixels repeat moves only once.
      if (i >= 0 && before > 0.0 && noise.surface[i] == cloud.positions[i])
        noise.surface[i] += kWay * (1.0 / after - 1.0 / before) * image.ray(u, v);
    }
  }
  return true;
}

void fitScattered(const PointCloud& input, const CleanCloud& cloud, const OrAuto<double>& deviation, SensorNoise& noise) {
  const ScatteredNoise measured = measureNoise(cloud.positions, *findTree(cloud));
  noise.deviation = deviation.valueOr(measured.deviation);
  noise.spacing = measured.spacing;
  noise.is_thick = deviation.is_auto && measured.is_thick;
  if (!isNoticed(noise)) return;
  const double ratio = noise.deviation / (kNoticed * noise.spacing);
  Index count = static_cast<Index>(std::clamp(std::ceil(ratio * ratio), 1.0 * kFewestInWindow, 1.0 * kMostInWindow));
  const double most = kMostUnexplained * static_cast<double>(cloud.positions.size());
  FittedPoints fitted = fitWindows(cloud.positions, input.eye(), noise.deviation, measured.deviation, count);
  while (count > kFewestInWindow && fitted.unexplained > most) {
    count = std::max(kFewestInWindow, count / 2);
    fitted = fitWindows(cloud.positions, input.eye(), noise.deviation, measured.deviation, count);
  }
  // A larger share does not lie at edges: it is not noise.
  if (deviation.is_auto && fitted.unexplained > kMostShape * static_cast<double>(cloud.positions.size())) return;
  noise.unexplained = fitted.unexplained;
  noise.is_seen = fitted.is_seen;
  noise.eye = input.eye();
  noise.window = std::sqrt(static_cast<double>(count));
  noise.least_gap = findLeastGap(noise.deviation, count);
  noise.surface = std::move(fitted.positions);
  for (std::size_t i = 0; i < noise.surface.size(); ++i)
    noise.surface[i] = cloud.positions[i] + kWay * (noise.surface[i] - cloud.positions[i]);
}

}  // namespace

SensorNoise findSensorNoise(const PointCloud& input, const CleanCloud& cloud, const OrAuto<double>& deviation) {
  if (!deviation.is_auto && !(deviation.value >= 0.0))
    throw InputError("findSensorNoise: the deviation is " + std::to_string(deviation.value) + " m; accepted: 0 or more");
  SensorNoise noise;
  if (!deviation.is_auto && deviation.value == 0.0) return noise;
  const std::optional<DepthImage> image = findDepthImage(input, cloud);
  if (image && fitImage(*image, cloud, deviation, noise)) return noise;
  if (cloud.positions.size() > static_cast<std::size_t>(kFewestInWindow)) fitScattered(input, cloud, deviation, noise);
  return noise;
}

}  // namespace deformable_surface::cloud
