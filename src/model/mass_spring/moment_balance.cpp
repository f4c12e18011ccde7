#include "moment_balance.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/linear/block_cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;  // fits or points per task
constexpr int kMaxIterations = 30;
constexpr double kTolerance = 1e-4;  // fraction of the initial norm of the residual
constexpr double kShift = 1e-11;     // fraction of the diagonal: quadratics have no cost, and the factor must be definite
// The same, times the squared sine of the angle between the normals of neighbours. On curved surfaces there are no exact
// quadratics. Approximate ones can hardly be balanced, and would change the rows too much.
constexpr double kCurvedShift = 0.05;
constexpr Index kMaxFactored = 20000;  // points above which the factor costs more than it saves

// A symmetric tensor of a tangent plane: half of its trace, half of the difference of its diagonal, its off-diagonal. The inner
// product of two tensors is twice that of these numbers.
using Tensor = Vec3;
using Tensors = Multipliers;

Tensor toTensor(double xx, double xy, double yy) { return {0.5 * (xx + yy), 0.5 * (xx - yy), xy}; }

// From the axes of one point to those of another: the last two numbers of a tensor turn by twice the angle of the axes.
struct Turn {
  double cosine = 1.0, sine = 0.0;
  Tensor apply(const Tensor& x) const { return {x[0], cosine * x[1] - sine * x[2], sine * x[1] + cosine * x[2]}; }
  Tensor applyInverse(const Tensor& x) const { return {x[0], cosine * x[1] + sine * x[2], cosine * x[2] - sine * x[1]}; }
};

Turn findTurn(const Vec3& from_normal, const TangentAxes& from, const Vec3& to_normal, const TangentAxes& to) {
  const Vec3 axis = Quaternion::FromTwoVectors(from_normal, to_normal) * from.first;
  const double c = axis.dot(to.first), s = axis.dot(to.second), squares = c * c + s * s;
  return {(c * c - s * s) / squares, 2.0 * c * s / squares};
}

