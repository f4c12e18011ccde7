#include "deformable_surface/linear/multigrid.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>

namespace deformable_surface {
namespace {

constexpr Index kBlock = 512;       // points a task
constexpr Index kFewest = 200;      // points that are solved for directly: their factor costs less than a sweep of thousands
constexpr double kDamping = 0.7;    // of a sweep: eigenvalues over the diagonal reach two
constexpr double kOvershoot = 1.6;  // of the next level's correction: constants on aggregates are too stiff

struct Rows {
  const Index *offsets, *columns;
  const double *values, *diagonal, *inverse, *share;
};

// Residual of b after a sweep from zero, summed over the members of aggregates [begin, end).
DEFORMABLE_SURFACE_WIDE void restrictResidual(Index begin, Index end, const Rows& a, const Index* first_member,
                                              const Index* members, const double* b, double* to) {
  for (Index g = begin; g < end; ++g) {
    Double4 sum{};
    for (Index m = first_member[g]; m < first_member[g + 1]; ++m) {
      const Index i = members[m];
      Double4 here, other, rest{};
      load(b + 4 * static_cast<std::ptrdiff_t>(i), here);
      for (Index k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
        const Index j = a.columns[k];
        load(b + 4 * static_cast<std::ptrdiff_t>(j), other);
        rest += a.values[k] * a.inverse[j] * other;
      }
      sum += a.share[i] * ((1.0 - kDamping) * here - kDamping * rest);
    }
    store(sum, to + 4 * static_cast<std::ptrdiff_t>(g));
  }
}

// A sweep from zero, plus the correction of the next level.
DEFORMABLE_SURFACE_WIDE void correct(Index begin, Index end, const Rows& a, const Index* aggregate, const double* b,
                                     const double* next, double* start) {
  for (Index i = begin; i < end; ++i) {
    Double4 here, added;
    load(b + 4 * static_cast<std::ptrdiff_t>(i), here);
    load(next + 4 * static_cast<std::ptrdiff_t>(aggregate[i]), added);
    store(kDamping * a.inverse[i] * here + kOvershoot * a.share[i] * added, start + 4 * static_cast<std::ptrdiff_t>(i));
  }
}

DEFORMABLE_SURFACE_WIDE void sweep(Index begin, Index end, const Rows& a, const double* b, const double* start, double* x) {
  for (Index i = begin; i < end; ++i) {
    Double4 rest, here, other;
    load(b + 4 * static_cast<std::ptrdiff_t>(i), rest);
    load(start + 4 * static_cast<std::ptrdiff_t>(i), here);
    rest -= a.diagonal[i] * here;
    for (Index k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      load(start + 4 * static_cast<std::ptrdiff_t>(a.columns[k]), other);
      rest -= a.values[k] * other;
    }
    store(here + kDamping * a.inverse[i] * rest, x + 4 * static_cast<std::ptrdiff_t>(i));
  }
}

}  // namespace

void Multigrid::makeRows(Level& level) {
  const Index n = level.n;
  level.offsets.assign(n + 1, 0);
  for (const auto& [i, j] : level.pairs) {
    ++level.offsets[i + 1];
    ++level.offsets[j + 1];
  }
  for (Index i = 0; i < n; ++i) level.offsets[i + 1] += level.offsets[i];
  level.columns.resize(level.offsets[n]);
  level.sources.resize(level.offsets[n]);
  std::vector<Index> filled(level.offsets.begin(), level.offsets.end() - 1);
  for (std::size_t p = 0; p < level.pairs.size(); ++p)
    for (const auto& [from, to] : {level.pairs[p], std::make_pair(level.pairs[p].second, level.pairs[p].first)}) {
      level.columns[filled[from]] = to;
      level.sources[filled[from]++] = static_cast<Index>(p);
    }
  level.values.resize(level.columns.size());
  level.diagonal.resize(n);
  level.inverse.resize(n);
  level.share.resize(n);
  level.of_pairs.resize(level.pairs.size());
  level.b.assign(4 * static_cast<std::size_t>(n), 0.0);
  level.x = level.start = level.b;
}

// Aggregates: a point and its neighbours, if none of them is taken yet; remaining points join a neighbour's aggregate.
void Multigrid::aggregate(Level& level, Level& next) {
  const Index n = level.n;
  level.aggregate.assign(n, -1);
  const auto begin = [&](Index i) { return level.columns.begin() + level.offsets[i]; };
  const auto end = [&](Index i) { return level.columns.begin() + level.offsets[i + 1]; };
  const auto isTaken = [&](Index i) { return level.aggregate[i] >= 0; };
  next.n = 0;
  for (Index i = 0; i < n; ++i) {
    if (isTaken(i) || std::any_of(begin(i), end(i), isTaken)) continue;
    level.aggregate[i] = next.n;
    for (auto j = begin(i); j != end(i); ++j) level.aggregate[*j] = next.n;
    ++next.n;
  }
  const std::vector<Index> first = level.aggregate;
  for (Index i = 0; i < n; ++i) {
    if (isTaken(i)) continue;
    const auto j = std::find_if(begin(i), end(i), [&](Index other) { return first[other] >= 0; });
    level.aggregate[i] = j != end(i) ? first[*j] : next.n++;
  }

  level.first_member.assign(next.n + 1, 0);
  for (Index i = 0; i < n; ++i) ++level.first_member[level.aggregate[i] + 1];
  for (Index g = 0; g < next.n; ++g) level.first_member[g + 1] += level.first_member[g];
  level.members.resize(n);
  std::vector<Index> filled(level.first_member.begin(), level.first_member.end() - 1);
  for (Index i = 0; i < n; ++i) level.members[filled[level.aggregate[i]]++] = i;

  // Pairs of aggregates, ascending, once each.
  const auto pairOf = [&](const std::pair<Index, Index>& pair) {
    return std::minmax({level.aggregate[pair.first], level.aggregate[pair.second]});
  };
  next.pairs.clear();
  for (const auto& pair : level.pairs)
    if (const std::pair<Index, Index> between = pairOf(pair); between.first != between.second) next.pairs.push_back(between);
  std::sort(next.pairs.begin(), next.pairs.end());
  next.pairs.erase(std::unique(next.pairs.begin(), next.pairs.end()), next.pairs.end());
  level.next_pair.clear();
  for (const auto& pair : level.pairs) {
    const std::pair<Index, Index> between = pairOf(pair);
    const auto at = std::lower_bound(next.pairs.begin(), next.pairs.end(), between);
    level.next_pair.push_back(between.first == between.second ? -1 : static_cast<Index>(at - next.pairs.begin()));
  }
}

void Multigrid::analyze(Index n, const std::vector<std::pair<Index, Index>>& pairs) {
  levels_.clear();
  last_ = Level();
  last_.n = n;
  last_.pairs = pairs;
  makeRows(last_);
  while (last_.n > kFewest) {
    Level next;
    aggregate(last_, next);
    if (next.n == last_.n) break;  // no pairs are left
    makeRows(next);
    levels_.push_back(std::move(last_));
    last_ = std::move(next);
  }
  factor_.analyze(last_.n, last_.pairs);
  last_b_.resize(last_.n);
  last_x_.resize(last_.n);
}

void Multigrid::setValues(const std::vector<double>& diagonal, const std::vector<double>& values) {
  Level& finest = levels_.empty() ? last_ : levels_.front();
  finest.diagonal = diagonal;
  finest.of_pairs = values;
  for (std::size_t l = 0; l < levels_.size(); ++l) setLevel(l);
  factor_.factorize(last_.diagonal, last_.of_pairs);  // diagonally dominant as the first: it cannot fail
}

// Points without couplings are solved by the sweeps alone: they have no share in the next level.
void Multigrid::setLevel(std::size_t l) {
  Level& level = levels_[l];
  Level& next = l + 1 < levels_.size() ? levels_[l + 1] : last_;
  next.diagonal.assign(next.n, 0.0);
  next.of_pairs.assign(next.pairs.size(), 0.0);
  for (Index i = 0; i < level.n; ++i) {
    bool is_coupled = false;
    for (Index k = level.offsets[i]; k < level.offsets[i + 1]; ++k) {
      level.values[k] = level.of_pairs[level.sources[k]];
      is_coupled = is_coupled || level.values[k] != 0.0;
    }
    level.inverse[i] = 1.0 / level.diagonal[i];
    level.share[i] = is_coupled;
    if (is_coupled) next.diagonal[level.aggregate[i]] += level.diagonal[i];
  }
  for (std::size_t p = 0; p < level.pairs.size(); ++p) {
    if (level.next_pair[p] >= 0)
      next.of_pairs[level.next_pair[p]] += level.of_pairs[p];
    else
      next.diagonal[level.aggregate[level.pairs[p].first]] += 2.0 * level.of_pairs[p];
  }
  for (double& d : next.diagonal)
    if (!(d > 0.0)) d = 1.0;
}

void Multigrid::cycle(std::size_t l) {
  if (l == levels_.size()) {
    for (Index i = 0; i < last_.n; ++i) last_b_[i] = Eigen::Map<const Vec3>(last_.b.data() + 4 * static_cast<std::size_t>(i));
    factor_.solve(last_b_, last_x_);
    for (Index i = 0; i < last_.n; ++i) Eigen::Map<Vec3>(last_.x.data() + 4 * static_cast<std::size_t>(i)) = last_x_[i];
    return;
  }
  Level& level = levels_[l];
  Level& next = l + 1 < levels_.size() ? levels_[l + 1] : last_;
  const Rows rows{level.offsets.data(),  level.columns.data(), level.values.data(),
                  level.diagonal.data(), level.inverse.data(), level.share.data()};
  parallelFor(next.n, kBlock / 8, [&](Index begin, Index end) {
    restrictResidual(begin, end, rows, level.first_member.data(), level.members.data(), level.b.data(), next.b.data());
  });
  cycle(l + 1);
  parallelFor(level.n, kBlock, [&](Index begin, Index end) {
    correct(begin, end, rows, level.aggregate.data(), level.b.data(), next.x.data(), level.start.data());
  });
  parallelFor(level.n, kBlock,
              [&](Index begin, Index end) { sweep(begin, end, rows, level.b.data(), level.start.data(), level.x.data()); });
}

void Multigrid::apply(const Points& b, Points& x) {
  Level& finest = levels_.empty() ? last_ : levels_.front();
  for (Index i = 0; i < finest.n; ++i) Eigen::Map<Vec3>(finest.b.data() + 4 * static_cast<std::size_t>(i)) = b[i];
  cycle(0);
  x.resize(finest.n);
  for (Index i = 0; i < finest.n; ++i) x[i] = Eigen::Map<const Vec3>(finest.x.data() + 4 * static_cast<std::size_t>(i));
}

std::size_t Multigrid::size() const {
  std::size_t sum = last_.columns.size() + factor_.factorSize();
  for (const Level& level : levels_) sum += level.columns.size();
  return sum;
}

}  // namespace deformable_surface
