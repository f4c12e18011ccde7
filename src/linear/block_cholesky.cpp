#include "deformable_surface/linear/block_cholesky.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/linear/fill_reducing_order.h"

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

namespace deformable_surface {
namespace {

constexpr Index kMaxWidth = 16;  // blocks in a panel: its part that the products read stays in the nearest caches
constexpr Index kLook = 64;      // columns, or products of panels, between two looks at an interrupt
constexpr Index kPadding = 3;    // numbers that a tile reads beyond the last row of a panel

// How many zeros a panel may hold in exchange for its width: any in narrow ones, whose handling costs more than arithmetic.
bool isWorthMerging(Index width, double zeros, double size) { return width <= 4 || zeros <= (width <= 16 ? 0.3 : 0.1) * size; }

// tile (4 V x 3) = sum over p of a(:, p) b(:, p)^T, with the first 4 V rows of a and the first 3 of b.
template <int V>
DEFORMABLE_SURFACE_INLINE void multiplyTile(Index depth, const double* a, const double* b, Index stride, double* tile) {
  Double4 sum[3][V] = {};
  for (Index p = 0; p < depth; ++p, a += stride, b += stride)
    for (int v = 0; v < V; ++v) {
      Double4 x;
      std::memcpy(&x, a + 4 * v, sizeof x);
      for (int c = 0; c < 3; ++c) sum[c][v] += x * b[c];
    }
  for (int c = 0; c < 3; ++c) std::memcpy(tile + 12 * c, sum[c], sizeof sum[c]);
}

// target -= a b^T on and below the diagonal, where a are num_rows block rows of a panel with `depth` columns and b the first
// num_columns of them. Block row r goes to block row target_rows[r] of the target, and so do the columns.
DEFORMABLE_SURFACE_WIDE void subtractProduct(Index depth, const double* a, Index stride, Index num_rows, Index num_columns,
                                             const Index* target_rows, double* target, Index target_stride) {
  alignas(32) double tile[3 * 12];
  for (Index j = 0; j < num_columns; ++j) {
    double* column = target + 3 * static_cast<std::size_t>(target_rows[j]) * target_stride;
    for (Index i = j; i < num_rows; i += 4) {
      const Index blocks = std::min(num_rows - i, Index{4});
      if (blocks >= 3) {
        multiplyTile<3>(depth, a + 3 * i, a + 3 * j, stride, tile);
      } else if (blocks == 2) {
        multiplyTile<2>(depth, a + 3 * i, a + 3 * j, stride, tile);
      } else {
        multiplyTile<1>(depth, a + 3 * i, a + 3 * j, stride, tile);
      }
      for (Index r = 0; r < blocks; ++r) {
        double* block = column + 3 * target_rows[i + r];
        for (int c = 0; c < 3; ++c)
          for (int k = 0; k < 3; ++k) block[c * target_stride + k] -= tile[12 * c + 3 * r + k];
      }
    }
  }
}

// Three columns of a panel from their diagonal block on, all products subtracted: Cholesky's factor of the 3 x 3 block and what
// is below it divided by that. False if a pivot is not positive.
DEFORMABLE_SURFACE_WIDE bool divideColumns(Index size, double* first, Index stride) {
  double *x = first, *y = first + stride, *z = first + 2 * stride;
  if (!(x[0] > 0.0)) return false;
  const double xx = std::sqrt(x[0]), yx = x[1] / xx, zx = x[2] / xx;
  const double y2 = y[1] - yx * yx;
  if (!(y2 > 0.0)) return false;
  const double yy = std::sqrt(y2), zy = (y[2] - zx * yx) / yy;
  const double z2 = z[2] - zx * zx - zy * zy;
  if (!(z2 > 0.0)) return false;
  const double zz = std::sqrt(z2);
  x[0] = xx;
  x[1] = yx;
  x[2] = zx;
  y[1] = yy;
  y[2] = zy;
  z[2] = zz;
#pragma GCC ivdep
  for (Index r = 3; r < size; ++r) {
    x[r] /= xx;
    y[r] = (y[r] - yx * x[r]) / yy;
    z[r] = (z[r] - zx * x[r] - zy * y[r]) / zz;
  }
  return true;
}

// local = L^-1 local on the panel's own rows, and what they contribute subtracted from the rows below.
DEFORMABLE_SURFACE_WIDE void substituteForward(Index width, Index num_rows, const double* panel, Index stride, double* local) {
  for (Index c = 0; c < width; ++c, panel += stride) {
    const double x = local[c] /= panel[c];
#pragma GCC ivdep
    for (Index r = c + 1; r < num_rows; ++r) local[r] -= panel[r] * x;
  }
}

// local = L^-T local on the panel's own rows, from those below, which are solved already.
DEFORMABLE_SURFACE_WIDE void substituteBackward(Index width, Index num_rows, const double* panel, Index stride, double* local) {
  for (Index c = width - 1; c >= 0; --c) {
    const double* column = panel + static_cast<std::size_t>(c) * stride;
    Double4 sum = {};
    Index r = c + 1;
    for (; r + 4 <= num_rows; r += 4) {
      Double4 l, x;
      std::memcpy(&l, column + r, sizeof l);
      std::memcpy(&x, local + r, sizeof x);
      sum += l * x;
    }
    double rest = 0.0;
    for (; r < num_rows; ++r) rest += column[r] * local[r];
    local[c] = (local[c] - (sum[0] + sum[1] + sum[2] + sum[3] + rest)) / column[c];
  }
}

// Elimination tree of a permuted matrix [Liu 1990]: the parent of each column. upper: of each column its rows above the diagonal.
std::vector<Index> findTree(const Lists& upper) {
  std::vector<Index> parent(upper.size(), -1), ancestor(upper.size(), -1);
  for (Index j = 0; j < upper.size(); ++j)
    for (const Index* row = upper.begin(j); row != upper.end(j); ++row)
      for (Index i = *row; i != -1 && i < j;) {
        const Index next = std::exchange(ancestor[i], j);
        if (next == -1) parent[i] = j;
        i = next;
      }
  return parent;
}

// The place of each node of a tree such that subtrees are contiguous, each before its parent. Parents have larger numbers.
std::vector<Index> findPostorder(const std::vector<Index>& parent) {
  const Index n = static_cast<Index>(parent.size());
  std::vector<Index> size(n, 1), place(n), last(n);  // last: the place that the next subtree of a node ends before
  for (Index j = 0; j < n; ++j)
    if (parent[j] != -1) size[parent[j]] += size[j];
  Index end = n;
  for (Index j = n - 1; j >= 0; --j) {
    Index& before = parent[j] == -1 ? end : last[parent[j]];
    place[j] = last[j] = before - 1;
    before -= size[j];
  }
  return place;
}

// The other triangle of a permuted pattern: of each column its rows above the diagonal.
Lists permuteToUpper(const Lists& pattern, const std::vector<Index>& position) {
  Lists upper;
  upper.offsets.assign(pattern.size() + 1, 0);
  const auto forEach = [&](const auto& act) {
    for (Index column = 0; column < pattern.size(); ++column)
      for (const Index* row = pattern.begin(column); row != pattern.end(column); ++row)
        if (*row != column) act(std::minmax(position[column], position[*row]));
  };
  forEach([&](const auto& ends) { ++upper.offsets[ends.second + 1]; });
  std::partial_sum(upper.offsets.begin(), upper.offsets.end(), upper.offsets.begin());
  upper.items.resize(upper.offsets.back());
  std::vector<Index> next(upper.offsets.begin(), upper.offsets.end() - 1);
  forEach([&](const auto& ends) { upper.items[next[ends.second]++] = ends.first; });
  return upper;
}

}  // namespace

void BlockCholesky::analyze(const Lists& pattern) {
  order(pattern);
  endIfInterrupted();
  findNodes();
  endIfInterrupted();
  findUpdates();
  endIfInterrupted();
  placeBlocks(pattern);
  below_ = {};
}

// The permutation, and of each column of L its parent and rows.
void BlockCholesky::order(const Lists& pattern) {
  const Index n = pattern.size();
  const std::vector<double> ones(pattern.items.size(), 1.0);
  const std::vector<Index> from = findFillReducingOrder(Eigen::Map<const Eigen::SparseMatrix<double>>(
      n, n, static_cast<Eigen::Index>(ones.size()), pattern.offsets.data(), pattern.items.data(), ones.data()));
  position_.resize(n);
  for (Index k = 0; k < n; ++k) position_[from[k]] = k;
  const std::vector<Index> place = findPostorder(findTree(permuteToUpper(pattern, position_)));
  for (Index& p : position_) p = place[p];

  endIfInterrupted();
  const Lists upper = permuteToUpper(pattern, position_);
  parent_ = findTree(upper);
  below_.assign(n, {});
  for (Index j = 0; j < n; ++j)
    for (const Index* i = upper.begin(j); i != upper.end(j); ++i) below_[*i].push_back(j);
  // A column has the rows of the matrix and those of its children; children come before.
  std::vector<Index> merged;
  for (Index j = 0; j < n; ++j) {
    endIfInterrupted(j, kLook);
    std::vector<Index>& rows = below_[j];
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (parent_[j] == -1) continue;
    std::vector<Index>& above = below_[parent_[j]];
    above.insert(above.end(), rows.begin() + 1, rows.end());
  }
}

// Supernodes: chains of columns whose rows are the same or nearly so, cut to the greatest width.
void BlockCholesky::findNodes() {
  const Index n = static_cast<Index>(parent_.size());
  struct Chain {
    Index begin, end;
    double zeros;  // blocks in the panel that are none of L
  };
  std::vector<Chain> chains;
  for (Index begin = 0; begin < n;) {
    Index end = begin + 1;
    while (end < n && parent_[end - 1] == end && below_[end - 1].size() == below_[end].size() + 1) ++end;
    Chain chain{begin, end, 0.0};
    begin = end;
    while (!chains.empty() && parent_[chains.back().end - 1] == chain.begin) {
      const Chain& child = chains.back();
      const double width = chain.end - child.begin, rows = static_cast<double>(below_[chain.end - 1].size());
      const double missing = chain.end - chain.begin + rows - static_cast<double>(below_[child.end - 1].size());
      const double zeros = chain.zeros + child.zeros + (child.end - child.begin) * missing;
      if (!isWorthMerging(chain.end - child.begin, zeros, width * (0.5 * (width + 1.0) + rows))) break;
      chain = {child.begin, chain.end, zeros};
      chains.pop_back();
    }
    chains.push_back(chain);
  }

  nodes_.clear();
  rows_.clear();
  node_of_column_.assign(n, 0);
  std::size_t size = 0;
  Index most_rows = 0;
  for (const Chain& chain : chains) {
    const Index pieces = (chain.end - chain.begin - 1) / kMaxWidth + 1;
    for (Index p = 0; p < pieces; ++p) {
      const Index length = chain.end - chain.begin;
      const Index begin = chain.begin + p * length / pieces, end = chain.begin + (p + 1) * length / pieces;
      for (Index c = begin; c < end; ++c) node_of_column_[c] = static_cast<Index>(nodes_.size());
      Node node{begin, end - begin, static_cast<Index>(rows_.size()), 0, 0, size};
      for (Index c = begin; c < chain.end; ++c) rows_.push_back(c);
      const std::vector<Index>& below = below_[chain.end - 1];
      rows_.insert(rows_.end(), below.begin(), below.end());
      node.num_rows = static_cast<Index>(rows_.size()) - node.rows;
      node.stride = 3 * node.num_rows + kPadding;
      size += 3 * static_cast<std::size_t>(node.width) * node.stride;
      most_rows = std::max(most_rows, node.num_rows);
      nodes_.push_back(node);
    }
  }
  factor_.assign(size, 0.0);
  row_in_panel_.assign(n, 0);
  target_rows_.assign(most_rows, 0);
  counting_.resize(most_rows);
  std::iota(counting_.begin(), counting_.end(), 0);
  permuted_.assign(3 * n, 0.0);
  local_.assign(3 * most_rows, 0.0);
}

void BlockCholesky::findUpdates() {
  std::vector<std::vector<Update>> due(nodes_.size());
  for (Index s = 0; s < static_cast<Index>(nodes_.size()); ++s) {
    const Node& node = nodes_[s];
    const Index* rows = &rows_[node.rows];
    for (Index begin = node.width; begin < node.num_rows;) {
      const Index target = node_of_column_[rows[begin]];
      Index end = begin + 1;
      while (end < node.num_rows && node_of_column_[rows[end]] == target) ++end;
      due[target].push_back({s, begin, end});
      begin = end;
    }
  }
  updates_.clear();
  update_offsets_.assign(1, 0);
  for (const std::vector<Update>& list : due) {
    updates_.insert(updates_.end(), list.begin(), list.end());
    update_offsets_.push_back(static_cast<Index>(updates_.size()));
  }
}

void BlockCholesky::placeBlocks(const Lists& pattern) {
  places_.clear();
  for (Index column = 0; column < pattern.size(); ++column)
    for (const Index* row = pattern.begin(column); row != pattern.end(column); ++row) {
      const bool transposed = position_[*row] < position_[column];
      const auto [c, r] = std::minmax(position_[column], position_[*row]);
      const Node& node = nodes_[node_of_column_[c]];
      const Index* first = &rows_[node.rows];
      const std::size_t at = std::lower_bound(first, first + node.num_rows, r) - first;
      const std::size_t left = 3 * static_cast<std::size_t>(c - node.first) * node.stride;
      places_.push_back({node.panel + left + 3 * at, node.stride, transposed});
    }
}

double BlockCholesky::factorWork() const {
  double work = 0.0;
  for (const Node& node : nodes_)
    for (Index c = 0; c < node.width; ++c) {
      const double rows = node.num_rows - c;
      work += 0.5 * 27.0 * rows * rows;
    }
  return work;
}

bool BlockCholesky::factorize(const std::vector<Mat3>& values) {
  std::fill(factor_.begin(), factor_.end(), 0.0);
  for (std::size_t k = 0; k < places_.size(); ++k) {
    double* block = &factor_[places_[k].at];
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) block[c * places_[k].stride + r] = places_[k].transposed ? values[k](c, r) : values[k](r, c);
  }
  for (std::size_t s = 0; s < nodes_.size(); ++s) {
    const Node& node = nodes_[s];
    double* panel = &factor_[node.panel];
    for (Index r = 0; r < node.num_rows; ++r) row_in_panel_[rows_[node.rows + r]] = r;
    endIfInterrupted();
    for (Index u = update_offsets_[s]; u < update_offsets_[s + 1]; ++u) {
      endIfInterrupted(u, kLook);
      const Update& update = updates_[u];
      const Node& source = nodes_[update.node];
      const Index num_rows = source.num_rows - update.begin;
      for (Index r = 0; r < num_rows; ++r) target_rows_[r] = row_in_panel_[rows_[source.rows + update.begin + r]];
      subtractProduct(3 * source.width, &factor_[source.panel + 3 * update.begin], source.stride, num_rows,
                      update.end - update.begin, target_rows_.data(), panel, node.stride);
    }
    for (Index c = 0; c < node.width; ++c) {
      subtractProduct(3 * c, panel + 3 * c, node.stride, node.num_rows - c, 1, &counting_[c], panel, node.stride);
      if (!divideColumns(3 * (node.num_rows - c), panel + 3 * c * (static_cast<std::size_t>(node.stride) + 1), node.stride))
        return false;
    }
  }
  return true;
}

void BlockCholesky::solveInPlace(Eigen::VectorXd& x) {
  endIfInterrupted();
  const Index n = static_cast<Index>(position_.size());
  for (Index i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) permuted_[3 * position_[i] + k] = x[3 * i + k];
  const auto gather = [&](const Node& node) {
    for (Index r = 0; r < node.num_rows; ++r)
      for (int k = 0; k < 3; ++k) local_[3 * r + k] = permuted_[3 * rows_[node.rows + r] + k];
  };
  const auto scatter = [&](const Node& node, Index count) {
    for (Index r = 0; r < count; ++r)
      for (int k = 0; k < 3; ++k) permuted_[3 * rows_[node.rows + r] + k] = local_[3 * r + k];
  };
  for (const Node& node : nodes_) {
    gather(node);
    substituteForward(3 * node.width, 3 * node.num_rows, &factor_[node.panel], node.stride, local_.data());
    scatter(node, node.num_rows);
  }
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    gather(*node);
    substituteBackward(3 * node->width, 3 * node->num_rows, &factor_[node->panel], node->stride, local_.data());
    scatter(*node, node->width);
  }
  for (Index i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) x[3 * i + k] = permuted_[3 * position_[i] + k];
}

}  // namespace deformable_surface