double dot(const Tensors& a, const Tensors& b) {
  return parallelSum(static_cast<Index>(a.size()), 16 * kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

// to += factor * what.
void add(double factor, const Tensors& what, Tensors& to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * what[i];
}

// The equation for the multipliers, one tensor per point.
class MomentBalance {
 public:
  MomentBalance(const ClampedPlate& clamped, const std::vector<double>& areas, const CurvatureFits& fits,
                const std::vector<char>& is_fixed);

  Index size() const { return fits_.points.size(); }
  bool isUnknown(Index j) const { return is_unknown_[j]; }
  /// The unbalanced part of the moments of the rows.
  void findResidual(Tensors& residual) const;
  /// (S + shift) l.
  void multiply(const Tensors& l, Tensors& product) const;
  /// z_m of fit i, for each of its points, of multipliers.
  void explain(Index i, const Tensors& l, Tensor* change) const;

  const CurvatureFits& fits() const { return fits_; }
  const TangentAxes& axes(Index i) const { return axes_[i]; }
  const Lists& users() const { return users_; }
  Index fitOf(Index item) const { return fit_of_[item]; }
  /// A_i / R_i^2; 0 without a fit.
  double scale(Index i) const { return scale_[i]; }
  /// Diagonal of S; and the shift added to it.
  double diagonal(Index j) const { return diagonal_[j]; }
  double shift(Index j) const { return shift_[j]; }

 private:
  void gather(const Tensors& pushed, Tensors& sums) const;
  Vec2 placeOf(Index i, Index item) const {
    const Vec3 d = plate_.points[fits_.points.items[item]] - plate_.points[i];
    return {d.dot(axes_[i].first), d.dot(axes_[i].second)};
  }

  const ClampedPlate& clamped_;
  const PlateRest& plate_;
  const std::vector<double>& areas_;
  const CurvatureFits& fits_;
  std::vector<TangentAxes> axes_;
  std::vector<Turn> turns_;    // per item of the fits' points, from the item's axes to those of the fit
  std::vector<Index> fit_of_;  // per item
  Lists users_;                // per point: its items
  std::vector<char> is_unknown_;
  std::vector<double> scale_, diagonal_, shift_;
  mutable Tensors pushed_;  // per item
};

MomentBalance::MomentBalance(const ClampedPlate& clamped, const std::vector<double>& areas, const CurvatureFits& fits,
                             const std::vector<char>& is_fixed)
    : clamped_(clamped), plate_(clamped.plate), areas_(areas), fits_(fits) {
  const Index n = size(), num_items = static_cast<Index>(fits.points.items.size());
  axes_.reserve(n);
  for (const Vec3& normal : plate_.normals) axes_.emplace_back(normal);
  scale_.assign(n, 0.0);
  for (Index i = 0; i < n; ++i)
    if (fits.has(i)) scale_[i] = areas[i] / (fits.reach[i] * fits.reach[i]);
  turns_.resize(num_items);
  fit_of_.resize(num_items);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      for (Index item = fits.points.offsets[i]; item < fits.points.offsets[i + 1]; ++item) {
        const Index j = fits.points.items[item];
        fit_of_[item] = i;
        if (j != i) turns_[item] = findTurn(plate_.normals[j], axes_[j], plate_.normals[i], axes_[i]);
      }
  });
  // Counted, then placed.
  users_.offsets.assign(n + 1, 0);
  for (Index item = 0; item < num_items; ++item)
    if (scale_[fit_of_[item]] > 0.0) ++users_.offsets[fits.points.items[item] + 1];
  for (Index j = 0; j < n; ++j) users_.offsets[j + 1] += users_.offsets[j];
  users_.items.resize(users_.offsets[n]);
  std::vector<Index> next(users_.offsets.begin(), users_.offsets.end() - 1);
  for (Index item = 0; item < num_items; ++item)
    if (scale_[fit_of_[item]] > 0.0) users_.items[next[fits.points.items[item]]++] = item;
  is_unknown_.resize(n);
  for (Index j = 0; j < n; ++j)
    is_unknown_[j] = users_.count(j) > 0 && !clamped.isClamped(j) && (is_fixed.empty() || !is_fixed[j]);
  pushed_.resize(num_items);
  // The diagonal, and the mean squared sine of the angles between the normals of a fit.
  std::vector<double> own(num_items, 0.0), turns(n, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index first = fits.points.offsets[i], count = fits.points.count(i);
      Eigen::Matrix<double, 5, 1> sum = Eigen::Matrix<double, 5, 1>::Zero();
      for (Index m = 1; m < count; ++m) {
        const double root = fits.bases[i].root[m - 1];
        const auto q = fits.bases[i].q.row(m - 1);
        own[first + m] = root * root * (1.0 - q.squaredNorm());
        own[first] += root * root;
        sum += root * q.transpose();
        turns[i] += plate_.normals[i].cross(plate_.normals[fits.points.items[first + m]]).squaredNorm() / (count - 1);
      }
      own[first] -= sum.squaredNorm();
    }
  });
  diagonal_.assign(n, 1.0);
  shift_.assign(n, 0.0);
  for (Index j = 0; j < n; ++j) {
    if (!is_unknown_[j]) continue;
    diagonal_[j] = 0.0;
    for (const Index* item = users_.begin(j); item != users_.end(j); ++item) {
      const Index i = fit_of_[*item];
      diagonal_[j] += scale_[i] * own[*item];
      shift_[j] += scale_[i] * own[*item] * (kShift + kCurvedShift * turns[i]);
    }
  }
}

void MomentBalance::gather(const Tensors& pushed, Tensors& sums) const {
  parallelFor(size(), kBlock, [&](Index begin, Index end) {
    for (Index j = begin; j < end; ++j) {
      sums[j] = Tensor::Zero();
      if (!is_unknown_[j]) continue;
      for (const Index* item = users_.begin(j); item != users_.end(j); ++item)
        sums[j] += turns_[*item].applyInverse(pushed[*item]);
    }
  });
}

