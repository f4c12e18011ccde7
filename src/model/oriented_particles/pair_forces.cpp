#include "deformable_surface/model/oriented_particles/pair_forces.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

DEFORMABLE_SURFACE_INLINE void takeRoots(double& x) { x = std::sqrt(x); }
using deformable_surface::takeRoots;

// e^x and e^y for x, y <= 0, to some units in the last place: four of each at once, and, unlike the library's, with the same bits on every
// processor; both together, since they share their constants. x = k log 2 + rest; the polynomial of the rest, which goes through e^rest at
// Chebyshev's points, is off by less than rounding, and k goes to the exponent's bits. Smaller than any that counts: kLeast.
DEFORMABLE_SURFACE_INLINE void exponentiate(Double4& x, Double4& y) {
  using Bits = long long __attribute__((vector_size(4 * sizeof(long long))));
  constexpr double kLeast = -700.0, kRounder = 6755399441055744.0;  // 1.5 * 2^52: a sum with it ends in the nearest whole number
  constexpr double kLog2High = 0x1.62e42fee00000p-1, kLog2Low = 0x1.a39ef35793c76p-33;  // k times the first is exact
  constexpr double kEven[] = {0x1.28a2c1a026d69p-22, 0x1.a019a6698693fp-16, 0x1.6c16c17f43f0fp-10,
                              0x1.55555555520aep-5,  0x1.0000000000005p-1,  1.0};
  constexpr double kOdd[] = {0x1.72faf19a64b4ep-19, 0x1.a01978c553e71p-13, 0x1.1111112dd6ed8p-7, 0x1.555555554b753p-3,
                             0x1.000000000001ep+0};
  const Double4 least = x - x + kLeast;
  x = x > least ? x : least;
  y = y > least ? y : least;
  const Double4 x_shifted = x * 1.4426950408889634 + kRounder, y_shifted = y * 1.4426950408889634 + kRounder;
  const Double4 x_k = x_shifted - kRounder, y_k = y_shifted - kRounder;
  x = (x - x_k * kLog2High) - x_k * kLog2Low;
  y = (y - y_k * kLog2High) - y_k * kLog2Low;
  const Double4 x_square = x * x, y_square = y * y, zero = x - x;
  Double4 x_even = zero + kEven[0], y_even = x_even, x_odd = zero + kOdd[0], y_odd = x_odd;  // short chains instead of long ones
  for (int c = 1; c < 6; ++c) {
    x_even = x_even * x_square + kEven[c];
    y_even = y_even * y_square + kEven[c];
    if (c == 5) break;
    x_odd = x_odd * x_square + kOdd[c];
    y_odd = y_odd * y_square + kOdd[c];
  }
  const Double4 x_sum = x_even + x * x_odd, y_sum = y_even + y * y_odd;
  x = (Double4)((Bits)x_sum + ((Bits)x_shifted << 52));
  y = (Double4)((Bits)y_sum + ((Bits)y_shifted << 52));
}

DEFORMABLE_SURFACE_INLINE void exponentiate(double& x, double& y) {
  Double4 four_x{x, x, x, x}, four_y{y, y, y, y};
  exponentiate(four_x, four_y);
  x = four_x[0];
  y = four_y[0];
}

// A pair seen from particle i, in the letters of the header. r and the normals are given, the rest follows.
template <class T>
struct Pair {
  T r[3], ni[3], nj[3];
  T strength, smooth_strength;  // what multiplies phi, and psi
  T ki[6], kj[6];               // of those bent at rest: xx, yy, zz, yz, xz, xy
  // Of which forces and energy are made:
  T q[3];                       // n_i - n_j, less what it is at rest
  T force[3], torque[3];        // N, N m: what rest curvatures add
  T level, c_r, c_i, c_j, twist;  // J; N/m; N; N; N m: 2 aN (psi_i + psi_j)
};

