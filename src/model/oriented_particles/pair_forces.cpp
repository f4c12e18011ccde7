#include "deformable_surface/model/oriented_particles/pair_forces.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

DEFORMABLE_SURFACE_INLINE void takeRoots(double& x) { x = std::sqrt(x); }
using deformable_surface::takeRoots;

// e^x for x <= 0, to some units in the last place: four at once, and, unlike the library's, with the same bits on every processor.
// x = k log 2 + rest; the series of the rest ends below rounding, and k goes to the exponent's bits. Smaller than any that counts:
// kLeast.
DEFORMABLE_SURFACE_INLINE void exponentiate(Double4& x) {
  using Bits = long long __attribute__((vector_size(4 * sizeof(long long))));
  constexpr double kLeast = -700.0, kRounder = 6755399441055744.0;  // 1.5 * 2^52: a sum with it ends in the nearest whole number
  constexpr double kLog2High = 0x1.62e42fee00000p-1, kLog2Low = 0x1.a39ef35793c76p-33;  // k times the first is exact
  constexpr double kEven[] = {1.0 / 479001600.0, 1.0 / 3628800.0, 1.0 / 40320.0, 1.0 / 720.0, 1.0 / 24.0, 0.5, 1.0};
  constexpr double kOdd[] = {1.0 / 6227020800.0, 1.0 / 39916800.0, 1.0 / 362880.0, 1.0 / 5040.0, 1.0 / 120.0, 1.0 / 6.0, 1.0};
  const Double4 least = x - x + kLeast;
  x = x > least ? x : least;
  const Double4 shifted = x * 1.4426950408889634 + kRounder, k = shifted - kRounder;
  const Double4 rest = (x - k * kLog2High) - k * kLog2Low;
  const Double4 square = rest * rest;
  Double4 even = x - x, odd = even;  // two short chains instead of a long one
  for (int c = 0; c < 7; ++c) {
    even = even * square + kEven[c];
    odd = odd * square + kOdd[c];
  }
  const Double4 sum = even + rest * odd;
  x = (Double4)((Bits)sum + ((Bits)shifted << 52));
}

DEFORMABLE_SURFACE_INLINE void exponentiate(double& x) {
  Double4 four{x, x, x, x};
  exponentiate(four);
  x = four[0];
}

// A pair seen from particle i, in the letters of the header. r and the normals are given, the rest follows.
template <class T>
struct Pair {
  T r[3], ni[3], nj[3];
  T strength, smooth_strength;  // what multiplies phi, and psi
  // Of which forces and energy are made:
  T level, c_r, c_i, c_j, twist;  // J; N/m; N; N; N m: 2 aN (psi_i + psi_j)
};

