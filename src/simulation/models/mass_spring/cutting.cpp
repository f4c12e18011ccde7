#include "cutting.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <numeric>

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 8;  // links between two checks of the interrupt: milliseconds for a knife that lies along all of them

constexpr Index kTearBlock = 2048;  // links in a task: some microseconds of work

bool isTooLong(const Cutting::Link& link, double rest, double tear_strain, const Points& positions) {
  const double most = (1.0 + tear_strain) * rest;
  return (positions[link.second] - positions[link.first]).squaredNorm() > most * most;
}

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
  kept->spacing = spacing_;
  kept->longest = longest_;
  cuts_ = std::move(kept);
}

// Also after an interrupt that may have left the model between two states.
void Cutting::setMemory(const std::shared_ptr<const Memory>& saved) {
  cuts_ = std::static_pointer_cast<const Cuts>(saved);
  model_.setCuts(cuts_ ? cuts_->links : std::vector<Link>());
  if (!cuts_) return;
  spacing_ = cuts_->spacing;
  longest_ = cuts_->longest;
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
  begun_with_ = cuts_;
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
  if (cuts_ == begun_with_ && model_.stretchLinks().empty() && model_.bendLinks().empty()) return false;
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
  if (!found_.empty()) cutFound();
  const bool has_cut = cuts_ != begun_with_;
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

void Cutting::cutFound() {
  found_.insert(found_.end(), model_.cuts().begin(), model_.cuts().end());
  std::sort(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  setCuts(found_);
}

void Cutting::tear(const Points& positions) {
  const std::vector<Link>& links = model_.stretchLinks();
  const std::vector<double>& lengths = model_.stretchingSprings().restLengths();
  for (std::size_t s = 0; s < links.size(); ++s)
    if (isTooLong(links[s], lengths[s], tear_strain_, positions)) found_.push_back(links[s]);
}

bool Cutting::isAnyStretched(const model::DeformableModel& model, const model::State& state) const {
  const model::Springs& springs = static_cast<const model::MassSpring&>(model).stretchingSprings();
  const std::vector<Link>& links = springs.links();
  return parallelMax(static_cast<Index>(links.size()), kTearBlock, [&](Index begin, Index end) {
           for (Index s = begin; s < end; ++s)
             if (isTooLong(links[s], springs.restLengths()[s], tear_strain_, state.positions)) return 1.0;
           return 0.0;
         }) > 0.0;
}

std::optional<double> Cutting::breakStretched(const model::State& state) {
  if (!isAnyStretched(model_, state)) return {};
  const double before = model_.elasticEnergy(state);
  found_.clear();
  tear(state.positions);
  cutFound();
  return before - model_.elasticEnergy(state);
}

}  // namespace deformable_surface::simulation