template <class T>
DEFORMABLE_SURFACE_INLINE void dot(const T* a, const T* b, T& product) {
  product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// K v of a symmetric matrix, stored as in Pair.
template <class T>
DEFORMABLE_SURFACE_INLINE void multiply(const T* k, const T* v, T* product) {
  product[0] = k[0] * v[0] + k[5] * v[1] + k[4] * v[2];
  product[1] = k[5] * v[0] + k[1] * v[1] + k[3] * v[2];
  product[2] = k[4] * v[0] + k[3] * v[1] + k[2] * v[2];
}

template <class T>
DEFORMABLE_SURFACE_INLINE void cross(const T* a, const T* b, T* product) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

// Terms whose weight is zero are left out.
template <bool kAnisotropic, bool kPlanarity, bool kNormality, bool kCircularity, bool kBent, class T>
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
    for (int a = 0; a < 3; ++a) pair.q[a] = pair.ni[a] - pair.nj[a];
  }
  const T s = ui + uj;
  T bend_i[3], bend_j[3];  // K r
  if (kBent) {
    multiply(pair.ki, pair.r, bend_i);
    multiply(pair.kj, pair.r, bend_j);
    T height_i, height_j;
    dot(pair.r, bend_i, height_i);
    dot(pair.r, bend_j, height_j);
    ui += 0.5 * height_i;
    uj -= 0.5 * height_j;
    for (int a = 0; a < 3; ++a) pair.q[a] += 0.5 * (bend_i[a] + bend_j[a]);
  }
  if (kNormality) {
    dot(pair.q, pair.q, shared);
    shared *= p.co_normality;
  }
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
    exponentiate(gi, gj);
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
  if (kBent) {
    const T half_twist = 0.5 * pair.twist;
    const T planar_i = 2.0 * p.co_planarity * ui * psi_i, planar_j = 2.0 * p.co_planarity * uj * psi_j;
    T turned_i[3], turned_j[3], r_bend[3], q_bend[3], r_turned[3];
    multiply(pair.ki, pair.q, turned_i);
    multiply(pair.kj, pair.q, turned_j);
    cross(pair.r, bend_i, r_bend);
    cross(pair.q, bend_i, q_bend);
    cross(pair.r, turned_i, r_turned);
    for (int a = 0; a < 3; ++a) {
      pair.force[a] = planar_i * bend_i[a] - planar_j * bend_j[a] + half_twist * (turned_i[a] + turned_j[a]);
      pair.torque[a] = planar_i * r_bend[a] + half_twist * (q_bend[a] + r_turned[a]);
    }
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

template <int kStride = 4>
DEFORMABLE_SURFACE_INLINE void loadRows(const double* rows, const Index* near, Double4& a, Double4& b, Double4& c, Double4& d) {
  load(rows + kStride * static_cast<std::ptrdiff_t>(near[0]), a);
  load(rows + kStride * static_cast<std::ptrdiff_t>(near[1]), b);
  load(rows + kStride * static_cast<std::ptrdiff_t>(near[2]), c);
  load(rows + kStride * static_cast<std::ptrdiff_t>(near[3]), d);
  transpose(a, b, c, d);
}

template <bool kAnisotropic, bool kPlanarity, bool kNormality, bool kCircularity, bool kBent = false>
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
    for (int a = 0; kBent && a < 6; ++a) pair.ki[a] = zero + particles.curvature(i)[a];
    Double4 more_moment[3] = {zero, zero, zero};
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
      if (kBent) {
        Double4 zeros, more_zeros;  // each its own: rows become columns in place
        loadRows<8>(particles.curvatures.data(), near + k, pair.kj[0], pair.kj[1], pair.kj[2], pair.kj[3]);
        loadRows<8>(particles.curvatures.data() + 4, near + k, pair.kj[4], pair.kj[5], zeros, more_zeros);
      }
      evaluatePair<kAnisotropic, kPlanarity, kNormality, kCircularity, kBent>(p, pair);
      for (int a = 0; a < 3; ++a) {
        force[a] += pair.c_r * pair.r[a];
        if (kBends) {
          force[a] += pair.c_j * pair.nj[a];
          moment[a] += pair.c_i * pair.r[a];
          if (kNormality) moment[a] += pair.twist * pair.q[a];
        }
        if (kBent) {
          force[a] += pair.force[a];
          more_moment[a] += pair.torque[a];
        }
      }
      along_normal += pair.c_i;
    }
    forces[i] += Vec3(addLanes(force[0]), addLanes(force[1]), addLanes(force[2]));
    if (!kBends) continue;
    const Vec3 n(normal[0], normal[1], normal[2]);
    forces[i] += addLanes(along_normal) * n;
    torques[i] += Vec3(addLanes(moment[0]), addLanes(moment[1]), addLanes(moment[2])).cross(n);
    if (kBent) torques[i] += Vec3(addLanes(more_moment[0]), addLanes(more_moment[1]), addLanes(more_moment[2]));
  }
}

}  // namespace

