#include "deformable_surface/model/oriented_particles/neighbor_list.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace deformable_surface::model {
namespace {

// The edge of the cells over the reach of the lists: more than one, so that rounding of quotients cannot hide a neighbour two
// cells away.
constexpr double kEdge = 1.001;
// Period of the cell numbers: they stay whole numbers however far a particle is. Two cells with one number are told apart by
// distance.
constexpr std::int64_t kPeriod = std::int64_t{1} << 53;
// Odd factors without a common pattern: lines of cells along x, which are read in one piece, are spread over the bins.
constexpr std::uint64_t kAlongY = 0x9E3779B97F4A7C15u, kAlongZ = 0xC2B2AE3D27D4EB4Fu;

std::uint64_t hashRow(std::int64_t y, std::int64_t z) {
  const std::uint64_t mixed = static_cast<std::uint64_t>(y) * kAlongY + static_cast<std::uint64_t>(z) * kAlongZ;
  return mixed >> 20;
}

// The remainder is costly, and only needed far out.
std::int64_t wrap(double quotient) {
  constexpr double kFar = static_cast<double>(kPeriod);
  const double cell = std::floor(quotient);
  return static_cast<std::int64_t>(std::abs(cell) < kFar ? cell : std::fmod(cell, kFar));
}

// Places in memory of four numbers each, x, y, z and what belongs to them: of begin .. end - 1, those within a distance of p are
// written to found, ascending. Returns their number; stops when there are more than `limit`. found: (limit + 4).
DEFORMABLE_SURFACE_WIDE
Index selectWithin(const double* places, Index begin, Index end, const double* p, double squared_distance, Index limit,
                   Index* found) {
  const Double4 most = Double4{0.0, 0.0, 0.0, 0.0} + squared_distance;
  Index count = 0, s = begin;
  for (; end - s >= 4 && count <= limit; s += 4) {
    const double* const rows = places + 4 * static_cast<std::ptrdiff_t>(s);
    Double4 x, y, z, other;
    load(rows, x);
    load(rows + 4, y);
    load(rows + 8, z);
    load(rows + 12, other);
    transpose(x, y, z, other);
    x -= p[0];
    y -= p[1];
    z -= p[2];
    const auto is_within = x * x + y * y + z * z <= most;  // -1 where it holds
    for (int k = 0; k < 4; ++k) {
      found[count] = s + k;
      count -= static_cast<Index>(is_within[k]);
    }
  }
  for (; s < end && count <= limit; ++s) {
    const double* const row = places + 4 * static_cast<std::ptrdiff_t>(s);
    const double x = row[0] - p[0], y = row[1] - p[1], z = row[2] - p[2];
    found[count] = s;
    count += x * x + y * y + z * z <= squared_distance;
  }
  return count;
}

// Eight whole numbers side by side.
using Index8 = Index __attribute__((vector_size(8 * sizeof(Index))));

// Sorts distinct numbers: each counts those below it. Short lists take less time so than by comparisons, whose branches cannot be
// foreseen. numbers: seven beyond the last are read, too.
DEFORMABLE_SURFACE_WIDE
void sortByCounting(Index count, const Index* numbers, Index* sorted) {
  const Index8 zero{};
  for (Index first = 0; first < count; first += 8) {
    Index8 eight, rank = zero;
    std::memcpy(&eight, numbers + first, sizeof eight);
    for (Index m = 0; m < count; ++m) rank -= (zero + numbers[m]) < eight;  // -1 where it holds
    for (Index k = 0; k < std::min(Index{8}, count - first); ++k) sorted[rank[k]] = numbers[first + k];
  }
}

}  // namespace

bool NeighborList::update(const Points& positions, const std::vector<ParticleTraits>& traits, const ParticleCuts& cuts) {
  bool is_finite = true;
  const bool has_approached = hasApproached(positions, is_finite);
  if (!is_finite) return is_valid_ = false;
  if (!has_approached) return true;
  is_valid_ = false;  // an interrupt may end the following work
  const Index n = static_cast<Index>(positions.size());
  cell_ = kEdge * (radius_ + skin_);
  begins_.resize(n);
  counts_.resize(n);
  blocks_.resize((n + kBlock - 1) / kBlock);
  parted_begins_.resize(cuts.isEmpty() ? 0 : n);
  parted_counts_.resize(parted_begins_.size());
  parted_.resize(cuts.isEmpty() ? 0 : blocks_.size());
  apart_begins_.resize(apart_.items.empty() ? 0 : n);
  apart_counts_.resize(apart_begins_.size());
  near_apart_.resize(apart_.items.empty() ? 0 : blocks_.size());
  sortIntoBins(positions);
  is_valid_ = listNeighbors(positions, traits, cuts);
  rebuilt_at_ = positions;
  tree_.renew(positions);
  ++num_rebuilds_;
  return is_valid_;
}

