#include "deformable_surface/linear/scalar_cholesky.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/linear/fill_reducing_order.h"

#include <Eigen/SparseCore>

#include <algorithm>

namespace deformable_surface {
namespace {

// A number for each of the four columns: the same one, or another for the last.
struct Same {
  const double* numbers;
  DEFORMABLE_SURFACE_INLINE void get(Index k, Double4& to) const { to = Double4{} + numbers[k]; }
};
struct LastApart {
  const double *numbers, *of_last;
  DEFORMABLE_SURFACE_INLINE void get(Index k, Double4& to) const { to = Double4{numbers[k], numbers[k], numbers[k], of_last[k]}; }
};

// A factor as it is read.
struct Columns {
  Index n;
  const Index *starts, *rows;
  const char* is_paired;  // with the next column
};

DEFORMABLE_SURFACE_INLINE double* at(double* work, Index row) { return work + 4 * static_cast<std::ptrdiff_t>(row); }

// work = (L D L^T)^-1 work, four numbers a row. Of a pair of columns each row is read and written once for both.
template <class Numbers>
DEFORMABLE_SURFACE_INLINE void substituteRows(const Columns& l, const Numbers& factor, const Numbers& inverse, double* work) {
  Double4 x{}, x_next{}, y{}, f{}, g{};
  for (Index j = 0; j < l.n; ++j) {
    load(at(work, j), x);
    Index k = l.starts[j];
    if (l.is_paired[j]) {
      factor.get(k, f);
      load(at(work, j + 1), x_next);
      x_next -= f * x;
      store(x_next, at(work, j + 1));
      Index next = l.starts[j + 1];
      for (++k; k < l.starts[j + 1]; ++k, ++next) {
        factor.get(k, f);
        factor.get(next, g);
        load(at(work, l.rows[k]), y);
        y -= f * x;
        store(y - g * x_next, at(work, l.rows[k]));
      }
      ++j;
    } else {
      for (; k < l.starts[j + 1]; ++k) {
        factor.get(k, f);
        load(at(work, l.rows[k]), y);
        store(y - f * x, at(work, l.rows[k]));
      }
    }
  }
  for (Index j = l.n - 1; j >= 0; --j) {
    Double4 sum{}, sum_next{};
    const bool is_pair = j > 0 && l.is_paired[j - 1];
    if (is_pair) {
      --j;
      for (Index k = l.starts[j] + 1, next = l.starts[j + 1]; k < l.starts[j + 1]; ++k, ++next) {
        factor.get(k, f);
        factor.get(next, g);
        load(at(work, l.rows[k]), y);
        sum += f * y;
        sum_next += g * y;
      }
      load(at(work, j + 1), x);
      inverse.get(j + 1, g);
      x = x * g - sum_next;
      store(x, at(work, j + 1));
      factor.get(l.starts[j], f);
      sum += f * x;
    } else {
      for (Index k = l.starts[j]; k < l.starts[j + 1]; ++k) {
        factor.get(k, f);
        load(at(work, l.rows[k]), y);
        sum += f * y;
      }
    }
    load(at(work, j), x);
    inverse.get(j, g);
    store(x * g - sum, at(work, j));
  }
}

DEFORMABLE_SURFACE_WIDE void substitute(const Columns& l, const double* factor, const double* inverse, double* work) {
  substituteRows(l, Same{factor}, Same{inverse}, work);
}

DEFORMABLE_SURFACE_WIDE void substituteTwo(const Columns& l, const double* factor, const double* inverse,
                                           const double* last_factor, const double* last_inverse, double* work) {
  substituteRows(l, LastApart{factor, last_factor}, LastApart{inverse, last_inverse}, work);
}

// The same, one number a row.
void substituteOne(Index n, const Index* starts, const Index* rows, const double* factor, const double* inverse, double* work) {
  for (Index j = 0; j < n; ++j)
    for (Index k = starts[j]; k < starts[j + 1]; ++k) work[rows[k]] -= factor[k] * work[j];
  for (Index j = n - 1; j >= 0; --j) {
    double sum = 0.0;
    for (Index k = starts[j]; k < starts[j + 1]; ++k) sum += factor[k] * work[rows[k]];
    work[j] = work[j] * inverse[j] - sum;
  }
}

constexpr Index kLook = 64;  // rows between two looks at an interrupt: each costs at most as many products as the factor is wide

}  // namespace

void ScalarCholesky::analyze(Index n, const std::vector<std::pair<Index, Index>>& pairs) {
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(n + pairs.size());
  for (Index i = 0; i < n; ++i) entries.emplace_back(i, i, 1.0);  // without a diagonal Eigen changes no order
  for (const auto& [i, j] : pairs) entries.emplace_back(std::max(i, j), std::min(i, j), 1.0);
  Eigen::SparseMatrix<double, Eigen::ColMajor, int> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  from_ = findFillReducingOrder(std::move(matrix));
  position_.resize(n);
  for (Index k = 0; k < n; ++k) position_[from_[k]] = k;

  // The part above the diagonal by columns.
  offsets_.assign(n + 1, 0);
  const auto columnOf = [&](const std::pair<Index, Index>& pair) {
    return std::max(position_[pair.first], position_[pair.second]);
  };
  for (const auto& pair : pairs) ++offsets_[columnOf(pair) + 1];
  for (Index k = 0; k < n; ++k) offsets_[k + 1] += offsets_[k];
  rows_.resize(pairs.size());
  source_.resize(pairs.size());
  filled_.assign(offsets_.begin(), offsets_.end() - 1);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    Index& at = filled_[columnOf(pairs[p])];
    rows_[at] = std::min(position_[pairs[p].first], position_[pairs[p].second]);
    source_[at++] = static_cast<Index>(p);
  }

