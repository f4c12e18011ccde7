#include "cutting.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <numeric>

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 8;  // links between two checks of the interrupt: milliseconds for a knife that lies along all of them

bool isKnife(const tool::ToolParams& tool, double time) { return tool.mode == tool::Mode::kCut && tool::isActive(tool, time); }

}  // namespace

Cutting::Cutting(model::MassSpring& model, double tear_strain) : model_(model), tear_strain_(tear_strain) {
  const std::vector<double>& lengths = model.stretchingSprings().restLengths();
  if (lengths.empty()) return;
  spacing_ = std::accumulate(lengths.begin(), lengths.end(), 0.0) / static_cast<double>(lengths.size());
  longest_ = *std::max_element(lengths.begin(), lengths.end());
}

void Cutting::setCuts(const std::vector<Link>& cuts) {
  model_.setCuts(cuts);
  cuts_.reset();
  if (cuts.empty()) return;
  auto kept = std::make_shared<Cuts>();
  kept->links = model_.cuts();
  cuts_ = std::move(kept);
}

// Also after an interrupt that may have left the model between two states.
void Cutting::setMemory(const std::shared_ptr<const Memory>& saved) {
  cuts_ = std::static_pointer_cast<const Cuts>(saved);
  model_.setCuts(cuts_ ? cuts_->links : std::vector<Link>());
}

std::uint64_t Cutting::addToHash(std::uint64_t hash) const {
  if (!cuts_) return hash;
  for (const auto& [a, b] : cuts_->links)
    hash = mixHash(mixHash(hash, static_cast<std::uint64_t>(a)), static_cast<std::uint64_t>(b));
  return hash;
}

void Cutting::beginStep(double time, const std::vector<tool::ToolParams>& tools, const Points& positions) {
  const bool has_knife =
      std::any_of(tools.begin(), tools.end(), [&](const tool::ToolParams& tool) { return isKnife(tool, time); });
  if (has_knife) before_ = positions;
  may_cut_ = has_knife || tear_strain_ > 0.0;
}

Evolution::AfterStep Cutting::endStep(double time, double step, const std::vector<tool::ToolParams>& tools, model::State& state,
                                      CutFollower* follower) {
  AfterStep after;
  after.has_cut = may_cut_ && cutLinks(time, step, tools, state.positions, follower);
  return after;
}

bool Cutting::cutLinks(double time, double step, const std::vector<tool::ToolParams>& tools, const Points& positions,
                       CutFollower* follower) {
  found_.clear();
  if (model_.stretchLinks().empty() && model_.bendLinks().empty()) return false;
  bool has_parted = false;
  for (const tool::ToolParams& tool : tools) {
    if (!isKnife(tool, time)) continue;
    const double resolution = tool::findBladeResolution(tool, time, step, before_, positions, spacing_);
    const tool::BladeSweep blade(tool, time, step, before_, positions, longest_, resolution);
    if (!blade.isNear()) continue;
    cut(blade, positions, model_.stretchLinks());
    cut(blade, positions, model_.bendLinks());
    has_parted = (follower && follower->sever(blade, before_, positions)) || has_parted;
  }
  if (tear_strain_ > 0.0) tear(positions);
  const bool has_cut = !found_.empty();
  if (has_cut) {
    found_.insert(found_.end(), model_.cuts().begin(), model_.cuts().end());
    std::sort(found_.begin(), found_.end());
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    setCuts(found_);
  }
  if (follower && (has_cut || has_parted)) follower->followLinks(model_.stretchLinks());
  return has_cut;
}

void Cutting::cut(const tool::BladeSweep& blade, const Points& positions, const std::vector<Link>& links) {
  is_cut_.assign(links.size(), 0);
  parallelFor(static_cast<Index>(links.size()), kBlock, [&](Index begin, Index end) {
    for (Index l = begin; l < end; ++l) {
      const auto& [a, b] = links[l];
      is_cut_[l] = blade.wentBetween(before_[a], positions[a], before_[b], positions[b], blade.all());
    }
  });
  for (std::size_t l = 0; l < links.size(); ++l)
    if (is_cut_[l]) found_.push_back(links[l]);
}

void Cutting::tear(const Points& positions) {
  const std::vector<Link>& links = model_.stretchLinks();
  const std::vector<double>& lengths = model_.stretchingSprings().restLengths();
  for (std::size_t s = 0; s < links.size(); ++s)
    if ((positions[links[s].second] - positions[links[s].first]).norm() > (1.0 + tear_strain_) * lengths[s])
      found_.push_back(links[s]);
}

}  // namespace deformable_surface::simulation