template <class T>
DEFORMABLE_SURFACE_INLINE void dot(const T* a, const T* b, T& product) {
  product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Terms whose weight is zero are left out.
template <bool kAnisotropic, bool kPlanarity, bool kNormality, bool kCircularity, class T>
DEFORMABLE_SURFACE_INLINE void evaluatePair(const PairPotentials& p, Pair<T>& pair) {
  T squared, d;
  dot(pair.r, pair.r, squared);
  d = squared;
  takeRoots(d);
  const T zero = d - d, one = zero + 1.0;
  const T inverse = (d > zero ? one : zero) / (d > zero ? d : one);  // of two in one place neither pushes the other
  T on, on_slope, phi, slope;
  switchOff(p, d, on, on_slope);
  evaluateLennardJones(p, d, inverse, on, on_slope, phi, slope);
  // What holds the pair together melts; that they keep apart does not.
  const T outside = d > p.distance + zero ? one : zero, held = outside * phi - (one - outside) * p.depth;
  pair.level = 2.0 * (phi - held + pair.strength * held);
  pair.c_r = 2.0 * (one - outside + outside * pair.strength) * slope * inverse;
  pair.c_i = pair.c_j = pair.twist = zero;
  if (!kPlanarity && !kNormality && !kCircularity) return;

  T ui, uj;
  dot(pair.ni, pair.r, ui);
  dot(pair.nj, pair.r, uj);
  T shared = zero;  // aN Q + aC s^2
  if (kNormality) {
    const T n[3] = {pair.ni[0] - pair.nj[0], pair.ni[1] - pair.nj[1], pair.ni[2] - pair.nj[2]};
    dot(n, n, shared);
    shared *= p.co_normality;
  }
  const T s = ui + uj;
  if (kCircularity) shared += p.co_circularity * s * s;
  T bi = shared, bj = shared;
  if (kPlanarity) {
    bi += p.co_planarity * ui * ui;
    bj += p.co_planarity * uj * uj;
  }
  T psi_i, psi_j;
  if (kAnisotropic) {
    const double tilt = p.inverse_width - p.inverse_height;  // psi falls along u by u times it
    T gi = -0.5 * (p.inverse_width * squared - tilt * ui * ui), gj = -0.5 * (p.inverse_width * squared - tilt * uj * uj);
    exponentiate(gi);
    exponentiate(gj);
    gi *= pair.smooth_strength;
    gj *= pair.smooth_strength;
    psi_i = on * gi;
    psi_j = on * gj;
    pair.c_i = tilt * bi * psi_i * ui;
    pair.c_j = tilt * bj * psi_j * uj;
    pair.c_r += (bi * gi + bj * gj) * (on_slope * inverse) - p.inverse_width * (bi * psi_i + bj * psi_j);
  } else {
    T psi_slope;
    weighByDistance(p, squared, psi_i, psi_slope);
    psi_i = psi_j = pair.smooth_strength * psi_i;
    pair.c_r += pair.smooth_strength * psi_slope * (bi + bj);
  }
  pair.level += bi * psi_i + bj * psi_j;
  const T both = psi_i + psi_j;
  if (kNormality) pair.twist = 2.0 * p.co_normality * both;
  if (kPlanarity) {
    pair.c_i += 2.0 * p.co_planarity * ui * psi_i;
    pair.c_j += 2.0 * p.co_planarity * uj * psi_j;
  }
  if (kCircularity) {
    const T along = 2.0 * p.co_circularity * s * both;
    pair.c_i += along;
    pair.c_j += along;
  }
}

DEFORMABLE_SURFACE_INLINE double addLanes(const Double4& x) { return (x[0] + x[1]) + (x[2] + x[3]); }

// Those of the listed others that are within the cutoff, in their order.
DEFORMABLE_SURFACE_INLINE Index selectNear(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles,
                                           Index i, Index* near) {
  const double x = particles.place(i)[0], y = particles.place(i)[1], z = particles.place(i)[2], most = p.cutoff * p.cutoff;
  Index count = 0;
  for (const Index *j = lists.begin(i), *end = lists.end(i); j != end; ++j) {
    const double* q = particles.place(*j);
    const double dx = q[0] - x, dy = q[1] - y, dz = q[2] - z;
    near[count] = *j;
    count += dx * dx + dy * dy + dz * dz < most;
  }
  return count;
}

// Which lanes are in use, by their number.
constexpr double kLanes[5][4] = {{0, 0, 0, 0}, {1, 0, 0, 0}, {1, 1, 0, 0}, {1, 1, 1, 0}, {1, 1, 1, 1}};

DEFORMABLE_SURFACE_INLINE void loadRows(const double* rows, const Index* near, Double4& a, Double4& b, Double4& c, Double4& d) {
  load(rows + 4 * static_cast<std::ptrdiff_t>(near[0]), a);
  load(rows + 4 * static_cast<std::ptrdiff_t>(near[1]), b);
  load(rows + 4 * static_cast<std::ptrdiff_t>(near[2]), c);
  load(rows + 4 * static_cast<std::ptrdiff_t>(near[3]), d);
  transpose(a, b, c, d);
}

template <bool kAnisotropic, bool kPlanarity, bool kNormality, bool kCircularity>
DEFORMABLE_SURFACE_INLINE void gather(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles,
                                      Index begin, Index end, Vec3* forces, Vec3* torques) {
  constexpr bool kBends = kPlanarity || kNormality || kCircularity;
  const double *const places = particles.places.data(), *const normals = particles.normals.data();
  const Double4 zero{0.0, 0.0, 0.0, 0.0};
  Index near[NeighborList::kMostNeighbors + 4];
  for (Index i = begin; i < end; ++i) {
    const Index count = selectNear(p, lists, particles, i, near);
    for (Index k = count; k < count + 3; ++k) near[k] = i;
    const double *const place = particles.place(i), *const normal = particles.normal(i);
    Pair<Double4> pair;
    for (int a = 0; a < 3; ++a) pair.ni[a] = zero + normal[a];
    Double4 force[3] = {zero, zero, zero}, moment[3] = {zero, zero, zero}, along_normal = zero;
    for (Index k = 0; k < count; k += 4) {
      Double4 strength, lanes;
      loadRows(places, near + k, pair.r[0], pair.r[1], pair.r[2], strength);
      for (int a = 0; a < 3; ++a) pair.r[a] -= place[a];
      load(kLanes[std::min(Index{4}, count - k)], lanes);
      const Double4 own = zero + place[3];
      pair.strength = lanes * (strength < own ? strength : own);
      if (kBends) {
        Double4 smooth;
        loadRows(normals, near + k, pair.nj[0], pair.nj[1], pair.nj[2], smooth);
        pair.smooth_strength = pair.strength * smooth * normal[3];
      }
      evaluatePair<kAnisotropic, kPlanarity, kNormality, kCircularity>(p, pair);
      for (int a = 0; a < 3; ++a) {
        force[a] += pair.c_r * pair.r[a];
        if (kBends) {
          force[a] += pair.c_j * pair.nj[a];
          moment[a] += pair.c_i * pair.r[a] + pair.twist * (pair.ni[a] - pair.nj[a]);
        }
      }
      along_normal += pair.c_i;
    }
    forces[i] += Vec3(addLanes(force[0]), addLanes(force[1]), addLanes(force[2]));
    if (!kBends) continue;
    const Vec3 n(normal[0], normal[1], normal[2]);
    forces[i] += addLanes(along_normal) * n;
    torques[i] += Vec3(addLanes(moment[0]), addLanes(moment[1]), addLanes(moment[2])).cross(n);
  }
}

}  // namespace

