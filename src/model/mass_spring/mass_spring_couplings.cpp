// A guess of the stiffness in one number a pair of points, for solvers that cannot pay for the matrix of blocks. A file of its
// own because no force depends on it.
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

// Of the springs along, so that a motion that nothing resists is not answered by one without bound.
constexpr double kLeastAcross = 1e-6;

}  // namespace

bool MassSpring::findCouplings(const State& state, std::vector<Coupling>& along, std::vector<Coupling>& across) const {
  if (membrane_ != Membrane::kTriangles || !bending_springs_.links().empty() || volume_stiffness_ > 0.0) return false;
  if (guess_.along.empty()) makeGuess();
  along = guess_.along;
  across = guess_.bending;
  membrane_triangles_.computeSpringsAcross(state, springs_across_);
  for (std::size_t e = 0; e < guess_.edges.size(); ++e) across[guess_.edges[e]].stiffness += springs_across_[e];
  return true;
}

// Row by row: the points k > j that a fit or an edge couples with j, each once.
void MassSpring::makeGuess() const {
  const Index n = static_cast<Index>(masses_.size());
  const std::vector<Link> edges = membrane_triangles_.findEdges();
  std::vector<double> springs;
  membrane_triangles_.computeSpringsAlong(springs);
  Lists of_point;  // its edges to points of larger index
  of_point.offsets.assign(n + 1, 0);
  for (const Link& edge : edges) ++of_point.offsets[edge.first + 1];
  for (Index j = 0; j < n; ++j) of_point.offsets[j + 1] += of_point.offsets[j];
  of_point.items.resize(edges.size());
  std::vector<Index> next(of_point.offsets.begin(), of_point.offsets.end() - 1);
  for (std::size_t e = 0; e < edges.size(); ++e) of_point.items[next[edges[e].first]++] = static_cast<Index>(e);

  guess_ = {};
  guess_.edges.resize(edges.size());
  std::vector<Index> place(n, -1), place_along(n, -1);  // of the pair (j, k), if it has one in this row
  for (Index j = 0; j < n; ++j) {
    const Index begin = static_cast<Index>(guess_.bending.size()), begin_along = static_cast<Index>(guess_.along.size());
    const auto add = [j](Index k, double stiffness, Index row, std::vector<Index>& places, std::vector<Coupling>& to) {
      if (places[k] < row) {
        places[k] = static_cast<Index>(to.size());
        to.push_back({j, k, 0.0});
      }
      to[places[k]].stiffness += stiffness;
    };
    bending_.forEachSpring(j, [&](Index k, double stiffness) { add(k, stiffness, begin, place, guess_.bending); });
    for (const Index* e = of_point.begin(j); e != of_point.end(j); ++e) {
      const Index k = edges[*e].second;
      add(k, kLeastAcross * springs[*e], begin, place, guess_.bending);
      add(k, springs[*e], begin_along, place_along, guess_.along);
      guess_.edges[*e] = place[k];
    }
  }
}

}  // namespace deformable_surface::model
