// Which points of a dynamics are held: pins, those that go along a path, where they clamp, and what the evolution holds.
#include "dynamics.h"

#include <algorithm>

namespace deformable_surface::simulation {

// The first of the scene's pins that holds a point at rest or, where it rides on one, a neighbour of it; as many as there are:
// none.
std::size_t Dynamics::findPin(Index point) const {
  const std::vector<PinParams>& pins = params_.pins;
  const auto find = [&](Index i) -> std::size_t {
    const auto holds = [&](const PinParams& pin) { return pin.region.contains(rest_->points[i]); };
    return std::find_if(pins.begin(), pins.end(), holds) - pins.begin();
  };
  std::size_t pin = find(point);
  if (pin < pins.size() || rest_->pinned[point] != kRidesOnPin) return pin;
  const Lists& ring = rest_->rings.ring;
  for (const Index* j = ring.begin(point); j != ring.end(point) && pin == pins.size(); ++j)
    if (rest_->pinned[*j] == kInPin) pin = find(*j);
  return pin;
}

// Those that go along a path. A point of two pins goes with the first.
void Dynamics::placePins() {
  const std::vector<PinParams>& pins = params_.pins;
  grips_.clearPins();
  std::vector<std::vector<Index>> points(pins.size());
  for (Index i = 0; i < now_.points.size(); ++i) {
    const std::size_t p = findPin(i);
    if (p < points.size()) points[p].push_back(i);
  }
  for (std::size_t p = 0; p < pins.size(); ++p)
    if (!pins[p].path.empty() && !points[p].empty())
      grips_.addPin("pins[" + std::to_string(p) + "]", pins[p].path, 0.0, std::move(points[p]), now_.points);
}

// Where a region that has just been pinned ends; inside (m): its points. Returns the points that ride on it.
std::vector<Index> Dynamics::findClamps(const std::vector<char>& inside, const Contains& contains) {
  if (!canClamp(params_)) return {};
  const std::vector<char> clamping = markClamping(rest_->points, rest_->rings.ring, inside, activity_.spacing());
  const ClampEdges found = findClampEdges(
      {rest_->points, now_.points.positions, rest_->rings.ring, rest_->rings.open, trianglesOf(*model_)}, clamping, contains);
  std::vector<Index> riding;
  for (const Index i : found.riding) {
    if (now_.pinned[i]) continue;
    now_.pinned[i] = kRidesOnPin;
    now_.points.velocities[i].setZero();
    riding.push_back(i);
  }
  std::vector<model::ClampEdge>& edges = now_.clamp_edges;
  for (const model::ClampEdge& edge : found.edges) {
    const auto at = std::lower_bound(edges.begin(), edges.end(), edge.point,
                                     [](const model::ClampEdge& e, Index point) { return e.point < point; });
    if (at != edges.end() && at->point == edge.point)
      *at = edge;
    else
      edges.insert(at, edge);
  }
  return riding;
}

// After points have been let go: what rode on them goes with them.
void Dynamics::endClamps() {
  if (!canClamp(params_)) return;
  const Lists& ring = rest_->rings.ring;
  std::vector<char>& pinned = now_.pinned;
  std::vector<model::ClampEdge>& edges = now_.clamp_edges;
  const auto isInPin = [&](Index j) { return pinned[j] == kInPin; };
  for (Index i = 0; i < now_.points.size(); ++i)
    if (pinned[i] == kRidesOnPin && std::none_of(ring.begin(i), ring.end(i), isInPin)) pinned[i] = kNotPinned;
  edges.erase(std::remove_if(edges.begin(), edges.end(), [&](const model::ClampEdge& edge) { return !pinned[edge.point]; }),
              edges.end());
}

// Tells the model what is held; what was measured and kept of it with other clamps is then worth nothing.
void Dynamics::clampHeld() {
  held_ = now_.pinned;
  held_turns_ = now_.pinned_turns;
  model::Clamping* const clamping = model_->clamping();
  if (clamping && clamping->setHeld(now_.pinned, now_.clamp_edges)) march_.restart();
  evolution_->hold(now_.points, held_, held_turns_);
}

}  // namespace deformable_surface::simulation