void MomentBalance::explain(Index i, const Tensors& l, Tensor* change) const {
  const Index begin = fits_.points.offsets[i], count = fits_.points.count(i);
  const CurvatureFits::Basis& basis = fits_.bases[i];
  const bool on_clamp = clamped_.isEdge(i);
  Eigen::Matrix<double, CurvatureBending::kFitPoints, 3> d;
  for (Index m = 1; m < count; ++m) {
    const Index item = begin + m;
    d.row(m - 1) = basis.root[m - 1] * (turns_[item].apply(l[fits_.points.items[item]]) - l[i]).transpose();
  }
  d.bottomRows(CurvatureBending::kFitPoints + 1 - count).setZero();
  const Eigen::Matrix<double, 5, 3> explained = basis.q.transpose().lazyProduct(d);
  d -= basis.q.lazyProduct(explained);
  change[0] = Tensor::Zero();
  Eigen::Matrix<double, 2, 3> slope = Eigen::Matrix<double, 2, 3>::Zero();
  for (Index m = 1; m < count; ++m) {
    change[m] = basis.root[m - 1] * d.row(m - 1).transpose();
    change[0] -= change[m];
    if (on_clamp) slope += placeOf(i, begin + m) * change[m].transpose();
  }
  // Adds the slope of the points that the edge follows to the places of the others. They have no multipliers.
  if (on_clamp)
    for (Index m = 0; m < count; ++m) change[m] -= slope.transpose() * fits_.rows[begin + m].first;
}

void MomentBalance::multiply(const Tensors& l, Tensors& product) const {
  parallelFor(size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (scale_[i] == 0.0) continue;
      Tensor* change = &pushed_[fits_.points.offsets[i]];
      explain(i, l, change);
      for (Index m = 0; m < fits_.points.count(i); ++m) change[m] *= scale_[i];
    }
  });
  gather(pushed_, product);
  for (Index j = 0; j < size(); ++j) product[j] += shift_[j] * l[j];
}

void MomentBalance::findResidual(Tensors& residual) const {
  // The outward normals of free edges, times half the lengths at each point. They sum to zero inside.
  Points outward(size(), Vec3::Zero());
  for (const WeightedTriangle& t : plate_.triangles) {
    const Points& x = plate_.points;
    const Vec3 area = (x[t.corner[1]] - x[t.corner[0]]).cross(x[t.corner[2]] - x[t.corner[0]]);
    if (!(area.norm() > 0.0) || !fits_.has(t.corner[0]) || !fits_.has(t.corner[1]) || !fits_.has(t.corner[2])) continue;
    for (int c = 0; c < 3; ++c)
      outward[t.corner[c]] += 0.5 * t.weight * area.normalized().cross(x[t.corner[(c + 2) % 3]] - x[t.corner[(c + 1) % 3]]);
  }
  parallelFor(size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const bool is_free = !clamped_.isClamped(i);
      const Vec2 o(outward[i].dot(axes_[i].first), outward[i].dot(axes_[i].second));
      for (Index item = fits_.points.offsets[i]; item < fits_.points.offsets[i + 1]; ++item) {
        const Vec3& c = fits_.rows[item].second;
        const Vec2 g = fits_.rows[item].first;
        pushed_[item] = -areas_[i] * toTensor(c[0], c[1], c[2]);
        if (is_free) pushed_[item] += toTensor(o[0] * g[0], 0.5 * (o[0] * g[1] + o[1] * g[0]), o[1] * g[1]);
      }
    }
  });
  gather(pushed_, residual);
}

// The equation as on a plane, where each number of a tensor has the same matrix: exact there, an approximation elsewhere.
class PlanarBalance {
 public:
  /// For many points only the diagonal is used.
  explicit PlanarBalance(const MomentBalance& balance);
  void solve(const Tensors& b, Tensors& x);

