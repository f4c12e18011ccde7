#include "cut_transfer.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 8;       // dense points between two looks at an interrupt: milliseconds at most
constexpr double kGrazed = 1.01;  // of the way to the farthest source: as far as a knife is looked for
constexpr int kReach = 3;         // links from the home: about as far as the points that a dense point follows lie at rest

}  // namespace

CutTransfer::CutTransfer(const RestSurface& rest, const transfer::TransferParams& params)
    : rest_(rest),
      params_(params),
      transfer_(rest.transfer),
      severed_(rest.dense.positions.size(), 0),
      is_refit_(severed_.size(), 0) {}

bool CutTransfer::sever(const tool::BladeSweep& blade, const Points& before, const Points& after) {
  transfer_.apply(before, dense_before_);
  transfer_.apply(after, dense_after_);
  parted_.assign(severed_.size(), 0);
  parallelFor(static_cast<Index>(severed_.size()), kBlock, [&](Index begin, Index end) {
    std::vector<Index> sources;
    for (Index d = begin; d < end; ++d) {
      if (!blade.isNear(dense_before_[d])) continue;
      sources = rest_.transfer.sourcesOf(d);
      double radius = 0.0;
      for (const Index j : sources)
        radius = std::max({radius, (before[j] - dense_before_[d]).norm(), (after[j] - dense_after_[d]).norm()});
      const tool::BladeSweep::Looks looks = blade.findLooks(dense_before_[d], dense_after_[d], kGrazed * radius);
      for (std::size_t j = 0; j < sources.size() && looks.first <= looks.last; ++j) {
        if ((severed_[d] >> j & 1) != 0) continue;
        if (!blade.wentBetween(dense_before_[d], dense_after_[d], before[sources[j]], after[sources[j]], looks)) continue;
        parted_[d] |= std::uint64_t{1} << j;
      }
    }
  });
  bool any = false;
  for (std::size_t d = 0; d < severed_.size(); ++d) {
    any = any || parted_[d] != 0;
    severed_[d] |= parted_[d];
  }
  if (any) memory_.reset();
  return any;
}

void CutTransfer::followLinks(const std::vector<Link>& whole) {
  const Index m = static_cast<Index>(rest_.points.size());
  std::vector<Link> both = whole;
  for (const Link& link : whole) both.emplace_back(link.second, link.first);
  std::sort(both.begin(), both.end());
  Lists ring;
  for (Index i = 0, at = 0; i < m; ++i) {
    for (; at < static_cast<Index>(both.size()) && both[at].first == i; ++at) ring.items.push_back(both[at].second);
    ring.offsets.push_back(static_cast<Index>(ring.items.size()));
  }
  // Points at which something is cut: their rings at rest are larger.
  std::vector<char> is_cut(m, 0);
  for (Index i = 0; i < m; ++i) is_cut[i] = ring.count(i) < rest_.rings.ring.count(i);

  std::vector<Index> refit;
  Lists followed;
  std::vector<Index> reached, distance(m, -1);
  for (std::size_t d = 0; d < severed_.size(); ++d) {
    endIfInterrupted(d, std::size_t{kBlock});
    const std::vector<Index> sources = rest_.transfer.sourcesOf(static_cast<Index>(d));
    const bool touches = std::any_of(sources.begin(), sources.end(), [&](Index j) { return is_cut[j]; });
    if (!touches && severed_[d] == 0 && !is_refit_[d]) continue;
    const auto isSevered = [&](Index j) {
      const std::size_t place = std::find(sources.begin(), sources.end(), j) - sources.begin();
      return place < sources.size() && (severed_[d] >> place & 1) != 0;
    };
    const auto home = std::find_if_not(sources.begin(), sources.end(), isSevered);
    reached.assign(1, home == sources.end() ? sources.front() : *home);
    distance[reached[0]] = 0;
    for (std::size_t k = 0; k < reached.size() && distance[reached[k]] < kReach; ++k)
      for (const Index* j = ring.begin(reached[k]); j != ring.end(reached[k]); ++j)
        if (distance[*j] < 0) {
          distance[*j] = distance[reached[k]] + 1;
          reached.push_back(*j);
        }
    for (Index j : reached) distance[j] = -1;
    reached.erase(std::remove_if(reached.begin() + 1, reached.end(), isSevered), reached.end());
    const Vec3& at = rest_.dense.positions[d];
    std::sort(reached.begin(), reached.end(), [&](Index a, Index b) {
      const double to_a = (rest_.points[a] - at).squaredNorm(), to_b = (rest_.points[b] - at).squaredNorm();
      return to_a != to_b ? to_a < to_b : a < b;
    });
    if (static_cast<Index>(reached.size()) > params_.k) reached.resize(params_.k);
    refit.push_back(static_cast<Index>(d));
    followed.items.insert(followed.items.end(), reached.begin(), reached.end());
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  for (const Index d : refit) is_refit_[d] = 1;
  transfer_.refit(refit, followed, rest_.dense.normals, params_);
}

std::shared_ptr<const CutTransfer::Memory> CutTransfer::memory() const {
  if (!memory_) memory_ = std::make_shared<const Memory>(severed_);
  return memory_;
}

void CutTransfer::setMemory(const std::shared_ptr<const Memory>& severed, const std::vector<Link>& whole) {
  severed_ = *severed;
  memory_ = severed;
  followLinks(whole);
}

}  // namespace deformable_surface::simulation
