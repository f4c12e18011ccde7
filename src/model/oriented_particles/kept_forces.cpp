// Forces and energy of kept bonds, four triangles at once.
#include "deformable_surface/base/parallel.h"
#include "kept_triangles.h"

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr Index kFours = kBlock / 4;
constexpr Index kPush = 20;  // numbers that a triangle writes: at each corner six, force and the vector to cross with the normal

DEFORMABLE_SURFACE_WIDE
void pushCorners(const PackedParticles& particles, const PresentBonds::FourTriangles* fours, Index begin, Index end,
                 double* pushes) {
  for (Index k = begin; k < end; ++k) {
    const PresentBonds::FourTriangles& t = fours[k];
    DeformedTriangles d;
    deform(particles, t, d);
    const Double4 zero = d.e[0] - d.e[0];
    Double4 push[kPush];
    for (Double4& p : push) p = zero;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3;
      const Double4 sheared = 0.5 * d.by_s[a], pull = d.by_e[a] * d.inverse[a];
      const Double4 by_first = sheared - d.by_c[a], by_last = sheared + d.by_c[a];
      for (int x = 0; x < 3; ++x) {
        const Double4 by_r = pull * d.r[a][x] + by_first * d.normal[a][x] + by_last * d.normal[b][x];
        push[6 * a + x] += by_r;
        push[6 * b + x] -= by_r;
        push[6 * a + 3 + x] += by_first * d.r[a][x];
        push[6 * b + 3 + x] += by_last * d.r[a][x];
      }
    }
    double* const rows = pushes + 4 * kPush * static_cast<std::ptrdiff_t>(k);
    for (int a = 0; a < kPush; a += 4) {
      transpose(push[a], push[a + 1], push[a + 2], push[a + 3]);
      for (int lane = 0; lane < 4; ++lane) store(push[a + lane], rows + kPush * lane + a);
    }
  }
}

// Sums the pushes of the triangles of each particle of begin .. end - 1 in ascending order.
DEFORMABLE_SURFACE_WIDE
void gatherPushes(const PackedParticles& particles, const Index* begins, const Index* corners, const double* pushes, Index begin,
                  Index end, Vec3* forces, Vec3* torques) {
  const Double4 zero{0.0, 0.0, 0.0, 0.0};
  for (Index i = begin; i < end; ++i) {
    Double4 first = zero, last = zero;
    for (Index k = begins[i]; k < begins[i + 1]; ++k) {
      const double* const push = pushes + kPush * static_cast<std::ptrdiff_t>(corners[k] / 3) + 6 * (corners[k] % 3);
      Double4 four, rest;
      load(push, four);
      load(push + 4, rest);  // two, and two that are not needed
      first += four;
      last += rest;
    }
    forces[i] += Vec3(first[0], first[1], first[2]);
    torques[i] += Vec3(first[3], last[0], last[1]).cross(Eigen::Map<const Vec3>(particles.normal(i)));
  }
}

DEFORMABLE_SURFACE_WIDE
double sumEnergy(const PackedParticles& particles, const PresentBonds::FourTriangles* fours, Index begin, Index end) {
  Double4 sum{0.0, 0.0, 0.0, 0.0};
  for (Index k = begin; k < end; ++k) {
    DeformedTriangles d;
    deform(particles, fours[k], d);
    for (int a = 0; a < 3; ++a) sum += 0.5 * (d.by_e[a] * d.e[a] + d.by_c[a] * d.c[a] + d.by_s[a] * d.s[a]);
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

}  // namespace

void PresentBonds::addForces(const PackedParticles& particles, Points& forces, Points& torques) const {
  parallelFor(static_cast<Index>(fours_.size()), kFours,
              [&](Index begin, Index end) { pushCorners(particles, fours_.data(), begin, end, pushes_.data()); });
  parallelFor(static_cast<Index>(forces.size()), kBlock, [&](Index begin, Index end) {
    gatherPushes(particles, corner_begins_.data(), corners_.data(), pushes_.data(), begin, end, forces.data(), torques.data());
  });
}

double PresentBonds::findEnergy(const PackedParticles& particles) const {
  return parallelSum(static_cast<Index>(fours_.size()), kFours,
                     [&](Index begin, Index end) { return sumEnergy(particles, fours_.data(), begin, end); });
}

}  // namespace deformable_surface::model
