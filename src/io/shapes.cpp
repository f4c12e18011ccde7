// The generated clouds: grids, flat, wavy or with a slit, a lattice, a chain, and spheres or parts of them.
#include "deformable_surface/io/shapes.h"

#include "deformable_surface/base/error.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::io {

namespace {

/// Uniform numbers in [-1, 1). The standard fixes the engine but not its distributions, so the arithmetic is our own.
class Jitter {
 public:
  Jitter(Index seed, double share) : engine_(static_cast<std::uint32_t>(seed)), share_(share) {}

  /// A shift of up to the share of the spacing.
  double draw(double spacing) {
    // 53 random bits fill a double's mantissa.
    const std::uint64_t high = engine_(), low = engine_();
    const double unit = std::ldexp(static_cast<double>((high << 21) ^ (low >> 11)), -53);
    return share_ * spacing * (2.0 * unit - 1.0);
  }

 private:
  std::mt19937 engine_;
  double share_;
};

/// The spacing at which count, which falls with it, is the number of points.
template <class Count>
double findSpacing(double points, double shortest, double longest, const Count& count) {
  // Bisection of the exponent, to the last bits of a double.
  for (int i = 0; i < 100; ++i) {
    const double middle = std::sqrt(shortest * longest);
    (count(middle) > points ? shortest : longest) = middle;
  }
  return longest;
}

std::vector<double> makeTicks(double from, double to, Index count) {
  std::vector<double> ticks(count);
  for (Index i = 0; i < count; ++i) ticks[i] = from + (to - from) * i / (count - 1);
  return ticks;
}

/// The smaller distance to the ticks beside tick i.
double localSpacing(const std::vector<double>& ticks, Index i) {
  const Index last = static_cast<Index>(ticks.size()) - 1;
  const double before = i > 0 ? ticks[i] - ticks[i - 1] : ticks[1] - ticks[0];
  const double after = i < last ? ticks[i + 1] - ticks[i] : before;
  return std::min(before, after);
}

/// The grid points (u, v) that exist, row by row, jittered; points on an edge move along it, corners stay.
template <class Exists>
std::vector<Vec2> makeGrid(const std::vector<double>& u, const std::vector<double>& v, const Exists& exists, Jitter& jitter) {
  const Index nu = static_cast<Index>(u.size()), nv = static_cast<Index>(v.size());
  const auto has = [&](Index i, Index j) { return i >= 0 && i < nu && j >= 0 && j < nv && exists(i, j); };
  std::vector<Vec2> grid;
  for (Index j = 0; j < nv; ++j) {
    for (Index i = 0; i < nu; ++i) {
      if (!has(i, j)) continue;
      const bool free_u = has(i - 1, j) && has(i + 1, j), free_v = has(i, j - 1) && has(i, j + 1);
      // The corner of a slit has all four neighbours, but not all diagonal ones.
      const bool corner = free_u && free_v && !(has(i - 1, j - 1) && has(i + 1, j - 1) && has(i - 1, j + 1) && has(i + 1, j + 1));
      const double du = jitter.draw(localSpacing(u, i)), dv = jitter.draw(localSpacing(v, j));
      grid.emplace_back(u[i] + (free_u && !corner ? du : 0.0), v[j] + (free_v && !corner ? dv : 0.0));
    }
  }
  return grid;
}

Points makeSheet(const simulation::CloudParams& params, double x_start, Jitter& jitter) {
  const double length = params.size.x(), width = params.size.y();
  const double spacing = findSpacing(params.points, 1e-6 * std::min(length, width), length + width,
                                     [&](double h) { return (length / h + 1.0) * (width / h + 1.0); });
  // The shorter side first, so that a sheet of two rows gets the right count, too.
  const auto roundCount = [](double count) { return std::max(Index{2}, static_cast<Index>(std::lround(count))); };
  Index nx, ny;
  if (length >= width) {
    ny = roundCount(width / spacing + 1.0);
    nx = roundCount(static_cast<double>(params.points) / ny);
  } else {
    nx = roundCount(length / spacing + 1.0);
    ny = roundCount(static_cast<double>(params.points) / nx);
  }
  const std::vector<double> x = makeTicks(x_start, x_start + length, nx), y = makeTicks(-0.5 * width, 0.5 * width, ny);
  Points points;
  for (const Vec2& p : makeGrid(
           x, y, [](Index, Index) { return true; }, jitter))
    points.emplace_back(p.x(), p.y(), 0.0);
  return points;
}

Points makeSine(const simulation::CloudParams& params, Jitter& jitter) {
  Points points = makeSheet(params, -0.5 * params.size.x(), jitter);
  for (Vec3& p : points) p.z() = params.amplitude * std::cos(2.0 * kPi * p.x() / params.wavelength);
  return points;
}

Points makeTwoBars(const simulation::CloudParams& params, Jitter& jitter) {
  const double length = params.size.x(), height = params.size.y(), gap = params.gap;
  // The bars, and the rows of the joint that fill the gap: at least one, or else nothing would tell the joint from the slit.
  const auto countGapRows = [&](double h) { return std::max(1.0, gap / h - 1.0); };
  const double spacing = findSpacing(params.points, 1e-6 * std::min(length, height), length + height, [&](double h) {
    return 2.0 * (length / h + 1.0) * (height / h + 1.0) + countGapRows(h) * (std::min(height, length) / h + 1.0);
  });
  const Index nx = std::max(Index{3}, static_cast<Index>(std::lround(length / spacing)) + 1);
  const Index nz = std::max(Index{2}, static_cast<Index>(std::lround(height / spacing)) + 1);
  const Index gap_rows = static_cast<Index>(std::lround(countGapRows(spacing)));
  // Columns of the joint; the last columns stay apart.
  const Index joined = std::min(nx - 2, static_cast<Index>(std::lround(height / spacing)) + 1);

  const std::vector<double> x = makeTicks(0.0, length, nx);
  std::vector<double> z = makeTicks(-0.5 * gap - height, -0.5 * gap, nz);
  for (Index r = 1; r <= gap_rows; ++r) z.push_back(-0.5 * gap + gap * r / (gap_rows + 1));
  for (const double tick : makeTicks(0.5 * gap, 0.5 * gap + height, nz)) z.push_back(tick);
  const auto exists = [&](Index i, Index j) { return j < nz || j >= nz + gap_rows || i < joined; };

  Points points;
  for (const Vec2& p : makeGrid(x, z, exists, jitter)) points.emplace_back(p.x(), 0.0, p.y());
  return points;
}

/// Rows along x, every second one shifted by half a spacing and shorter by a point: all first neighbours are equally far, so that
/// size[0] is kept and size[1] rounded to whole rows.
Points makeLattice(const simulation::CloudParams& params, Jitter& jitter) {
  const double length = params.size.x(), width = params.size.y(), row_share = 0.5 * std::sqrt(3.0);
  const double spacing = findSpacing(params.points, 1e-6 * std::min(length, width), length + width,
                                     [&](double h) { return (length / h + 0.5) * (width / (row_share * h) + 1.0); });
  const Index nx = std::max(Index{2}, static_cast<Index>(std::lround(length / spacing)) + 1);
  const double step = length / (nx - 1), row_step = row_share * step;
  const Index ny = std::max(Index{2}, static_cast<Index>(std::lround(width / row_step)) + 1);
  Points points;
  for (Index j = 0; j < ny; ++j) {
    const bool is_short = j % 2 == 1, is_end = j == 0 || j == ny - 1;
    for (Index i = 0; i < nx - is_short; ++i) {
      const bool is_side = !is_short && (i == 0 || i == nx - 1);
      const double dx = jitter.draw(step), dy = jitter.draw(step);
      points.emplace_back(-0.5 * length + step * (i + 0.5 * is_short) + (is_side ? 0.0 : dx),
                          row_step * (j - 0.5 * (ny - 1)) + (is_end ? 0.0 : dy), 0.0);
    }
  }
  return points;
}

/// Filled, with as equal spacings as whole numbers of points allow; points on a face move within it, on an edge along it.
Points makeBar(const simulation::CloudParams& params, Jitter& jitter) {
  const Vec3 size(params.size.x(), params.size.y(), params.height);
  const auto countAt = [&](double h) { return Vec3(size / h + Vec3::Ones()); };
  const double spacing =
      findSpacing(params.points, 1e-6 * size.minCoeff(), size.sum(), [&](double h) { return countAt(h).prod(); });
  std::vector<double> ticks[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Index count = std::max(Index{2}, static_cast<Index>(std::lround(countAt(spacing)[axis])));
    const double from = axis == 0 ? 0.0 : -0.5 * size[axis];
    ticks[axis] = makeTicks(from, from + size[axis], count);
  }
  Points points;
  for (const double x : ticks[0])
    for (const double y : ticks[1])
      for (const double z : ticks[2]) {
        Vec3 p(x, y, z);
        for (int axis = 0; axis < 3; ++axis) {
          const double shift = jitter.draw(ticks[axis][1] - ticks[axis][0]);
          const bool is_end = p[axis] == ticks[axis].front() || p[axis] == ticks[axis].back();
          if (!is_end) p[axis] += shift;
        }
        points.push_back(p);
      }
  return points;
}

Points makeChain(const simulation::CloudParams& params, Jitter& jitter) {
  const double length = params.size.x();
  Points points;
  for (const double x : makeTicks(-0.5 * length, 0.5 * length, params.points)) {
    const bool is_end = std::abs(x) == 0.5 * length;
    const double dx = jitter.draw(length / (params.points - 1));
    points.emplace_back(x + (is_end ? 0.0 : dx), 0.0, 0.0);
  }
  return points;
}

/// The unit vector (r cos(angle), r sin(angle), z), moved along its parallel and along its meridian.
Vec3 makeDirection(double z, double angle, double east, double north) {
  const double r = std::sqrt(1.0 - z * z), c = std::cos(angle), s = std::sin(angle);
  const Vec3 moved = Vec3(r * c, r * s, z) + east * Vec3(-s, c, 0.0) + north * Vec3(-z * c, -z * s, r);
  return moved.normalized();
}

/// Evenly over the part of the unit sphere between two heights.
Points makeSpiral(Index n, double low, double high, Jitter& jitter) {
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  const double spacing = std::sqrt(2.0 * kPi * (high - low) / n);  // the side of the square that is one point's share
  Points points;
  points.reserve(n);
  for (Index i = 0; i < n; ++i) {
    const double z = high - (high - low) * (2.0 * i + 1.0) / (2.0 * n);
    const double east = jitter.draw(spacing), north = jitter.draw(spacing);
    points.push_back(makeDirection(z, golden_angle * i, east, north));
  }
  return points;
}

Points makeSphere(const simulation::CloudParams& params, Jitter& jitter) {
  Points points = makeSpiral(params.points, -1.0, 1.0, jitter);
  for (Vec3& p : points) p *= params.radius;
  return points;
}

Points makeCap(const simulation::CloudParams& params, Jitter& jitter) {
  // Of the area, a strip of half a spacing is the share of the rim; the rest ends where the innermost points are a spacing away.
  const double rim_height = -std::cos(params.angle), rim_length = 2.0 * kPi * std::sin(params.angle);
  const double spacing = findSpacing(params.points, 1e-9, 2.0 * kPi,
                                     [&](double h) { return 2.0 * kPi * (1.0 + rim_height) / (h * h) + 0.5 * rim_length / h; });
  const Index rim = std::max(Index{3}, static_cast<Index>(std::lround(rim_length / spacing)));
  const double inner_angle = std::max(0.5 * params.angle, params.angle - 0.5 * spacing);
  Points points = makeSpiral(std::max(Index{1}, params.points - rim), -1.0, -std::cos(inner_angle), jitter);
  for (Index i = 0; i < rim; ++i) {
    // Along the rim only: the height does not change.
    const double shift = jitter.draw(spacing) / std::sin(params.angle);
    points.push_back(makeDirection(rim_height, 2.0 * kPi * i / rim + shift, 0.0, 0.0));
  }
  for (Vec3& p : points) p *= params.radius;
  return points;
}

}  // namespace

cloud::PointCloud makeShape(const simulation::CloudParams& params) {
  using Shape = simulation::CloudParams::Shape;
  Jitter jitter(params.seed, params.jitter);
  cloud::PointCloud cloud;
  switch (params.shape) {
    case Shape::kNone:
      throw InputError("cloud.shape: found none; accepted: sheet, strip, lattice, chain, sine, sphere, cap, two_bars, bar");
    case Shape::kSheet: cloud.positions = makeSheet(params, -0.5 * params.size.x(), jitter); break;
    case Shape::kStrip: cloud.positions = makeSheet(params, 0.0, jitter); break;
    case Shape::kLattice: cloud.positions = makeLattice(params, jitter); break;
    case Shape::kChain: cloud.positions = makeChain(params, jitter); break;
    case Shape::kSine: cloud.positions = makeSine(params, jitter); break;
    case Shape::kCap: cloud.positions = makeCap(params, jitter); break;
    case Shape::kSphere: cloud.positions = makeSphere(params, jitter); break;
    case Shape::kBar: cloud.positions = makeBar(params, jitter); break;
    case Shape::kTwoBars: cloud.positions = makeTwoBars(params, jitter); break;
  }
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

}  // namespace deformable_surface::io
