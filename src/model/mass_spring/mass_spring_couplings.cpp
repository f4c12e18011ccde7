// A sparse spring approximation of the stiffness, for solvers that cannot afford the matrix of blocks. No force depends on
// it.
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>
#include <numeric>

namespace deformable_surface::model {
namespace {

// Of the springs along, so that a motion that nothing resists is not answered by one without bound.
constexpr double kLeastAcross = 1e-6;
// Bending, in tensions, below which more support stands for it: its pairs are eight times as many and fill the factor, so that
// twice the iterations without it take less time. From 30000 on there are too many (docs/decisions/0003).
constexpr double kWeak = 1000.0;
constexpr double kRounding = 1e-9;  // of the springs along: tension below that is none

}  // namespace

bool MassSpring::knowsCouplings() const {
  return membrane_ == Membrane::kTriangles && bending_springs_.links().empty() && !(volume_stiffness_ > 0.0);
}

bool MassSpring::findCouplings(const State& state, double support, std::vector<Coupling>& along,
                               std::vector<Coupling>& across) const {
  if (!knowsCouplings()) return false;
  membrane_triangles_.computeSpringsAcross(state, springs_across_);
  if (bending_sum_ < 0.0) bending_sum_ = bending_.sumSprings();
  const auto sum = [](const std::vector<double>& springs) { return std::accumulate(springs.begin(), springs.end(), 0.0); };
  if (springs_along_.empty()) membrane_triangles_.computeSpringsAlong(springs_along_);
  if (springs_along_.empty()) return false;  // all is cut
  const double stretching = sum(springs_along_), tension = sum(springs_across_);
  const bool is_slack = tension <= kRounding * stretching;
  const bool has_bending = !is_slack && bending_sum_ > kWeak * tension;
  Guess& guess = has_bending ? stiff_guess_ : slack_guess_;
  if (guess.along.empty()) makeGuess(has_bending, guess);
  along = guess.along;
  if (is_slack) {
    // It will sag like a membrane; the first step finds out how far.
    across = along;
    return true;
  }
  across = guess.across;
  const double added = (has_bending ? support : std::max(support, bending_sum_ / tension)) * tension / stretching;
  for (std::size_t e = 0; e < guess.edges.size(); ++e)
    across[guess.edges[e]].stiffness += springs_across_[e] + added * springs_along_[e];
  return true;
}

void MassSpring::forgetGuesses() {
  stiff_guess_ = slack_guess_ = {};
  bending_sum_ = -1.0;
  springs_along_.clear();
}

// Row by row: the points k > j that share a fit or an edge with j, each once.
void MassSpring::makeGuess(bool has_bending, Guess& guess) const {
  const Index n = static_cast<Index>(masses_.size());
  const std::vector<Link> edges = membrane_triangles_.findEdges();
  Lists of_point;  // its edges to points of larger index
  of_point.offsets.assign(n + 1, 0);
  for (const Link& edge : edges) ++of_point.offsets[edge.first + 1];
  std::partial_sum(of_point.offsets.begin(), of_point.offsets.end(), of_point.offsets.begin());
  of_point.items.resize(edges.size());
  std::vector<Index> next(of_point.offsets.begin(), of_point.offsets.end() - 1);
  for (std::size_t e = 0; e < edges.size(); ++e) of_point.items[next[edges[e].first]++] = static_cast<Index>(e);

  guess.edges.resize(edges.size());
  guess.along.reserve(edges.size());
  guess.across.reserve(edges.size());
  std::vector<Index> place_along(n, -1), place_across(n, -1);  // of the pair (j, k), if it has one in this row
  for (Index j = 0; j < n; ++j) {
    const Index begin_along = static_cast<Index>(guess.along.size()), begin_across = static_cast<Index>(guess.across.size());
    const auto add = [j](Index k, double stiffness, Index begin, std::vector<Index>& place, std::vector<Coupling>& to) {
      if (place[k] < begin) {
        place[k] = static_cast<Index>(to.size());
        to.push_back({j, k, 0.0});
      }
      to[place[k]].stiffness += stiffness;
    };
    if (has_bending)
      bending_.forEachSpring(j, [&](Index k, double stiffness) { add(k, stiffness, begin_across, place_across, guess.across); });
    for (const Index* e = of_point.begin(j); e != of_point.end(j); ++e) {
      const Index k = edges[*e].second;
      add(k, springs_along_[*e], begin_along, place_along, guess.along);
      add(k, kLeastAcross * springs_along_[*e], begin_across, place_across, guess.across);
      guess.edges[*e] = place_across[k];
    }
  }
}

}  // namespace deformable_surface::model
