#include "transfer_pass.h"

#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace deformable_surface::transfer {
namespace {

// Least squared area between the tangents now, in units of their squared lengths, that is more than float rounding: below it they
// are parallel or have vanished.
constexpr float kMinSquaredArea = 1e-10f;
// The row length that gets a loop of its own, unrolled.
constexpr Index kUsualNeighbors = 8;

using Float4 = float __attribute__((vector_size(4 * sizeof(float))));
using Float8 = float __attribute__((vector_size(kLanes * sizeof(float))));

DEFORMABLE_SURFACE_INLINE void load(const float* from, Float8& to) { std::memcpy(&to, from, sizeof to); }
DEFORMABLE_SURFACE_INLINE void store(const Float8& from, float* to) { std::memcpy(to, &from, sizeof from); }

// Four numbers from here, four from there.
DEFORMABLE_SURFACE_INLINE void loadTwo(const float* low, const float* high, Float8& to) {
  Float4 a, b;
  std::memcpy(&a, low, sizeof a);
  std::memcpy(&b, high, sizeof b);
#if defined(__clang__) || __GNUC__ >= 12
  to = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  to = Float8{a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]};
#endif
}

// Vectors of eight points.
struct Vec3x8 {
  Float8 x, y, z;
};

DEFORMABLE_SURFACE_INLINE void load3(const float* from, Vec3x8& to) {
  load(from, to.x);
  load(from + kLanes, to.y);
  load(from + 2 * kLanes, to.z);
}

DEFORMABLE_SURFACE_INLINE void store3(const Vec3x8& from, float* to) {
  store(from.x, to);
  store(from.y, to + kLanes);
  store(from.z, to + 2 * kLanes);
}

DEFORMABLE_SURFACE_INLINE void multiply(const Vec3x8& a, const Vec3x8& b, Float8& dot) {
  dot = a.x * b.x + a.y * b.y + a.z * b.z;
}

