// Forces between pairs, four at once; bounds of their stiffness are in pair_stiffness.cpp.
#include "deformable_surface/model/oriented_particles/pair_forces.h"

#include "raise_two.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

DEFORMABLE_SURFACE_INLINE void takeRoots(double& x) { x = std::sqrt(x); }
using deformable_surface::takeRoots;

// A pair seen from particle i, in the notation of the header. r and the normals are given, the rest follows.
template <class T>
struct Pair {
  T r[3], ni[3], nj[3];
  T strength, smooth_strength;  // factors of phi and of psi
  T ki[6], kj[6];               // rest curvatures: xx, yy, zz, yz, xz, xy
  // Forces and energy are computed from:
  T q[3];                         // n_i - n_j less its rest value
  T force[3], torque[3];          // N, N m: contributions of rest curvatures
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

// Terms with weight zero are omitted.
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
  // Attraction melts, repulsion does not.
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
    const double wide = -kHalfLog2E * p.inverse_width, tilted = kHalfLog2E * tilt;
    const T near = wide * squared;
    T gi = near + tilted * ui * ui, gj = near + tilted * uj * uj;
    raiseTwo(gi, gj);
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

// Selects the listed particles within the cutoff, in their order. Half of them are not, in no order that branches could foresee.
DEFORMABLE_SURFACE_INLINE Index selectNear(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles,
                                           Index i, Index* near) {
  const double x = particles.place(i)[0], y = particles.place(i)[1], z = particles.place(i)[2], most = p.cutoff * p.cutoff;
  const Double4 limit = Double4{0.0, 0.0, 0.0, 0.0} + most;
  Index count = 0;
  const Index *j = lists.begin(i), *const end = lists.end(i);
  for (; end - j >= 4; j += 4) {
    Double4 dx, dy, dz, strength;
    loadRows(particles.places.data(), j, dx, dy, dz, strength);
    dx -= x;
    dy -= y;
    dz -= z;
    const auto is_near = dx * dx + dy * dy + dz * dz < limit;  // -1 where it holds
    for (int k = 0; k < 4; ++k) {
      near[count] = j[k];
      count -= static_cast<Index>(is_near[k]);
    }
  }
  for (; j != end; ++j) {
    const double* q = particles.place(*j);
    const double dx = q[0] - x, dy = q[1] - y, dz = q[2] - z;
    near[count] = *j;
    count += dx * dx + dy * dy + dz * dz < most;
  }
  return count;
}

// The contribution of a particle to its pairs, or of two particles to lanes that they share.
struct Owner {
  Double4 place[3], strength, normal[3], smooth, curvature[6];
};

template <bool kBends, bool kBent>
DEFORMABLE_SURFACE_INLINE void takeOwner(const PackedParticles& particles, Index i, Owner& owner) {
  const Double4 zero{0.0, 0.0, 0.0, 0.0};
  for (int a = 0; a < 3; ++a) owner.place[a] = zero + particles.place(i)[a];
  owner.strength = zero + particles.place(i)[3];
  for (int a = 0; kBends && a < 3; ++a) owner.normal[a] = zero + particles.normal(i)[a];
  if (kBends) owner.smooth = zero + particles.normal(i)[3];
  for (int a = 0; kBent && a < 6; ++a) owner.curvature[a] = zero + particles.curvature(i)[a];
}

// The owner keeps the lanes where mine is 1, the other gets those where it is 0.
template <bool kBends, bool kBent>
DEFORMABLE_SURFACE_INLINE void blend(const Double4& mine, const Owner& other, Owner& owner) {
  const Double4 half = mine - mine + 0.5;
  for (int a = 0; a < 3; ++a) owner.place[a] = mine > half ? owner.place[a] : other.place[a];
  owner.strength = mine > half ? owner.strength : other.strength;
  for (int a = 0; kBends && a < 3; ++a) owner.normal[a] = mine > half ? owner.normal[a] : other.normal[a];
  if (kBends) owner.smooth = mine > half ? owner.smooth : other.smooth;
  for (int a = 0; kBent && a < 6; ++a) owner.curvature[a] = mine > half ? owner.curvature[a] : other.curvature[a];
}

// Sums over all pairs of a particle, lane by lane: force; c_i; the vector to cross with the normal; torque.
struct Sums {
  Double4 value[10];
};

template <bool kBends, bool kNormality, bool kBent>
DEFORMABLE_SURFACE_INLINE void addPairs(const Pair<Double4>& pair, Sums& sums) {
  for (int a = 0; a < 3; ++a) {
    Double4& force = sums.value[a];
    force += pair.c_r * pair.r[a];
    if (kBends) {
      force += pair.c_j * pair.nj[a];
      sums.value[4 + a] += pair.c_i * pair.r[a];
      if (kNormality) sums.value[4 + a] += pair.twist * pair.q[a];
    }
    if (kBent) {
      force += pair.force[a];
      sums.value[7 + a] += pair.torque[a];
    }
  }
  if (kBends) sums.value[3] += pair.c_i;
}

template <bool kBends, bool kBent>
DEFORMABLE_SURFACE_INLINE void addSums(const PackedParticles& particles, Index i, const Sums& sums, Vec3* forces, Vec3* torques) {
  const Double4* const s = sums.value;
  forces[i] += Vec3(addLanes(s[0]), addLanes(s[1]), addLanes(s[2]));
  if (!kBends) return;
  const double* const normal = particles.normal(i);
  const Vec3 n(normal[0], normal[1], normal[2]);
  forces[i] += addLanes(s[3]) * n;
  torques[i] += Vec3(addLanes(s[4]), addLanes(s[5]), addLanes(s[6])).cross(n);
  if (kBent) torques[i] += Vec3(addLanes(s[7]), addLanes(s[8]), addLanes(s[9]));
}

// Two particles at a time: in a lattice each has six neighbours, so that both fill three times four lanes.
template <bool kAnisotropic, bool kPlanarity, bool kNormality, bool kCircularity, bool kBent = false>
DEFORMABLE_SURFACE_INLINE void gather(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles,
                                      Index begin, Index end, Vec3* forces, Vec3* torques) {
  constexpr bool kBends = kPlanarity || kNormality || kCircularity;
  constexpr int kValues = kBent ? 10 : kBends ? 7 : 3;
  const double *const places = particles.places.data(), *const normals = particles.normals.data();
  const Double4 zero{0.0, 0.0, 0.0, 0.0};
  Index near[2 * NeighborList::kMostNeighbors + 4];
  for (Index i = begin; i < end; i += 2) {
    const Index first = selectNear(p, lists, particles, i, near);
    const Index count = i + 1 < end ? first + selectNear(p, lists, particles, i + 1, near + first) : first;
    for (Index k = count; k < count + 3; ++k) near[k] = count > first ? i + 1 : i;  // with oneself there is no force
    Owner owner, next;
    Sums sums;
    for (int a = 0; a < kValues; ++a) sums.value[a] = zero;
    takeOwner<kBends, kBent>(particles, i, owner);
    if (count > first) takeOwner<kBends, kBent>(particles, i + 1, next);
    Index at = i;
    for (Index k = 0; k < count; k += 4) {
      Double4 lanes, mine;
      load(kLanes[std::min(Index{4}, count - k)], lanes);
      const bool is_shared = k < first && first < std::min(count, k + 4);
      if (is_shared) {
        load(kLanes[first - k], mine);
        blend<kBends, kBent>(mine, next, owner);
      } else if (k == first) {
        addSums<kBends, kBent>(particles, i, sums, forces, torques);
        for (int a = 0; a < kValues; ++a) sums.value[a] = zero;
        owner = next;
        at = i + 1;
      }
      Pair<Double4> pair;
      Double4 strength;
      loadRows(places, near + k, pair.r[0], pair.r[1], pair.r[2], strength);
      for (int a = 0; a < 3; ++a) pair.r[a] -= owner.place[a];
      pair.strength = lanes * (strength < owner.strength ? strength : owner.strength);
      if (kBends) {
        Double4 smooth;
        loadRows(normals, near + k, pair.nj[0], pair.nj[1], pair.nj[2], smooth);
        for (int a = 0; a < 3; ++a) pair.ni[a] = owner.normal[a];
        pair.smooth_strength = pair.strength * smooth * owner.smooth;
      }
      if (kBent) {
        Double4 zeros, more_zeros;  // each its own: rows become columns in place
        for (int a = 0; a < 6; ++a) pair.ki[a] = owner.curvature[a];
        loadRows<8>(particles.curvatures.data(), near + k, pair.kj[0], pair.kj[1], pair.kj[2], pair.kj[3]);
        loadRows<8>(particles.curvatures.data() + 4, near + k, pair.kj[4], pair.kj[5], zeros, more_zeros);
      }
      evaluatePair<kAnisotropic, kPlanarity, kNormality, kCircularity, kBent>(p, pair);
      if (!is_shared) {
        addPairs<kBends, kNormality, kBent>(pair, sums);
        continue;
      }
      Sums both;
      for (int a = 0; a < kValues; ++a) both.value[a] = zero;
      addPairs<kBends, kNormality, kBent>(pair, both);
      for (int a = 0; a < kValues; ++a) {
        const Double4 part = mine * both.value[a];
        sums.value[a] += part;
        both.value[a] -= part;
      }
      addSums<kBends, kBent>(particles, i, sums, forces, torques);
      sums = both;
      owner = next;
      at = i + 1;
    }
    addSums<kBends, kBent>(particles, at, sums, forces, torques);
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
      if (begin <= *j && *j < i) continue;  // a pair of two of these was counted in full at its first
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
      sum += (i < *j && *j < end ? 1.0 : 0.5) * pair.level;
    }
  }
  return sum;
}