 private:
  static constexpr Index kSlots = CurvatureBending::kFitPoints + 1;
  using Weights = Eigen::Matrix<double, 5, kSlots>;

  /// Of two different points.
  double entry(Index i, Index s, Index r) const;
  void factorize();

  const MomentBalance& balance_;
  // With p = root q, entry (s, r) of a fit is -p_s . p_r beside its diagonal. The point itself has minus the sum of the others.
  std::vector<Weights> weights_;  // (n) p
  BlockCholesky factor_;          // of groups of three points, for the fast blocks of three
  bool is_factored_ = false;
  Eigen::Matrix<double, Eigen::Dynamic, 6> in_space_;
  Eigen::VectorXd column_;
};

PlanarBalance::PlanarBalance(const MomentBalance& balance) : balance_(balance) {
  const CurvatureFits& fits = balance.fits();
  const Index n = balance.size();
  weights_.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      weights_[i].setZero();
      for (Index m = 1; m < fits.points.count(i); ++m) {
        const double root = fits.bases[i].root[m - 1];
        weights_[i].col(m) = root * fits.bases[i].q.row(m - 1).transpose();
        weights_[i].col(0) -= weights_[i].col(m);
      }
    }
  });
  if (n <= kMaxFactored) factorize();
}

double PlanarBalance::entry(Index i, Index s, Index r) const {
  const double both = -weights_[i].col(s).dot(weights_[i].col(r));
  const std::array<double, CurvatureBending::kFitPoints>& roots = balance_.fits().bases[i].root;
  if (s != 0 && r != 0) return both;
  const double root = roots[std::max(s, r) - 1];
  return both - root * root;
}

void PlanarBalance::factorize() {
  const CurvatureFits& fits = balance_.fits();
  const Index n = balance_.size(), num_blocks = (n + 2) / 3;
  struct Block {
    Index row;
    Mat3 value;
  };
  std::vector<std::vector<Block>> columns(num_blocks);
  parallelFor(num_blocks, kBlock, [&](Index begin, Index end) {
    std::vector<Index> place(num_blocks, -1);  // of a block in the column
    for (Index c = begin; c < end; ++c) {
      std::vector<Block>& column = columns[c];
      column.push_back({c, Mat3::Identity()});  // of places without an unknown
      place[c] = 0;
      for (Index k = 3 * c; k < std::min(3 * c + 3, n); ++k) {
        if (!balance_.isUnknown(k)) continue;
        column[0].value(k % 3, k % 3) = balance_.diagonal(k) + balance_.shift(k);
        for (const Index* item = balance_.users().begin(k); item != balance_.users().end(k); ++item) {
          const Index i = balance_.fitOf(*item), first = fits.points.offsets[i], s = *item - first;
          for (Index r = 0; r < fits.points.count(i); ++r) {
            const Index j = fits.points.items[first + r], row = j / 3;
            if (row < c || j == k || !balance_.isUnknown(j)) continue;
            if (place[row] < 0) {
              place[row] = static_cast<Index>(column.size());
              column.push_back({row, Mat3::Zero()});
            }
            column[place[row]].value(j % 3, k % 3) += balance_.scale(i) * entry(i, s, r);
          }
        }
      }
      for (const Block& block : column) place[block.row] = -1;
      std::sort(column.begin(), column.end(), [](const Block& a, const Block& b) { return a.row < b.row; });
    }
  });
  Lists pattern;
  std::vector<Mat3> values;
  for (const std::vector<Block>& column : columns) {
    for (const Block& block : column) {
      pattern.items.push_back(block.row);
      values.push_back(block.value);
    }
    pattern.offsets.push_back(static_cast<Index>(pattern.items.size()));
  }
  factor_.analyze(pattern);
  is_factored_ = factor_.factorize(values);
}