// Pairs approach each other by the difference of their displacements: a surface that moves as a whole needs no new lists.
bool NeighborList::hasApproached(const Points& positions, bool& is_finite) {
  const Index n = static_cast<Index>(positions.size()), num_blocks = (n + kBlock - 1) / kBlock;
  const bool same_number = positions.size() == rebuilt_at_.size();
  const Points& base = tree_.base() ? *tree_.base() : rebuilt_at_;  // of as many
  const double slack = tree_.slack(skin_);
  ranges_.resize(num_blocks);
  const auto extend = [](const Vec3& low, const Vec3& high, Range& range) {
    range.low = range.low.cwiseMin(low);
    range.high = range.high.cwiseMax(high);
  };
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Range& range = ranges_[begin / kBlock];
    range = {};
    for (Index i = begin; i < end; ++i) {
      if (!positions[i].allFinite()) range.is_finite = false;
      if (!same_number) continue;
      const Vec3 move = positions[i] - base[i];
      extend(move, move, range);
    }
  });
  Range all;
  for (const Range& range : ranges_) {
    all.is_finite = all.is_finite && range.is_finite;
    extend(range.low, range.high, all);
  }
  is_finite = all.is_finite;
  if (!is_finite || !same_number || !is_valid_) return true;
  if (n == 0 || (all.high - all.low).squaredNorm() <= slack * slack) return false;
  return !tree_.holds(rebuilt_at_, positions, {radius_, radius_ + skin_, skin_, apart_.items.empty()});
}

NeighborList::Cell NeighborList::cellOf(const Vec3& p) const {
  return {wrap(p.x() / cell_), wrap(p.y() / cell_), wrap(p.z() / cell_)};
}

Index NeighborList::findBin(std::uint64_t row, std::int64_t x) const {
  return static_cast<Index>((row + static_cast<std::uint64_t>(x)) & static_cast<std::uint64_t>(mask_));
}

void NeighborList::sortIntoBins(const Points& positions) {
  const Index n = static_cast<Index>(positions.size());
  Index num_bins = 4;  // three bins of one line are then three
  while (num_bins < n) num_bins *= 2;
  mask_ = num_bins - 1;
  bins_.resize(n);
  slots_.resize(n);
  starts_.assign(num_bins + 1, 0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Cell cell = cellOf(positions[i]);
      bins_[i] = findBin(hashRow(cell.y, cell.z), cell.x);
    }
  });
  for (Index bin : bins_) ++starts_[bin + 1];
  for (Index b = 0; b < num_bins; ++b) starts_[b + 1] += starts_[b];
  for (Index i = 0; i < n; ++i) {
    const Vec3& p = positions[i];
    const Cell cell = cellOf(p);
    slots_[starts_[bins_[i]]++] = {p.x(), p.y(), p.z(), static_cast<std::uint32_t>(hashRow(cell.y, cell.z)), i};
  }
  for (Index b = num_bins; b > 0; --b) starts_[b] = starts_[b - 1];
  starts_[0] = 0;
}