namespace {

// Calls take(r, pair) for each particle near i that it is cut from, if it is nearer than bonds are long at rest: r = p_j - p_i,
// m.
template <class Take>
void forEachContact(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles, Index i,
                    const Take& take) {
  const Eigen::Map<const Vec3> place(particles.place(i));
  for (const Index* j = lists.beginParted(i); j != lists.endParted(i); ++j) {
    Pair<double> pair;
    const Vec3 r = Eigen::Map<const Vec3>(particles.place(*j)) - place;
    if (!(r.squaredNorm() < p.distance * p.distance)) continue;
    Eigen::Map<Vec3>(pair.r) = r;
    pair.strength = 0.0;
    evaluatePair<false, false, false, false, false>(p, pair);
    take(r, pair);
  }
}

}  // namespace

void gatherContact(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles, Index begin, Index end,
                   Vec3* forces) {
  if (!lists.hasParted()) return;
  for (Index i = begin; i < end; ++i)
    forEachContact(p, lists, particles, i, [&](const Vec3& r, const Pair<double>& pair) { forces[i] += pair.c_r * r; });
}

double gatherContactEnergy(const PairPotentials& p, const NeighborList& lists, const PackedParticles& particles, Index begin,
                           Index end) {
  double sum = 0.0;
  if (!lists.hasParted()) return sum;
  for (Index i = begin; i < end; ++i)
    forEachContact(p, lists, particles, i, [&](const Vec3&, const Pair<double>& pair) { sum += 0.5 * pair.level; });
  return sum;
}

