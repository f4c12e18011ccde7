#include "deformable_surface/model/elastic_solid/solid_passes.h"

#include "neo_hookean.h"
#include "solid_lanes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::model {
namespace {

using namespace lanes;

constexpr Index kRoom = PointRooms::kNumbers;
constexpr Index kConstants = 13;
constexpr Index kTangents = 15;
constexpr Index kEnergies = 256;  // points whose energies fit on the stack
// Of mu: the derivative has poles where two stretches cancel, and is limited to this there.
constexpr double kMostTangent = 1e3;

bool isOfPlaces(StressLaw law) {
  return law == StressLaw::kCorotated || law == StressLaw::kLinear || law == StressLaw::kNeoHookean;
}

// Whether no rotation shows that neighbours span no volume.
bool missesDeficiency(StressLaw law) { return law == StressLaw::kLinear || law == StressLaw::kNeoHookean; }

// For one point: sums over the neighbours j of (x_j - x_i) row_j[c], c < 3, and over the near ones, which come first, of
// (x_j - x_i) m_j[c], c < 4. places: of the neighbours in the block's memory.
DEFORMABLE_SURFACE_INLINE void gatherOne(const PassArrays& a, const double* room, Index place, Index i, Double4* strained,
                                         Double4* near) {
  const Index* places = a.places;
  const double *row = a.row + 3 * static_cast<std::ptrdiff_t>(a.offsets[i]),
               *m = a.m + 4 * static_cast<std::ptrdiff_t>(a.near_offsets[i]);
  Double4 here, f[3]{}, sums[4]{}, others[3];
  load(room + kRoom * static_cast<std::ptrdiff_t>(place), here);
  Index k = a.offsets[i];
  const Index near_end = k + a.near_offsets[i + 1] - a.near_offsets[i];
  for (; k < near_end; ++k, row += 3, m += 4) {
    Double4 d;
    load(room + kRoom * static_cast<std::ptrdiff_t>(places[k]), d);
    d -= here;
    for (int c = 0; c < 3; ++c) f[c] += d * row[c];
    for (int c = 0; c < 4; ++c) sums[c] += d * m[c];
  }
  gatherPairs<3, kRoom>(near_end, a.offsets[i + 1], places, a.row, room, place, others);
  for (int c = 0; c < 3; ++c) strained[c] = f[c] + others[c];
  for (int c = 0; c < 4; ++c) near[c] = sums[c];
}

// Adds the action of one point on its neighbours, -(Q row_j + N m_j), Q and N by columns x y z 0.
DEFORMABLE_SURFACE_INLINE void scatterOne(const PassArrays& a, double* room, Index i, const Double4* Q, const Double4* N) {
  const Index* places = a.places;
  const double *row = a.row + 3 * static_cast<std::ptrdiff_t>(a.offsets[i]),
               *m = a.m + 4 * static_cast<std::ptrdiff_t>(a.near_offsets[i]);
  Index k = a.offsets[i];
  const Index near_end = k + a.near_offsets[i + 1] - a.near_offsets[i], end = a.offsets[i + 1];
  const Double4 q0 = Q[0], q1 = Q[1], q2 = Q[2], n0 = N[0], n1 = N[1], n2 = N[2];
  for (; k < near_end; ++k, row += 3, m += 4) {
    double* to = room + kRoom * static_cast<std::ptrdiff_t>(places[k]) + 4;
    Double4 force;
    load(to, force);
    force -= (q0 * row[0] + q1 * row[1] + q2 * row[2]) + (n0 * m[0] + n1 * m[1] + n2 * m[2]);
    store(force, to);
  }
  for (; k < end; ++k, row += 3) {
    double* to = room + kRoom * static_cast<std::ptrdiff_t>(places[k]) + 4;
    Double4 force;
    load(to, force);
    force -= q0 * row[0] + q1 * row[1] + q2 * row[2];
    store(force, to);
  }
}

// The action of the points [begin, end) of a block on themselves and on their neighbours. Returns whether any point has to be
// treated singly; such points are marked in the fourth number of their force.
DEFORMABLE_SURFACE_WIDE bool spread(StressLaw law, Index begin, Index end, const PassArrays& a, double* room) {
  bool any_unsound = false;
  for (Index i = begin; i < end; i += 4) {
    Four F, R, Q, A, N;
    Double4 strained[4][3], near[4][4], sums[3];
    for (Index lane = 0; lane < 4; ++lane) {
      const Index j = i + lane < end ? i + lane : end - 1;  // the last group is filled up
      gatherOne(a, room, j - begin, j, strained[lane], near[lane]);
    }
    for (int c = 0; c < 3; ++c) {
      transpose(strained[0][c], strained[1][c], strained[2][c], strained[3][c]);
      for (int r = 0; r < 3; ++r) F.at[r][c] = strained[r][c];
    }
    for (int c = 0; c < 4; ++c) {
      transpose(near[0][c], near[1][c], near[2][c], near[3][c]);
      for (int r = 0; r < 3; ++r) (c < 3 ? A.at[r][c] : sums[r]) = near[r][c];
    }
    if (isOfPlaces(law)) addAcross(a, F);
    bool is_sound[4] = {true, true, true, true};
    if (law == StressLaw::kCorotated) findRotations(F, R, is_sound);
    const double* tangent = a.tangent + kTangents * static_cast<std::ptrdiff_t>(i);
    if (law == StressLaw::kTangent) {
      findTangentStresses(a.mu, a.lambda, F, tangent, Q);
    } else if (law == StressLaw::kNeoHookeanTangent) {
      findNeoHookeanTangentStresses(a.mu, F, tangent, Q);
    } else {
      findStresses(law, a.mu, a.lambda, F, R, Q);
    }
    const double* constants = a.constants + kConstants * static_cast<std::ptrdiff_t>(i);
    Double4 volume, g[3], m[3];
    load(constants, volume);
    multiplyByInverse(A, constants + 16, N);
    for (int c = 0; c < 3; ++c) {
      load(constants + 4 * (1 + c), g[c]);
      load(constants + 4 * (10 + c), m[c]);
      for (int r = 0; r < 3; ++r) {
        Q.at[r][c] *= volume;
        N.at[r][c] *= -a.stabilization;
      }
    }
    Double4 own[4]{};
    for (int r = 0; r < 3; ++r) {
      own[r] = 2.0 * a.stabilization * sums[r];
      for (int c = 0; c < 3; ++c) own[r] += Q.at[r][c] * g[c] + N.at[r][c] * m[c];
    }
    transpose(own[0], own[1], own[2], own[3]);
    Double4 Q_columns[3][4]{}, N_columns[3][4]{};
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        Q_columns[c][r] = Q.at[r][c];
        N_columns[c][r] = N.at[r][c];
      }
      transpose(Q_columns[c][0], Q_columns[c][1], Q_columns[c][2], Q_columns[c][3]);
      transpose(N_columns[c][0], N_columns[c][1], N_columns[c][2], N_columns[c][3]);
    }
    for (Index lane = 0; lane < 4 && i + lane < end; ++lane) {
      double* to = room + kRoom * static_cast<std::ptrdiff_t>(i + lane - begin) + 4;
      if (!is_sound[lane] || (a.deficient && missesDeficiency(law) && a.deficient[i + lane])) {
        any_unsound = true;
        to[3] = 1.0;
        continue;
      }
      Double4 force;
      load(to, force);
      store(force + own[lane], to);
      const Double4 Q_lane[3] = {Q_columns[0][lane], Q_columns[1][lane], Q_columns[2][lane]};
      const Double4 N_lane[3] = {N_columns[0][lane], N_columns[1][lane], N_columns[2][lane]};
      scatterOne(a, room, i + lane, Q_lane, N_lane);
    }
  }
  return any_unsound;
}

