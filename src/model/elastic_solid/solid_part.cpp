// Parts of an elastic solid for sleeping: the same fits with the same numbers on fewer points, so that a step costs only the
// part.
#include "deformable_surface/model/elastic_solid/elastic_solid.h"

#include "deformable_surface/base/marks.h"

namespace deformable_surface::model {
namespace {

// Calls visit(i) once for each of the points and of their neighbours, whose fits contain them.
template <class Visit>
void forEachFit(const std::vector<Index>& points, const Lists& pairs, Visit&& visit) {
  // Kept by the thread: later calls allocate nothing.
  static thread_local Marks seen;
  seen.begin(pairs.size());
  const auto see = [&](Index i) {
    if (seen.take(i)) visit(i);
  };
  for (const Index i : points) {
    see(i);
    for (const Index* j = pairs.begin(i); j != pairs.end(i); ++j) see(*j);
  }
}

struct Selection {
  std::vector<Index> points;     // ascending, of the whole
  std::vector<Index> new_index;  // (of the whole) -1: not in the part
  std::vector<char> has_fit;     // (of the part) else it is there for its place alone
};

void appendRow(const std::vector<double>& from, Index width, Index k, std::vector<double>& to) {
  const auto begin = from.begin() + static_cast<std::ptrdiff_t>(width) * k;
  to.insert(to.end(), begin, begin + width);
}

PairFit select(const PairFit& whole, const Selection& part) {
  PairFit fit;
  std::size_t num_pairs = 0;
  for (std::size_t p = 0; p < part.points.size(); ++p) num_pairs += part.has_fit[p] ? whole.pairs.count(part.points[p]) : 0;
  fit.pairs.items.reserve(num_pairs);
  fit.m.reserve(whole.m.empty() ? 0 : 4 * num_pairs);
  for (std::size_t p = 0; p < part.points.size(); ++p) {
    const Index i = part.points[p];
    if (part.has_fit[p]) {
      for (Index k = whole.pairs.offsets[i]; k < whole.pairs.offsets[i + 1]; ++k) {
        fit.pairs.items.push_back(part.new_index[whole.pairs.items[k]]);
        if (!whole.m.empty()) appendRow(whole.m, 4, k, fit.m);
      }
    }
    fit.pairs.offsets.push_back(static_cast<Index>(fit.pairs.items.size()));
    appendRow(whole.inverse, 6, i, fit.inverse);
    fit.rank.push_back(part.has_fit[p] ? whole.rank[i] : 0);
  }
  return fit;
}

SolidRest select(const SolidRest& whole, const Selection& part) {
  SolidRest rest;
  rest.fit = select(whole.fit, part);
  rest.near = select(whole.near, part);
  rest.gradients.residual = whole.gradients.residual;
  rest.gradients.row.reserve(3 * rest.fit.pairs.items.size());
  for (std::size_t p = 0; p < part.points.size(); ++p) {
    const Index i = part.points[p];
    for (Index k = whole.fit.pairs.offsets[i]; part.has_fit[p] && k < whole.fit.pairs.offsets[i + 1]; ++k)
      appendRow(whole.gradients.row, 3, k, rest.gradients.row);
    rest.gradients.own.push_back(whole.gradients.own[i]);
    rest.volumes.push_back(whole.volumes[i]);
  }
  rest.mu = whole.mu;
  rest.lambda = whole.lambda;
  rest.stabilization = whole.stabilization;
  rest.across = whole.across;
  return rest;
}

}  // namespace

// Plastic flow changes the fits themselves.
bool ElasticSolid::markPartners(const std::vector<Index>& points, std::vector<char>& marked) const {
  if (plasticity_) return false;
  const Lists& pairs = passes_.rest.fit.pairs;  // the near ones are among them
  forEachFit(points, pairs, [&](Index fit) {
    marked[fit] = 1;
    for (const Index* j = pairs.begin(fit); j != pairs.end(fit); ++j) marked[*j] = 1;
  });
  return true;
}

ElasticSolid::ElasticSolid(SolidRest rest) : passes_(std::move(rest)) {}

Partition::Part ElasticSolid::makePart(const std::vector<char>& wanted) const {
  if (plasticity_) return {};
  std::vector<Index> wanted_points;
  for (Index i = 0; i < passes_.size(); ++i)
    if (wanted[i]) wanted_points.push_back(i);
  std::vector<char> present(wanted.size(), 0), has_fit(wanted.size(), 0);
  markPartners(wanted_points, present);
  forEachFit(wanted_points, passes_.rest.fit.pairs, [&](Index fit) { has_fit[fit] = 1; });
  Selection selection;
  selection.new_index.assign(wanted.size(), -1);
  for (Index i = 0; i < passes_.size(); ++i) {
    if (!present[i]) continue;
    selection.new_index[i] = static_cast<Index>(selection.points.size());
    selection.points.push_back(i);
    selection.has_fit.push_back(has_fit[i]);
  }

  std::unique_ptr<ElasticSolid> part(new ElasticSolid(select(passes_.rest, selection)));
  part->law_ = law_;
  part->is_plate_ = is_plate_;
  part->stable_step_ = stable_step_;  // constraints make no motion faster
  for (const Index i : selection.points) {
    part->masses_.push_back(masses_[i]);
    part->row_bounds_.push_back(row_bounds_[i]);
  }
  for (const Coupling& c : couplings_) {
    const Index i = selection.new_index[c.i], j = selection.new_index[c.j];
    if (i >= 0 && j >= 0) part->couplings_.push_back({i, j, c.stiffness});
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Index i = selection.new_index[links_[k].first], j = selection.new_index[links_[k].second];
    if (i < 0 || j < 0) continue;
    part->links_.emplace_back(i, j);
    part->lengths_.push_back(lengths_[k]);
  }
  return {std::move(part), std::move(selection.points)};
}

}  // namespace deformable_surface::model