bool NeighborList::listNeighbors(const Points& positions, const std::vector<ParticleTraits>& traits, const ParticleCuts& cuts) {
  const double reach = radius_ + skin_, most = reach * reach;
  const Index n = static_cast<Index>(positions.size());
  // Moves particles that are kept apart from i from its neighbours to a list of their own.
  const auto removeApart = [&](Index i, Index* near, Index count) {
    std::vector<Apart>& list = near_apart_[i / kBlock];
    apart_begins_[i] = static_cast<Index>(list.size());
    apart_counts_[i] = 0;
    const Index first = traits[i].ancestor;
    if (first >= apart_.size()) return count;
    Index kept = 0;
    for (Index k = 0; k < count; ++k) {
      const Index j = near[k], other = traits[j].ancestor;
      const Index* found = std::lower_bound(apart_.begin(first), apart_.end(first), other);
      if (found == apart_.end(first) || *found != other) {
        near[kept++] = j;
        continue;
      }
      const double range = apart_ranges_.empty() ? radius_ : apart_ranges_[found - apart_.items.data()];
      // Others are out of reach until the next rebuild.
      if ((positions[j] - positions[i]).norm() <= range + skin_) list.push_back({j, range});
    }
    apart_counts_[i] = static_cast<Index>(list.size()) - apart_begins_[i];
    return kept;
  };
  const double overfull = parallelSum(n, kBlock, [&](Index first, Index last) {
    std::vector<Index>& list = blocks_[first / kBlock];
    list.clear();
    if (!cuts.isEmpty()) parted_[first / kBlock].clear();
    if (hasApart()) near_apart_[first / kBlock].clear();
    constexpr Index kCounted = 128;  // beyond it std::sort() is faster
    Index near[kMostNeighbors + 7] = {}, found[kMostNeighbors + 5], sorted[kCounted];
    static_assert(sizeof(Slot) == 4 * sizeof(double));
    const double* const places = &slots_.data()->x;
    double too_many = 0.0;
    for (Index i = first; i < last; ++i) {
      const Vec3& p = positions[i];
      const Cell cell = cellOf(p);
      Index count = 0;
      const auto take = [&](Index from, Index to, std::uint32_t row) {
        // The slots hold no particle twice: more than the most and itself are too many.
        const Index within = selectWithin(places, from, to, p.data(), most, kMostNeighbors + 1, found);
        if (within > kMostNeighbors + 1) too_many = 1.0;
        for (Index k = 0; k < within; ++k) {
          const Slot& slot = slots_[found[k]];
          if (slot.row != row || slot.particle == i) continue;
          if (count == kMostNeighbors) {
            too_many = 1.0;
            return;
          }
          near[count++] = slot.particle;
        }
      };
      // A line of cells has one number; two of the nine lines that share it are read once.
      std::uint32_t rows[9];
      int num_rows = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const std::uint64_t hash = hashRow(cell.y + dy, cell.z + dz);
          const std::uint32_t row = static_cast<std::uint32_t>(hash);
          if (std::find(rows, rows + num_rows, row) != rows + num_rows) continue;
          rows[num_rows++] = row;
          const Index middle = findBin(hash, cell.x);
          if (middle > 0 && middle < mask_) {
            take(starts_[middle - 1], starts_[middle + 2], row);
          } else {
            for (Index bin : {(middle - 1) & mask_, middle, (middle + 1) & mask_}) take(starts_[bin], starts_[bin + 1], row);
          }
        }
      if (count <= kCounted) {
        sortByCounting(count, near, sorted);
        std::copy_n(sorted, count, near);
      } else {
        std::sort(near, near + count);
      }
      if (hasApart()) count = removeApart(i, near, count);
      if (!cuts.isEmpty()) {
        std::vector<Index>& parted = parted_[first / kBlock];
        parted_begins_[i] = static_cast<Index>(parted.size());
        Index whole = 0;
        for (Index k = 0; k < count; ++k) {
          if (cuts.mayBind(traits[i].id, traits[near[k]].id)) {
            near[whole++] = near[k];
          } else {
            parted.push_back(near[k]);
          }
        }
        parted_counts_[i] = count - whole;
        count = whole;
      }
      begins_[i] = static_cast<Index>(list.size());
      counts_[i] = count;
      list.insert(list.end(), near, near + count);
    }
    return too_many;
  });
  return overfull == 0.0;
}

std::size_t NeighborList::bytes() const {
  std::size_t sum = rebuilt_at_.capacity() * sizeof(Vec3) + slots_.capacity() * sizeof(Slot);
  for (const std::vector<Index>* v : {&begins_, &counts_, &bins_, &starts_, &parted_begins_, &parted_counts_, &apart_begins_,
                                      &apart_counts_, &apart_.offsets, &apart_.items})
    sum += v->capacity() * sizeof(Index);
  for (const auto* blocks : {&blocks_, &parted_})
    for (const std::vector<Index>& block : *blocks) sum += block.capacity() * sizeof(Index);
  for (const std::vector<Apart>& block : near_apart_) sum += block.capacity() * sizeof(Apart);
  sum += apart_ranges_.capacity() * sizeof(double) + ranges_.capacity() * sizeof(Range);
  return sum + tree_.bytes();
}

}  // namespace deformable_surface::model
