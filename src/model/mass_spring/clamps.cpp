#include "deformable_surface/model/mass_spring/clamps.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr double kFlatSpread = 0.05;  // second extent over the first, below which held points count as a line

// Whether the held points among the first ring of i, with i, span a patch.
bool spansPatch(Index i, const Points& rest, const Lists& ring, const std::vector<char>& held) {
  Mat3 spread = Mat3::Zero();
  for (const Index* j = ring.begin(i); j != ring.end(i); ++j)
    if (held[*j]) spread += (rest[*j] - rest[i]) * (rest[*j] - rest[i]).transpose();
  // The second invariant against the first: the product of the two larger eigenvalues over the square of their sum.
  const double trace = spread.trace(), minors = 0.5 * (trace * trace - (spread * spread).trace());
  return minors > kFlatSpread * trace * trace;
}

}  // namespace

Clamps::Clamps(const Points& rest, const Lists& ring, const std::vector<char>& held) {
  if (std::count(held.begin(), held.end(), 0) == static_cast<std::ptrdiff_t>(held.size())) return;
  const Index n = static_cast<Index>(rest.size());
  kind_.assign(n, Kind::kFree);
  share_.assign(n, 1.0);
  const auto hasFree = [&](Index i) { return std::any_of(ring.begin(i), ring.end(i), [&](Index j) { return !held[j]; }); };
  for (Index i = 0; i < n; ++i)
    if (held[i]) kind_[i] = !hasFree(i) ? Kind::kInner : spansPatch(i, rest, ring, held) ? Kind::kEdge : Kind::kHinge;
  // Neighbours on the edge lie on the border of what is free: they count half.
  for (Index i = 0; i < n; ++i) {
    if (kind_[i] != Kind::kEdge) continue;
    double free = 0.0;
    for (const Index* j = ring.begin(i); j != ring.end(i); ++j) free += held[*j] ? (isEdge(*j) ? 0.5 : 0.0) : 1.0;
    share_[i] = free / ring.count(i);
  }
}

}  // namespace deformable_surface::model