// Solves for a tensor of a tangent plane as one in space, with six numbers, and converts back.
void PlanarBalance::solve(const Tensors& b, Tensors& x) {
  const Index n = balance_.size();
  if (!is_factored_) {
    for (Index i = 0; i < n; ++i) x[i] = b[i] / balance_.diagonal(i);
    return;
  }
  in_space_.setZero((n + 2) / 3 * 3, 6);
  for (Index i = 0; i < n; ++i) {
    const Vec3 &u = balance_.axes(i).first, &v = balance_.axes(i).second;
    const Mat3 m = (b[i][0] + b[i][1]) * u * u.transpose() + (b[i][0] - b[i][1]) * v * v.transpose() +
                   b[i][2] * (u * v.transpose() + v * u.transpose());
    in_space_.row(i) << m(0, 0), m(1, 1), m(2, 2), m(1, 2), m(2, 0), m(0, 1);
  }
  for (int k = 0; k < 6; ++k) {
    if (in_space_.col(k).isZero(0.0)) continue;  // as three are of a plane across an axis
    column_ = in_space_.col(k);
    factor_.solveInPlace(column_);
    in_space_.col(k) = column_;
  }
  for (Index i = 0; i < n; ++i) {
    if (!balance_.isUnknown(i)) {
      x[i] = Tensor::Zero();
      continue;
    }
    const Vec3 &u = balance_.axes(i).first, &v = balance_.axes(i).second;
    const auto s = in_space_.row(i);
    Mat3 m;
    m << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
    x[i] = toTensor(u.dot(m * u), u.dot(m * v), v.dot(m * v));
  }
}

// Conjugate gradients from a guess; leaves the best iterate in it.
void solveForMultipliers(const MomentBalance& balance, Tensors& best) {
  const Index n = balance.size();
  Tensors residual(n), direction(n), solved(n), product(n), l = best;
  balance.findResidual(residual);
  const double limit = kTolerance * kTolerance * dot(residual, residual);
  if (!(limit > 0.0)) return;
  if (std::any_of(l.begin(), l.end(), [](const Tensor& tensor) { return !tensor.isZero(0.0); })) {
    balance.multiply(l, product);
    add(-1.0, product, residual);
  }
  const double first = dot(residual, residual);
  if (first <= limit) return;
  PlanarBalance planar(balance);
  planar.solve(residual, solved);
  direction = solved;
  double power = dot(residual, solved), least = first;
  for (int k = 0; k < kMaxIterations; ++k) {
    balance.multiply(direction, product);
    const double curvature = dot(direction, product);
    if (!(curvature > 0.0) || !(power > 0.0)) break;
    add(power / curvature, direction, l);
    add(-power / curvature, product, residual);
    const double squares = dot(residual, residual);
    if (squares < least) {
      least = squares;
      best = l;
    }
    if (least <= limit) break;
    planar.solve(residual, solved);
    const double before = power;
    power = dot(residual, solved);
    for (Index i = 0; i < n; ++i) direction[i] = solved[i] + power / before * direction[i];
  }
}

}  // namespace

std::vector<CurvatureRow> balanceMoments(const ClampedPlate& clamped, const std::vector<double>& areas, const CurvatureFits& fits,
                                         const std::vector<char>& is_fixed, Multipliers& multipliers) {
  const MomentBalance balance(clamped, areas, fits, is_fixed);
  solveForMultipliers(balance, multipliers);
  std::vector<CurvatureRow> rows = fits.rows;
  parallelFor(fits.points.size(), kBlock, [&](Index begin, Index end) {
    Tensor change[CurvatureBending::kFitPoints + 1];
    for (Index i = begin; i < end; ++i) {
      if (balance.scale(i) == 0.0) continue;
      balance.explain(i, multipliers, change);
      for (Index m = 0; m < fits.points.count(i); ++m)
        rows[fits.points.offsets[i] + m].second +=
            Vec3(change[m][0] + change[m][1], change[m][2], change[m][0] - change[m][1]) / (fits.reach[i] * fits.reach[i]);
    }
  });
  return rows;
}

}  // namespace deformable_surface::model