DEFORMABLE_SURFACE_WIDE
void gatherForces(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles, Index begin, Index end,
                  Vec3* forces, Vec3* torques) {
  const int terms = (p.co_planarity > 0.0 ? 1 : 0) + (p.co_normality > 0.0 ? 2 : 0) + (p.co_circularity > 0.0 ? 4 : 0);
  const auto& f = particles;
  switch (terms == 0 || !p.is_anisotropic ? terms : terms + 8) {
    case 0: return gather<false, false, false, false>(p, lists, f, begin, end, forces, torques);
    case 1: return gather<false, true, false, false>(p, lists, f, begin, end, forces, torques);
    case 2: return gather<false, false, true, false>(p, lists, f, begin, end, forces, torques);
    case 3: return gather<false, true, true, false>(p, lists, f, begin, end, forces, torques);
    case 4: return gather<false, false, false, true>(p, lists, f, begin, end, forces, torques);
    case 5: return gather<false, true, false, true>(p, lists, f, begin, end, forces, torques);
    case 6: return gather<false, false, true, true>(p, lists, f, begin, end, forces, torques);
    case 7: return gather<false, true, true, true>(p, lists, f, begin, end, forces, torques);
    case 9: return gather<true, true, false, false>(p, lists, f, begin, end, forces, torques);
    case 10: return gather<true, false, true, false>(p, lists, f, begin, end, forces, torques);
    case 11: return gather<true, true, true, false>(p, lists, f, begin, end, forces, torques);
    case 12: return gather<true, false, false, true>(p, lists, f, begin, end, forces, torques);
    case 13: return gather<true, true, false, true>(p, lists, f, begin, end, forces, torques);
    case 14: return gather<true, false, true, true>(p, lists, f, begin, end, forces, torques);
    default: return gather<true, true, true, true>(p, lists, f, begin, end, forces, torques);
  }
}

double gatherEnergy(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles, Index begin,
                    Index end) {
  double sum = 0.0;
  for (Index i = begin; i < end; ++i) {
    const double *place = particles.place(i), *normal = particles.normal(i);
    for (const Index* j = lists.begin(i); j != lists.end(i); ++j) {
      const double *q = particles.place(*j), *m = particles.normal(*j);
      Pair<double> pair;
      double squared = 0.0;
      for (int a = 0; a < 3; ++a) {
        pair.r[a] = q[a] - place[a];
        pair.ni[a] = normal[a];
        pair.nj[a] = m[a];
        squared += pair.r[a] * pair.r[a];
      }
      if (!(squared < p.cutoff * p.cutoff)) continue;
      pair.strength = std::min(place[3], q[3]);
      pair.smooth_strength = pair.strength * normal[3] * m[3];
      if (p.is_anisotropic) {
        evaluatePair<true, true, true, true>(p, pair);
      } else {
        evaluatePair<false, true, true, true>(p, pair);
      }
      sum += 0.5 * pair.level;
    }
  }
  return sum;
}