  // Row k of L has an entry in every column on the ways from the entries of column k up the tree.
  parent_.assign(n, -1);
  flag_.assign(n, -1);
  starts_.assign(n + 1, 0);
  for (Index k = 0; k < n; ++k) {
    flag_[k] = k;
    for (Index p = offsets_[k]; p < offsets_[k + 1]; ++p)
      for (Index i = rows_[p]; flag_[i] != k; i = parent_[i]) {
        if (parent_[i] < 0) parent_[i] = k;
        ++starts_[i + 1];
        flag_[i] = k;
      }
  }
  for (Index k = 0; k < n; ++k) starts_[k + 1] += starts_[k];
  // A column whose parent is the next and that has but one row more has the same rows below it.
  is_paired_.assign(n, 0);
  for (Index k = 0; k + 1 < n; ++k)
    is_paired_[k] = !(k > 0 && is_paired_[k - 1]) && parent_[k] == k + 1 &&
                    starts_[k + 1] - starts_[k] == starts_[k + 2] - starts_[k + 1] + 1;
  factor_.resize(starts_[n]);
  factor_rows_.resize(starts_[n]);
  inverse_.resize(n);
  row_.assign(n, 0.0);
  stack_.resize(n);
  work_.assign(4 * static_cast<std::size_t>(n), 0.0);
}

bool ScalarCholesky::factorize(const std::vector<double>& diagonal, const std::vector<double>& values) {
  const Index n = static_cast<Index>(diagonal.size());
  std::copy(starts_.begin(), starts_.end() - 1, filled_.begin());
  std::fill(flag_.begin(), flag_.end(), -1);
  std::fill(row_.begin(), row_.end(), 0.0);  // where the last one ended early it left numbers
  for (Index k = 0; k < n; ++k) {
    endIfInterrupted(k, kLook);
    // The columns of row k, each after those that it depends on: from the end of the stack.
    Index top = n;
    flag_[k] = k;
    for (Index p = offsets_[k]; p < offsets_[k + 1]; ++p) {
      row_[rows_[p]] += values[source_[p]];
      Index length = 0;
      for (Index i = rows_[p]; flag_[i] != k; i = parent_[i]) {
        stack_[length++] = i;
        flag_[i] = k;
      }
      while (length > 0) stack_[--top] = stack_[--length];
    }
    double d = diagonal[from_[k]];
    for (; top < n; ++top) {
      const Index i = stack_[top];
      const double y = row_[i], l = y * inverse_[i];
      row_[i] = 0.0;
      for (Index p = starts_[i]; p < filled_[i]; ++p) row_[factor_rows_[p]] -= factor_[p] * y;
      d -= l * y;
      factor_rows_[filled_[i]] = k;
      factor_[filled_[i]++] = l;
    }
    if (!(d > 0.0)) return false;
    inverse_[k] = 1.0 / d;
  }
  return true;
}

void ScalarCholesky::solve(const Points& b, Points& x) {
  const Index n = static_cast<Index>(from_.size());
  for (Index k = 0; k < n; ++k) {
    std::copy_n(b[from_[k]].data(), 3, at(work_.data(), k));
    at(work_.data(), k)[3] = 0.0;  // solveWith() leaves numbers
  }
  substitute({n, starts_.data(), factor_rows_.data(), is_paired_.data()}, factor_.data(), inverse_.data(), work_.data());
  x.resize(n);
  for (Index k = 0; k < n; ++k)
    for (int c = 0; c < 3; ++c) x[from_[k]][c] = work_[4 * static_cast<std::size_t>(k) + c];
}

void ScalarCholesky::solve(const std::vector<double>& b, std::vector<double>& x) {
  const Index n = static_cast<Index>(from_.size());
  for (Index k = 0; k < n; ++k) work_[k] = b[from_[k]];
  substituteOne(n, starts_.data(), factor_rows_.data(), factor_.data(), inverse_.data(), work_.data());
  x.resize(n);
  for (Index k = 0; k < n; ++k) x[from_[k]] = work_[k];
}

void ScalarCholesky::solveWith(const ScalarCholesky& of_last, std::vector<double>& rows) {
  const Index n = static_cast<Index>(from_.size());
  for (Index k = 0; k < n; ++k) std::copy_n(at(rows.data(), from_[k]), 4, at(work_.data(), k));
  substituteTwo({n, starts_.data(), factor_rows_.data(), is_paired_.data()}, factor_.data(), inverse_.data(),
                of_last.factor_.data(), of_last.inverse_.data(), work_.data());
  for (Index k = 0; k < n; ++k) std::copy_n(at(work_.data(), k), 4, at(rows.data(), from_[k]));
}

}  // namespace deformable_surface