DEFORMABLE_SURFACE_INLINE void multiplyCross(const Vec3x8& a, const Vec3x8& b, Vec3x8& cross) {
  cross = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

DEFORMABLE_SURFACE_INLINE void addScaled(const Float8& scale, const Vec3x8& v, Vec3x8& sum) {
  sum.x += scale * v.x;
  sum.y += scale * v.y;
  sum.z += scale * v.z;
}

DEFORMABLE_SURFACE_INLINE void takeRoots(Float8& v) {
  float roots[kLanes];
  store(v, roots);
  for (float& root : roots) root = std::sqrt(root);
  load(roots, v);
}

// Vectors x y z 0 in memory, one for each point.
DEFORMABLE_SURFACE_INLINE void gather(const float* vectors, const Index* index, Vec3x8& to) {
  Float8 a, b, c, d, ab, cd;
  const auto at = [&](int lane) { return vectors + 4 * static_cast<std::size_t>(index[lane]); };
  loadTwo(at(0), at(4), a);
  loadTwo(at(1), at(5), b);
  loadTwo(at(2), at(6), c);
  loadTwo(at(3), at(7), d);
  pick<0, 8, 1, 9, 4, 12, 5, 13>(a, b, ab);
  pick<0, 8, 1, 9, 4, 12, 5, 13>(c, d, cd);
  pick<0, 1, 8, 9, 4, 5, 12, 13>(ab, cd, to.x);
  pick<2, 3, 10, 11, 6, 7, 14, 15>(ab, cd, to.y);
  pick<2, 10, 3, 11, 6, 14, 7, 15>(a, b, ab);
  pick<2, 10, 3, 11, 6, 14, 7, 15>(c, d, cd);
  pick<0, 1, 8, 9, 4, 5, 12, 13>(ab, cd, to.z);
}

// Unit normals from the tangents now: at rest and after every rotation, n is along T_x x T_y + s_x T_x + s_y T_y.
DEFORMABLE_SURFACE_INLINE void findNormals(const Vec3x8& tangent_x, const Vec3x8& tangent_y, const float* frame, Vec3x8& normal) {
  Vec3x8 across, rest;
  multiplyCross(tangent_x, tangent_y, across);
  load3(frame + kNormal * kLanes, rest);
  Float8 slope_x, slope_y;
  load(frame + kSlopeX * kLanes, slope_x);
  load(frame + kSlopeY * kLanes, slope_y);
  const Vec3x8 n = {across.x + slope_x * tangent_x.x + slope_y * tangent_y.x,
                    across.y + slope_x * tangent_x.y + slope_y * tangent_y.y,
                    across.z + slope_x * tangent_x.z + slope_y * tangent_y.z};
  // One is about the tangents' squared length at rest, hence their rounding.
  Float8 square_x, square_y, squared_length, squared_area;
  multiply(tangent_x, tangent_x, square_x);
  multiply(tangent_y, tangent_y, square_y);
  multiply(n, n, squared_length);
  multiply(across, across, squared_area);
  const Float8 size = square_x + square_y;
  const auto sound = (squared_area > kMinSquaredArea * size * (size + 1.0f)) & (squared_length > 0.0f);
  Float8 length = squared_length;
  takeRoots(length);
  const Float8 scale = 1.0f / length;
  normal = {sound ? scale * n.x : rest.x, sound ? scale * n.y : rest.y, sound ? scale * n.z : rest.z};
}

DEFORMABLE_SURFACE_INLINE void findRatio(const Vec3x8& tangent_x, const Vec3x8& tangent_y, const Vec3x8& rest_x,
                                         const Vec3x8& rest_y, float* ratio) {
  Vec3x8 now, rest;
  multiplyCross(tangent_x, tangent_y, now);
  multiplyCross(rest_x, rest_y, rest);
  Float8 area, rest_area;
  multiply(now, now, area);
  multiply(rest, rest, rest_area);
  takeRoots(area);
  takeRoots(rest_area);
  store(area / rest_area, ratio);
}

// Adds to the rest positions of as many points.
DEFORMABLE_SURFACE_INLINE void writePositions(Index count, const double* rest, const double* reference, const float* u,
                                              double* positions) {
  const double x = reference[0], y = reference[1], z = reference[2];
#pragma GCC ivdep
  for (Index lane = 0; lane < count; ++lane) {
    positions[3 * lane] = rest[3 * lane] + (x + u[lane]);
    positions[3 * lane + 1] = rest[3 * lane + 1] + (y + u[kLanes + lane]);
    positions[3 * lane + 2] = rest[3 * lane + 2] + (z + u[2 * kLanes + lane]);
  }
}

DEFORMABLE_SURFACE_INLINE void writeNormals(Index count, const float* normal, float* normals) {
#pragma GCC ivdep
  for (Index lane = 0; lane < count; ++lane)
    for (int c = 0; c < 3; ++c) normals[3 * lane + c] = normal[c * kLanes + lane];
}

// K: the row length, 0 if not known to the compiler.
template <int K>
DEFORMABLE_SURFACE_INLINE void run(Index begin, Index end, const PassRows& rows, const PassMotion& motion,
                                   const PassOutput& output) {
  const Index k = K > 0 ? K : rows.k;
  const Index* index = rows.index + static_cast<std::size_t>(begin) * k * kLanes;
  const float* weight = rows.weight + static_cast<std::size_t>(begin) * k * 3 * kLanes;
  const float* frame = rows.frame + static_cast<std::size_t>(begin) * kFrameRows * kLanes;
  for (Index g = begin; g < end; ++g, frame += kFrameRows * kLanes) {
    // Displacement, and the fitted tangents now.
    Vec3x8 rest_x, rest_y, u{};
    load3(frame + kTangentX * kLanes, rest_x);
    load3(frame + kTangentY * kLanes, rest_y);
    Vec3x8 tangent_x = rest_x, tangent_y = rest_y;
    for (Index j = 0; j < k; ++j, index += kLanes, weight += 3 * kLanes) {
      Vec3x8 u_j, w;
      gather(motion.displacements, index, u_j);
      load3(weight, w);
      addScaled(w.x, u_j, u);
      addScaled(w.y, u_j, tangent_x);
      addScaled(w.z, u_j, tangent_y);
    }
    const Index first = g * kLanes, count = std::min(kLanes, rows.n - first);
    if (output.ratio) {
      float ratio[kLanes];
      findRatio(tangent_x, tangent_y, rest_x, rest_y, ratio);
      std::memcpy(output.ratio + first, ratio, count * sizeof(float));
      continue;
    }
    // The height over the fitted plane turns with the normal.
    Vec3x8 normal, rest_normal;
    findNormals(tangent_x, tangent_y, frame, normal);
    load3(frame + kNormal * kLanes, rest_normal);
    Float8 height;
    load(frame + kHeight * kLanes, height);
    addScaled(height, {normal.x - rest_normal.x, normal.y - rest_normal.y, normal.z - rest_normal.z}, u);
    float moved[3 * kLanes], normals[3 * kLanes];
    store3(u, moved);
    store3(normal, normals);
    // Twice, so that the compiler knows the usual count.
    const std::size_t place = 3 * static_cast<std::size_t>(first);
    if (count == kLanes) {
      writePositions(kLanes, rows.rest + place, motion.reference, moved, output.positions + place);
      if (output.normals) writeNormals(kLanes, normals, output.normals + place);
    } else {
      writePositions(count, rows.rest + place, motion.reference, moved, output.positions + place);
      if (output.normals) writeNormals(count, normals, output.normals + place);
    }
  }
}

DEFORMABLE_SURFACE_WIDE void runUsual(Index begin, Index end, const PassRows& rows, const PassMotion& motion,
                                      const PassOutput& output) {
  run<kUsualNeighbors>(begin, end, rows, motion, output);
}

DEFORMABLE_SURFACE_WIDE void runAny(Index begin, Index end, const PassRows& rows, const PassMotion& motion,
                                    const PassOutput& output) {
  run<0>(begin, end, rows, motion, output);
}

}  // namespace

void runGroups(Index begin, Index end, const PassRows& rows, const PassMotion& motion, const PassOutput& output) {
  (rows.k == kUsualNeighbors ? runUsual : runAny)(begin, end, rows, motion, output);
}

DEFORMABLE_SURFACE_WIDE void settleNormals(float* frame) {
  Vec3x8 tangent_x, tangent_y, normal;
  load3(frame + kTangentX * kLanes, tangent_x);
  load3(frame + kTangentY * kLanes, tangent_y);
  findNormals(tangent_x, tangent_y, frame, normal);
  store3(normal, frame + kNormal * kLanes);
}

}  // namespace deformable_surface::transfer