constexpr double kSwitchBend = 60.0 / (6.0 * 1.7320508);  // the largest second derivative of the switch, times its width squared

// Of E = psi B with B a sum of squares: psi times that of the squares of their gradients, and, where the surface is bent, what
// else the product rule leaves. Norms of vectors stand for all their components.
PairStiffness boundStiffness(const PairPotentials& p, const PackedParticles& particles, Index i, Index j) {
  const Eigen::Map<const Vec4> place_i(particles.place(i)), place_j(particles.place(j));
  const Eigen::Map<const Vec4> normal_i(particles.normal(i)), normal_j(particles.normal(j));
  const Vec3 r = place_j.head<3>() - place_i.head<3>();
  const double squared = r.squaredNorm(), d = std::sqrt(squared);
  PairStiffness k;
  if (!(d < p.cutoff)) return k;
  const double strength = std::min(place_i[3], place_j[3]);
  double on, on_slope, phi, slope;
  switchOff(p, d, on, on_slope);
  evaluateLennardJones(p, d, 1.0 / d, on, on_slope, phi, slope);
  k.x = 2.0 * (d > p.distance ? strength : 1.0) * std::max({0.0, findLennardJonesCurvature(p, d), slope / std::max(d, p.core)});
  const double smooth = strength * normal_i[3] * normal_j[3];
  if (!p.bends() || !(smooth > 0.0)) return k;

  const double ui = std::abs(normal_i.head<3>().dot(r)), uj = std::abs(normal_j.head<3>().dot(r)), s = ui + uj;
  const double normals = (normal_i - normal_j).head<3>().norm();
  // psi, the sizes of its slope and of its second derivatives by position, and of those by turning the normal.
  double psi, psi_slope, psi_bend, turned = 0.0, turned_twice = 0.0, turned_moved = 0.0;
  if (p.is_anisotropic) {
    const double lower = std::min(ui, uj), steep = d * p.inverse_height, width = p.cutoff - p.switch_begin;
    psi = -0.5 * (squared * p.inverse_width + (p.inverse_height - p.inverse_width) * lower * lower);
    exponentiate(psi);
    psi *= on;
    psi_slope = psi * steep + std::abs(on_slope);
    psi_bend = psi * (steep * steep + p.inverse_height) + 2.0 * std::abs(on_slope) * steep;
    if (on < 1.0) psi_bend += kSwitchBend / (width * width);
    turned = psi * steep * std::max(ui, uj);
    turned_moved = psi * steep + turned * p.inverse_height * std::max(ui, uj);
    turned_twice = turned_moved * d;
  } else {
    const double inverse = 1.0 / (p.cutoff * p.cutoff), q = 1.0 - inverse * squared;
    weighByDistance(p, squared, psi, psi_slope);
    psi_slope *= -d;
    psi_bend = 6.0 * inverse * q * std::max(q, 4.0 * inverse * squared);
  }
  const double planarity = p.co_planarity, normality = p.co_normality, circularity = p.co_circularity;
  const double stored = planarity * (ui * ui + uj * uj) + 2.0 * (normality * normals * normals + circularity * s * s);
  // |dB/dr| and |dB/dn|.
  const double by_place = (2.0 * planarity + 8.0 * circularity) * s;
  const double by_normal = 2.0 * planarity * std::max(ui, uj) * d + 4.0 * normality * normals + 4.0 * circularity * s * d;
  k.x += smooth * (psi * (4.0 * planarity + 16.0 * circularity) + 2.0 * psi_slope * by_place + psi_bend * stored);
  k.y = smooth * (psi * (2.0 * planarity * (d + s) + circularity * (8.0 * d + 4.0 * s)) + psi_slope * by_normal +
                  turned * by_place + turned_moved * stored);
  k.z = smooth * (psi * (2.0 * planarity * squared + 8.0 * normality + 8.0 * circularity * squared + by_normal) +
                  2.0 * turned * by_normal + turned_twice * stored);
  return k;
}

}  // namespace deformable_surface::model