namespace {

// Calls take(j, r, d, c) for each particle j near i that is kept apart from it and nearer than c, m.
template <class Take>
void forEachApart(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index i,
                  const Take& take) {
  const Eigen::Map<const Vec3> place(particles.place(i));
  for (const NeighborList::Apart* other = lists.beginApart(i); other != lists.endApart(i); ++other) {
    const Vec3 r = Eigen::Map<const Vec3>(particles.place(other->particle)) - place;
    const double d = r.norm(), c = std::min(apart.range, other->range);
    if (d < c) take(other->particle, r, d, c);
  }
}

// The direction from the first to the second of two particles in one place: along the surface of the first, in the plane y = 0
// for curves.
Vec3 findWayOut(const PackedParticles& particles, Index first) {
  const Eigen::Map<const Vec3> normal(particles.normal(first));
  constexpr double kSteep = 0.9;
  return normal.cross(std::abs(normal.y()) < kSteep ? Vec3::UnitY() : Vec3::UnitX()).normalized();
}

}  // namespace

void gatherApart(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index begin, Index end,
                 Vec3* forces) {
  if (!lists.hasApart()) return;
  for (Index i = begin; i < end; ++i)
    forEachApart(apart, lists, particles, i, [&](Index j, const Vec3& r, double d, double c) {
      const double push = 2.0 * apart.stiffness * (c - d);
      const Vec3 way = d > 0.0 ? Vec3(r / d) : Vec3(i < j ? findWayOut(particles, i) : -findWayOut(particles, j));
      forces[i] -= push * way;
    });
}

double gatherApartEnergy(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index begin,
                         Index end) {
  double sum = 0.0;
  if (!lists.hasApart()) return sum;
  for (Index i = begin; i < end; ++i)
    forEachApart(apart, lists, particles, i, [&](Index, const Vec3&, double d, double c) {
      sum += 0.5 * apart.stiffness * (c - d) * (c - d);  // the other half is the other particle's
    });
  return sum;
}

Index countApart(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index i) {
  Index count = 0;
  forEachApart(apart, lists, particles, i, [&](Index, const Vec3&, double, double) { ++count; });
  return count;
}

}  // namespace deformable_surface::model
