#include "cut_transfer.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::simulation {
namespace {

constexpr int kReach = 3;  // links from the home: about as far as the points that a dense point follows lie at rest

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
  bool any = false;
  for (std::size_t d = 0; d < severed_.size(); ++d) {
    if (!blade.isNear(dense_before_[d])) continue;
    const std::vector<Index> sources = rest_.transfer.sourcesOf(static_cast<Index>(d));
    for (std::size_t j = 0; j < sources.size(); ++j) {
      if ((severed_[d] >> j & 1) != 0) continue;
      if (!blade.wentBetween(dense_before_[d], dense_after_[d], before[sources[j]], after[sources[j]])) continue;
      severed_[d] |= std::uint64_t{1} << j;
      any = true;
    }
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
    is_refit_[d] = 1;
    followed.items.insert(followed.items.end(), reached.begin(), reached.end());
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
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