// Energies of four points at a time, J; NaN for points that have to be treated singly. energies: (end - begin, padded to
// fours).
DEFORMABLE_SURFACE_WIDE void findEnergies(StressLaw law, Index begin, Index end, const PassArrays& a, double* energies) {
  for (Index i = begin; i < end; i += 4) {
    Four A, F, R, N;
    const double* constants = a.constants + kConstants * static_cast<std::ptrdiff_t>(i);
    gatherFour<3>(i, a.n, a.offsets, a.items, a.row, a.positions, F);
    gatherFour<4>(i, a.n, a.near_offsets, a.near_items, a.m, a.positions, A);
    multiplyByInverse(A, constants + 16, N);
    addAcross(a, F);
    bool is_sound[4] = {true, true, true, true};
    if (law == StressLaw::kCorotated) findRotations(F, R, is_sound);
    Double4 density, volume;
    findDensities(law, a.mu, a.lambda, F, R, density);
    load(constants, volume);
    const Double4 elastic = volume * density;
    Double4 columns[3][4];
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) columns[c][r] = N.at[r][c];
      columns[c][3] = Double4{};
      transpose(columns[c][0], columns[c][1], columns[c][2], columns[c][3]);
    }
    const Index lanes = a.n - i < 4 ? a.n - i : 4;
    for (Index lane = 0; lane < lanes; ++lane) {
      Double4 here, sum{};
      load(a.positions + 4 * static_cast<std::ptrdiff_t>(i + lane), here);
      for (Index k = a.near_offsets[i + lane]; k < a.near_offsets[i + lane + 1]; ++k) {
        const double* m = a.m + 4 * static_cast<std::ptrdiff_t>(k);
        Double4 d;
        load(a.positions + 4 * static_cast<std::ptrdiff_t>(a.near_items[k]), d);
        d = (d - here) * m[3] - columns[0][lane] * m[0] - columns[1][lane] * m[1] - columns[2][lane] * m[2];
        sum += d * d * (1.0 / m[3]);
      }
      const double rest = 0.5 * a.stabilization * (sum[0] + sum[1] + sum[2]);
      energies[i - begin + lane] = is_sound[lane] ? elastic[lane] + rest : std::numeric_limits<double>::quiet_NaN();
    }
  }
}

