#include "deformable_surface/base/scalar_cholesky.h"

#include "deformable_surface/base/simd.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>

namespace deformable_surface {
namespace {

// work = (L D L^T)^-1 work, four numbers a row.
DEFORMABLE_SURFACE_WIDE void substitute(Index n, const Index* starts, const Index* rows, const double* factor,
                                        const double* inverse, double* work) {
  for (Index j = 0; j < n; ++j) {
    Double4 x, y;
    load(work + 4 * static_cast<std::ptrdiff_t>(j), x);
    for (Index k = starts[j]; k < starts[j + 1]; ++k) {
      double* to = work + 4 * static_cast<std::ptrdiff_t>(rows[k]);
      load(to, y);
      store(y - factor[k] * x, to);
    }
  }
  for (Index j = n - 1; j >= 0; --j) {
    Double4 x, y, sum{};
    load(work + 4 * static_cast<std::ptrdiff_t>(j), x);
    for (Index k = starts[j]; k < starts[j + 1]; ++k) {
      load(work + 4 * static_cast<std::ptrdiff_t>(rows[k]), y);
      sum += factor[k] * y;
    }
    store(x * inverse[j] - sum, work + 4 * static_cast<std::ptrdiff_t>(j));
  }
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

}  // namespace

void ScalarCholesky::analyze(Index n, const std::vector<std::pair<Index, Index>>& pairs) {
  std::vector<Eigen::Triplet<double, int>> entries;
  for (const auto& [i, j] : pairs) {
    entries.emplace_back(i, j, 1.0);
    entries.emplace_back(j, i, 1.0);
  }
  Eigen::SparseMatrix<double, Eigen::ColMajor, int> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(matrix, permutation);
  from_.assign(permutation.indices().data(), permutation.indices().data() + n);
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
  for (Index k = 0; k < n; ++k) {
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
    if (!(d > 0.0)) {
      std::fill(row_.begin(), row_.end(), 0.0);
      return false;
    }
    inverse_[k] = 1.0 / d;
  }
  return true;
}

void ScalarCholesky::solve(const Points& b, Points& x) {
  const Index n = static_cast<Index>(from_.size());
  for (Index k = 0; k < n; ++k)
    for (int c = 0; c < 3; ++c) work_[4 * static_cast<std::size_t>(k) + c] = b[from_[k]][c];
  substitute(n, starts_.data(), factor_rows_.data(), factor_.data(), inverse_.data(), work_.data());
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

}  // namespace deformable_surface
