#include "thin_blade.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

using geometry::Solid;
using tool::Pose;
using tool::ToolParams;

// Of the spacing: thin enough that hardly a particle lies within, thick enough to be found between samples.
constexpr double kThickness = 0.04;
constexpr double kLength = 0.5;  // of the spacing, of a needle's blade along its way
constexpr double kNeedle = 0.7;  // a section whose edges differ by less than this factor has no flat side
constexpr double kStill = 1e-6;  // of the spacing: a shorter way has no direction

// Edges of the box around the solid in its frame, m.
Vec3 findEdges(const Solid& shape) {
  if (shape.kind == Solid::Kind::kBox) return shape.size;
  return {2.0 * shape.radius, 2.0 * shape.radius, shape.kind == Solid::Kind::kSphere ? 2.0 * shape.radius : shape.height};
}

// Numbers of the edges, the shortest first.
std::array<int, 3> sortEdges(const Vec3& size) {
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size[a] < size[b]; });
  return order;
}

Vec3 interpolatePoint(const Points& before, const Points& after, std::size_t i, double share) {
  return before[i] + share * (after[i] - before[i]);
}

}  // namespace

std::vector<ThinBlade> findBlades(const ToolParams& knife, double time, double step, const Points& before, const Points& after,
                                  const Orientations& orientations, double reach, double spacing) {
  std::vector<ThinBlade> blades;
  if (knife.shape.kind == Solid::Kind::kMesh) return {{knife, time, step, before, after}};
  const Vec3 size = findEdges(knife.shape);
  const std::array<int, 3> edge = sortEdges(size);
  const bool is_sphere = knife.shape.kind == Solid::Kind::kSphere;
  ToolParams thin = knife;
  const bool is_needle = size[edge[0]] > kNeedle * size[edge[1]];
  if (!is_needle) {  // cylinders and cones are discs then
    double& thickness = knife.shape.kind == Solid::Kind::kBox ? thin.shape.size[edge[0]] : thin.shape.height;
    thickness = std::min(kThickness * spacing, thickness);
    return {{thin, time, step, before, after}};
  }

  // From corner to corner of the way.
  std::vector<double> times{time};
  tool::forEachCorner(knife.path, time, time + step, [&](double corner) { times.push_back(corner); });
  times.push_back(time + step);
  for (std::size_t part = 0; part + 1 < times.size(); ++part) {
    const double begin = times[part], end = times[part + 1], from = (begin - time) / step, to = (end - time) / step;
    const Pose first = tool::interpolate(knife.path, begin), last = tool::interpolate(knife.path, end);
    // The particles near its way, in its frame: where they are in the mean, and how they move.
    Vec3 place = Vec3::Zero(), move = Vec3::Zero(), normal = Vec3::Zero();
    double count = 0.0;
    const double way = (last.position - first.position).norm() + reach;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Vec3 p = interpolatePoint(before, after, i, from), q = interpolatePoint(before, after, i, to);
      const Vec3 near = first.orientation.conjugate() * (p - first.position);
      if (!(geometry::findSignedDistance(knife.shape, near, way).distance <= way)) continue;
      const Vec3 side = orientations[i] * Vec3::UnitZ();
      place += near;
      move += q - p;
      normal += side.dot(normal) < 0.0 ? Vec3(-side) : side;
      count += 1.0;
    }
    if (!(count > 0.0)) continue;
    place /= count;
    const Vec3 axis = is_sphere ? Vec3(normal.normalized()) : Vec3(first.orientation * Vec3::Unit(edge[2]));
    // How the needle moves there, seen from the particles and across its axis.
    Vec3 travel = (last.position + last.orientation * place) - (first.position + first.orientation * place) - move / count;
    travel -= travel.dot(axis) * axis;
    if (!(travel.norm() > kStill * spacing)) continue;
    Mat3 frame;
    frame.col(0) = travel.normalized();
    frame.col(2) = axis;
    frame.col(1) = axis.cross(frame.col(0));
    const Quaternion turn(frame);
    ThinBlade blade{thin, begin, end - begin, {}, {}};
    blade.tool.shape = Solid();
    blade.tool.shape.kind = Solid::Kind::kBox;
    blade.tool.shape.size = Vec3(kLength * spacing, kThickness * spacing, size[edge[2]]);
    const auto waypointAt = [&](double at, const Pose& pose) {
      const Quaternion orientation = pose.orientation * first.orientation.conjugate() * turn;
      return tool::WaypointParams{at, pose.position, orientation.coeffs()};
    };
    blade.tool.path = {waypointAt(begin, first), waypointAt(end, last)};
    for (std::size_t i = 0; i < before.size(); ++i) {
      blade.before.push_back(interpolatePoint(before, after, i, from));
      blade.after.push_back(interpolatePoint(before, after, i, to));
    }
    blades.push_back(std::move(blade));
  }
  return blades;
}

}  // namespace deformable_surface::simulation