// R and M of four points at a time; is_sound (end - begin, padded to fours) is false for points to be treated singly.
DEFORMABLE_SURFACE_WIDE void findTangents(StressLaw law, bool is_positive, Index begin, Index end, const PassArrays& a,
                                          double* tangent, bool* is_sound) {
  for (Index i = begin; i < end; i += 4) {
    Four F, R, S, H;
    gatherFour<3>(i, a.n, a.offsets, a.items, a.row, a.positions, F);
    addAcross(a, F);
    bool* sound = is_sound + (i - begin);
    findRotations(F, R, sound);
    for (int r = 0; r < 3; ++r)
      for (int c = r; c < 3; ++c) S.at[r][c] = R.at[0][r] * F.at[0][c] + R.at[1][r] * F.at[1][c] + R.at[2][r] * F.at[2][c];
    const Double4 trace = S.at[0][0] + S.at[1][1] + S.at[2][2], turned = a.lambda * (trace - 3.0) - 2.0 * a.mu;
    // The inverse of G = tr(S) I - S by its cofactors.
    const Double4 xx = trace - S.at[0][0], yy = trace - S.at[1][1], zz = trace - S.at[2][2];
    const Double4 xy = -S.at[0][1], xz = -S.at[0][2], yz = -S.at[1][2];
    H.at[0][0] = yy * zz - yz * yz;
    H.at[0][1] = xz * yz - xy * zz;
    H.at[0][2] = xy * yz - xz * yy;
    H.at[1][1] = xx * zz - xz * xz;
    H.at[1][2] = xy * xz - xx * yz;
    H.at[2][2] = xx * yy - xy * xy;
    const Double4 factor = turned / (xx * H.at[0][0] + xy * H.at[0][1] + xz * H.at[0][2]);
    double* to = tangent + kTangents * static_cast<std::ptrdiff_t>(i);
    Double4 M[6];
    for (int r = 0, k = 0; r < 3; ++r)
      for (int c = r; c < 3; ++c, ++k) {
        M[k] = factor * H.at[r][c];
        store(M[k], to + 36 + 4 * k);
      }
    for (int k = 0; k < 9; ++k) store(R.at[k / 3][k % 3], to + 4 * k);
    // Minors of M / mu + I.
    const Double4 a0 = M[0] / a.mu + 1.0, a1 = M[1] / a.mu, a2 = M[2] / a.mu, a3 = M[3] / a.mu + 1.0, a4 = M[4] / a.mu,
                  a5 = M[5] / a.mu + 1.0;
    const Double4 second = a0 * a3 - a1 * a1;
    const Double4 third = a0 * (a3 * a5 - a4 * a4) - a1 * (a1 * a5 - a2 * a4) + a2 * (a1 * a4 - a2 * a3);
    for (int lane = 0; lane < 4; ++lane)
      sound[lane] = sound[lane] && law == StressLaw::kCorotated &&
                    (!is_positive || (a0[lane] > 0.0 && second[lane] > 0.0 && third[lane] > 0.0));
  }
}