DEFORMABLE_SURFACE_WIDE
void gatherForces(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles, Index begin, Index end,
                  Vec3* forces, Vec3* torques) {
  const int terms = (p.co_planarity > 0.0 ? 1 : 0) + (p.co_normality > 0.0 ? 2 : 0) + (p.co_circularity > 0.0 ? 4 : 0);
  const auto& f = particles;
  if (!f.curvatures.empty()) return gather<false, true, true, true, true>(p, lists, f, begin, end, forces, torques);
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
      if (!particles.curvatures.empty()) {
        std::copy_n(particles.curvature(i), 6, pair.ki);
        std::copy_n(particles.curvature(*j), 6, pair.kj);
        evaluatePair<false, true, true, true, true>(p, pair);
      } else if (p.is_anisotropic) {
        evaluatePair<true, true, true, true, false>(p, pair);
      } else {
        evaluatePair<false, true, true, true, false>(p, pair);
      }
      sum += 0.5 * pair.level;
    }
  }
  return sum;
}

constexpr double kSwitchBend = 60.0 / (6.0 * 1.7320508);  // the largest second derivative of the switch, times its width squared

// The largest eigenvalue's bound: of a symmetric matrix, the root of the sum of squares.
double findLargest(const double* k) {
  return std::sqrt(k[0] * k[0] + k[1] * k[1] + k[2] * k[2] + 2.0 * (k[3] * k[3] + k[4] * k[4] + k[5] * k[5]));
}

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

  // What rest curvatures add, at most: to u, to n_i - n_j, and, as a factor, to their derivatives.
  double bent = 0.0;
  if (!particles.curvatures.empty())
    bent = std::max(findLargest(particles.curvature(i)), findLargest(particles.curvature(j)));
  const double height = 0.5 * bent * squared, steeper = 1.0 + bent * d;
  const double ui = std::abs(normal_i.head<3>().dot(r)) + height, uj = std::abs(normal_j.head<3>().dot(r)) + height, s = ui + uj;
  const double normals = (normal_i - normal_j).head<3>().norm() + bent * d;
  // psi, the sizes of its slope and of its second derivatives by position, and of those by turning the normal.
  double psi, psi_slope, psi_bend, turned = 0.0, turned_twice = 0.0, turned_moved = 0.0;
  if (p.is_anisotropic) {
    const double lower = std::min(ui, uj), steep = d * p.inverse_height, width = p.cutoff - p.switch_begin;
    psi = -0.5 * (squared * p.inverse_width + (p.inverse_height - p.inverse_width) * lower * lower);
    double same = psi;
    exponentiate(psi, same);
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
  const double planarity = p.co_planarity * steeper * steeper, normality = p.co_normality * steeper * steeper;
  const double circularity = p.co_circularity;
  const double stored = planarity * (ui * ui + uj * uj) + 2.0 * (normality * normals * normals + circularity * s * s);
  // |dB/dr| and |dB/dn|.
  const double by_place = (2.0 * planarity + 8.0 * circularity) * s;
  const double by_normal = 2.0 * planarity * std::max(ui, uj) * d + 4.0 * normality * normals + 4.0 * circularity * s * d;
  k.x += smooth * (psi * (4.0 * planarity + 16.0 * circularity) + 2.0 * psi_slope * by_place + psi_bend * stored);
  k.y = smooth * (psi * (2.0 * planarity * (d + s) + circularity * (8.0 * d + 4.0 * s)) + psi_slope * by_normal +
                  turned * by_place + turned_moved * stored);
  if (bent > 0.0) {
    // n_i - n_j now changes with places, and u with their squares.
    const double by_both = 4.0 * normality * bent, moved = by_both * normals;
    k.x += smooth * (psi * (by_both * bent + 2.0 * planarity * s * bent) + 2.0 * psi_slope * moved);
    k.y += smooth * (psi * (by_both + moved + 2.0 * planarity * s * bent * d) + psi_slope * moved * d);
  }
  k.z = smooth * (psi * (2.0 * planarity * squared + 8.0 * normality + 8.0 * circularity * squared + by_normal) +
                  2.0 * turned * by_normal + turned_twice * stored);
  return k;
}

}  // namespace deformable_surface::model