// Sum over the neighbours of (x_j - x_i) row_j^T; rows of `width` numbers.
Mat3 sumPairs(const Lists& pairs, const std::vector<double>& rows, int width, Index i, const double* positions) {
  Mat3 A = Mat3::Zero();
  const Eigen::Map<const Vec3> here(positions + 4 * static_cast<std::ptrdiff_t>(i));
  for (Index k = pairs.offsets[i]; k < pairs.offsets[i + 1]; ++k) {
    const Vec3 d = Eigen::Map<const Vec3>(positions + 4 * static_cast<std::ptrdiff_t>(pairs.items[k])) - here;
    A += d * Eigen::Map<const Vec3>(rows.data() + width * static_cast<std::size_t>(k)).transpose();
  }
  return A;
}

// Sum over the neighbours of w'_ij (x_j - x_i).
Vec3 sumWeighted(const PairFit& near, Index i, const double* positions) {
  Vec3 sum = Vec3::Zero();
  const Eigen::Map<const Vec3> here(positions + 4 * static_cast<std::ptrdiff_t>(i));
  for (Index k = near.pairs.offsets[i]; k < near.pairs.offsets[i + 1]; ++k)
    sum += near.m[4 * static_cast<std::size_t>(k) + 3] *
           (Eigen::Map<const Vec3>(positions + 4 * static_cast<std::ptrdiff_t>(near.pairs.items[k])) - here);
  return sum;
}

Vec3 sumMoments(const PairFit& fit, Index i) {
  Vec3 sum = Vec3::Zero();
  for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k)
    sum += Eigen::Map<const Vec3>(fit.m.data() + 4 * static_cast<std::size_t>(k));
  return sum;
}

// The shortest rotation from unit a to unit b.
Mat3 turnTo(const Vec3& a, const Vec3& b) { return Quaternion::FromTwoVectors(a, b).toRotationMatrix(); }

// F where neighbours lie in a plane or on a line only: see fitGradient().
Mat3 complete(const Mat3& F, const Mat3& inverse, int rank) {
  const Eigen::JacobiSVD<Mat3> at_rest(inverse, Eigen::ComputeFullU);
  const Mat3 axes = at_rest.matrixU();
  if (rank == 2) {
    const Vec3 normal = axes.col(2),
               image = (F * axes.col(0)).cross(F * axes.col(1)) * (axes.col(0).cross(axes.col(1)).dot(normal));
    const double length = image.norm();
    return length > 0.0 ? Mat3(F + image / length * normal.transpose()) : F;
  }
  if (rank == 1) {
    const Vec3 along = axes.col(0), image = F * along;
    const double length = image.norm();
    return length > 0.0 ? Mat3(F + turnTo(along, image / length) * (Mat3::Identity() - along * along.transpose())) : F;
  }
  return Mat3::Identity();
}

}  // namespace

Mat3 findRotation(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  if (U.determinant() * svd.matrixV().determinant() < 0.0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

Mat3 findCofactors(const Mat3& F) {
  Mat3 C;
  C << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return C;
}

SolidPasses::SolidPasses(SolidRest given) : rest(std::move(given)), rooms_(rest.fit.pairs) {
  const Index n = size();
  const std::size_t groups = (static_cast<std::size_t>(n) + 3) / 4;
  constants_.assign(4 * kConstants * groups, 0.0);
  for (std::size_t g = 0; g < groups; ++g)
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const Index i = std::min(static_cast<Index>(4 * g + lane), n - 1);
      double values[kConstants];
      values[0] = rest.volumes[i];
      for (int c = 0; c < 3; ++c) values[1 + c] = rest.gradients.own[i][c];
      for (int k = 0; k < 6; ++k) values[4 + k] = rest.near.inverse[6 * static_cast<std::size_t>(i) + k];
      for (int c = 0; c < 3; ++c) values[10 + c] = sumMoments(rest.near, i)[c];
      for (Index k = 0; k < kConstants; ++k) constants_[4 * (kConstants * g + k) + lane] = values[k];
    }
  for (Index i = 0; i < n; ++i) {
    if (!isDeficient(i)) continue;
    is_deficient_.resize(n, 0);
    is_deficient_[i] = 1;
  }
}

PassArrays SolidPasses::arraysOf(const double* positions) const {
  return {size(),
          rest.fit.pairs.offsets.data(),
          rest.fit.pairs.items.data(),
          rooms_.places().data(),
          rest.gradients.row.data(),
          rest.near.pairs.offsets.data(),
          rest.near.pairs.items.data(),
          rest.near.m.data(),
          constants_.data(),
          tangent_.data(),
          positions,
          is_deficient_.empty() ? nullptr : is_deficient_.data(),
          rest.mu,
          rest.lambda,
          rest.stabilization,
          {rest.across.x(), rest.across.y(), rest.across.z()}};
}

void SolidPasses::spreadStress(StressLaw law, Index begin, Index end, const double* positions) {
  double* room = rooms_.fill(begin, end, positions);
  if (!spread(law, begin, end, arraysOf(positions), room)) return;
  for (Index i = begin; i < end; ++i)
    if (room[kRoom * static_cast<std::ptrdiff_t>(i - begin) + 7] != 0.0) spreadOne(law, i, i - begin, positions, room);
}

void SolidPasses::spreadOne(StressLaw law, Index i, Index place, const double* positions, double* room) const {
  const Mat3 N = -rest.stabilization * sumPairs(rest.near.pairs, rest.near.m, 4, i, positions) * rest.near.inverseAt(i);
  const Mat3 Q = rest.fit.rank[i] > 0 ? Mat3(rest.volumes[i] * findStress(law, fitGradient(i, positions))) : Mat3(Mat3::Zero());
  const auto forceAt = [room](Index at) { return Eigen::Map<Vec3>(room + kRoom * static_cast<std::ptrdiff_t>(at) + 4); };
  forceAt(place) +=
      Q * rest.gradients.own[i] + N * sumMoments(rest.near, i) + 2.0 * rest.stabilization * sumWeighted(rest.near, i, positions);
  const Index first = rest.fit.pairs.offsets[i], near = rest.near.pairs.offsets[i];
  for (Index k = first; k < rest.fit.pairs.offsets[i + 1]; ++k)
    forceAt(rooms_.places()[k]) -= Q * Eigen::Map<const Vec3>(rest.gradients.row.data() + 3 * static_cast<std::size_t>(k));
  for (Index k = near; k < rest.near.pairs.offsets[i + 1]; ++k)
    forceAt(rooms_.places()[first + k - near]) -=
        N * Eigen::Map<const Vec3>(rest.near.m.data() + 4 * static_cast<std::size_t>(k));
}

void SolidPasses::beginTangent() { tangent_.resize(4 * kTangents * ((static_cast<std::size_t>(size()) + 3) / 4)); }

void SolidPasses::prepareTangent(StressLaw law, bool is_positive, Index begin, Index end, const double* positions) {
  if (law == StressLaw::kNeoHookean) {
    for (Index i = begin; i < end; ++i) prepareNeoHookean(is_positive, i, positions);
    return;
  }
  bool is_sound[kEnergies];
  const PassArrays arrays = arraysOf(positions);
  for (Index first = begin; first < end; first += kEnergies) {
    const Index last = std::min(end, first + kEnergies);
    findTangents(law, is_positive, first, last, arrays, tangent_.data(), is_sound);
    for (Index i = first; i < last; ++i)
      if (!is_sound[i - first]) prepareOne(law, is_positive, i, positions);
  }
}

void SolidPasses::prepareNeoHookean(bool is_positive, Index i, const double* positions) {
  const Mat3 F = fitGradient(i, positions);
  double* to = tangent_.data() + 4 * kTangents * static_cast<std::size_t>(i / 4) + i % 4;
  for (int k = 0; k < 9; ++k) to[4 * k] = F(k / 3, k % 3);
  neo_hookean::Factor factor = neo_hookean::findFactor(rest.mu, rest.lambda, F.determinant());
  if (is_positive) factor = neo_hookean::limitFactor(rest.mu, F, factor);
  to[36] = factor.value;
  to[40] = factor.slope;
}

double SolidPasses::boundStiffening(Index begin, Index end, const double* positions) const {
  double largest = 0.0;
  for (Index i = begin; i < end; ++i)
    largest = std::max(largest, neo_hookean::boundStiffening(rest.mu, rest.lambda, fitGradient(i, positions)));
  return largest;
}

void SolidPasses::prepareOne(StressLaw law, bool is_positive, Index i, const double* positions) {
  const double mu = rest.mu;
  Mat3 R = Mat3::Identity(), M = -mu * R;
  if (law == StressLaw::kCorotated) {
    const Mat3 F = fitGradient(i, positions);
    R = findRotation(F);
    const Mat3 S = 0.5 * (R.transpose() * F + F.transpose() * R);
    const double turned = rest.lambda * (S.trace() - 3.0) - 2.0 * mu;
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(S);
    Vec3 values;
    for (int k = 0; k < 3; ++k) {
      const double spread = S.trace() - solver.eigenvalues()[k], least = std::abs(turned) / (kMostTangent * mu);
      values[k] = turned / (std::abs(spread) > least ? spread : std::copysign(least, spread));
      if (is_positive) values[k] = std::max(values[k], -mu);
    }
    M = solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
  }
  double* to = tangent_.data() + 4 * kTangents * static_cast<std::size_t>(i / 4) + i % 4;
  for (int k = 0; k < 9; ++k) to[4 * k] = R(k / 3, k % 3);
  for (int r = 0, k = 9; r < 3; ++r)
    for (int c = r; c < 3; ++c, ++k) to[4 * k] = M(r, c);
}

Mat3 SolidPasses::fitGradient(Index i, const double* positions) const {
  const Mat3 F = sumPairs(rest.fit.pairs, rest.gradients.row, 3, i, positions);
  const bool is_planar = !rest.across.isZero(0.0);
  if (is_planar && rest.fit.rank[i] == 2) return F + rest.across * rest.across.transpose();
  return rest.fit.rank[i] == 3 ? F : complete(F, rest.fit.inverseAt(i), rest.fit.rank[i]);
}

Mat3 SolidPasses::findStress(StressLaw law, const Mat3& F) const {
  const double mu = rest.mu, lambda = rest.lambda;
  if (law == StressLaw::kBound) return 2.0 * mu * F + lambda * F.trace() * Mat3::Identity();
  if (law == StressLaw::kLinear) {
    const Mat3 strain = 0.5 * (F + F.transpose()) - Mat3::Identity();
    return 2.0 * mu * strain + lambda * strain.trace() * Mat3::Identity();
  }
  if (law == StressLaw::kNeoHookean) return neo_hookean::findStress(mu, lambda, F);
  const Mat3 R = findRotation(F);
  return 2.0 * mu * (F - R) + lambda * (R.cwiseProduct(F).sum() - 3.0) * R;
}

double SolidPasses::findDensity(StressLaw law, const Mat3& F) const {
  if (law == StressLaw::kNeoHookean) return neo_hookean::findDensity(rest.mu, rest.lambda, F);
  const Mat3 R = law == StressLaw::kLinear ? Mat3(Mat3::Identity()) : findRotation(F);
  const Mat3 strain = law == StressLaw::kLinear ? Mat3(0.5 * (F + F.transpose()) - R) : Mat3(F - R);
  const double trace = R.cwiseProduct(strain).sum();
  return rest.mu * strain.squaredNorm() + 0.5 * rest.lambda * trace * trace;
}

void SolidPasses::setPlastic(Index i, const ConsistentGradients& at_rest, const Mat3& inverse) {
  const auto at = [](auto& rows, Index k) { return rows.data() + 3 * static_cast<std::size_t>(k); };
  for (Index k = rest.fit.pairs.offsets[i]; k < rest.fit.pairs.offsets[i + 1]; ++k) {
    Eigen::Map<Vec3>(at(rest.gradients.row, k)) = inverse.transpose() * Eigen::Map<const Vec3>(at(at_rest.row, k));
  }
  rest.gradients.own[i] = inverse.transpose() * at_rest.own[i];
  double* constants = constants_.data() + 4 * kConstants * static_cast<std::size_t>(i / 4);
  for (Index lane = i % 4; lane < 4; lane += i + 1 == size() ? 1 : 4)  // the last group is filled up with the last point
    for (int c = 0; c < 3; ++c) constants[4 * (1 + c) + lane] = rest.gradients.own[i][c];
}

double SolidPasses::findEnergy(StressLaw law, Index i, const double* positions) const {
  const double density = rest.fit.rank[i] > 0 ? findDensity(law, fitGradient(i, positions)) : 0.0;
  const Mat3 N = sumPairs(rest.near.pairs, rest.near.m, 4, i, positions) * rest.near.inverseAt(i);
  double sum = 0.0;
  const Eigen::Map<const Vec3> here(positions + 4 * static_cast<std::ptrdiff_t>(i));
  for (Index k = rest.near.pairs.offsets[i]; k < rest.near.pairs.offsets[i + 1]; ++k) {
    const double* m = rest.near.m.data() + 4 * static_cast<std::size_t>(k);
    const Vec3 d = Eigen::Map<const Vec3>(positions + 4 * static_cast<std::ptrdiff_t>(rest.near.pairs.items[k])) - here;
    sum += (m[3] * d - N * Eigen::Map<const Vec3>(m)).squaredNorm() / m[3];
  }
  return rest.volumes[i] * density + 0.5 * rest.stabilization * sum;
}

double SolidPasses::sumEnergy(StressLaw law, Index begin, Index end, const double* positions) const {
  double energies[kEnergies], sum = 0.0;
  const PassArrays arrays = arraysOf(positions);
  for (Index first = begin; first < end; first += kEnergies) {
    const Index last = std::min(end, first + kEnergies);
    findEnergies(law, first, last, arrays, energies);
    for (Index i = first; i < last; ++i) {
      const bool is_sound = std::isfinite(energies[i - first]) && !(missesDeficiency(law) && isDeficient(i));
      sum += is_sound ? energies[i - first] : findEnergy(law, i, positions);
    }
  }
  return sum;
}

}  // namespace deformable_surface::model
