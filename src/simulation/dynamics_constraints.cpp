// Constrained points of a dynamics: pins, pins with a path, where they clamp, and points that the evolution holds.
#include "dynamics.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>

namespace deformable_surface::simulation {
namespace {

constexpr double kSameSpacing = 0.9;  // fraction of the simulation points' spacing below which the cloud has more points
constexpr std::size_t kFewHeld = 6;   // simulation points of a grip below which clamps were off by 5 to 40 % (docs/accuracy.md)

// Of points within two rings of marked ones their first two rings; at the corner of a sheet one is too few to tell a row of
// points from several.
Lists findTwoRings(const Lists& ring, std::vector<char> marked) {
  for (int k = 0; k < 2; ++k) {
    const std::vector<char> before = marked;
    for (Index i = 0; i < ring.size(); ++i)
      marked[i] = before[i] || std::any_of(ring.begin(i), ring.end(i), [&](Index j) { return before[j] != 0; });
  }
  Lists two;
  for (Index i = 0; i < ring.size(); ++i) {
    const std::size_t first = two.items.size();
    const auto add = [&](Index k) {
      if (k != i && std::find(two.items.begin() + first, two.items.end(), k) == two.items.end()) two.items.push_back(k);
    };
    if (marked[i])
      for (const Index* j = ring.begin(i); j != ring.end(i); ++j) {
        add(*j);
        for (const Index* k = ring.begin(*j); k != ring.end(*j); ++k) add(*k);
      }
    two.offsets.push_back(static_cast<Index>(two.items.size()));
  }
  return two;
}

}  // namespace

// Index of the first pin of the scene that holds a point at rest or, for a point that rides on one, a neighbour of it; the number
// of pins if there is none.
std::size_t Dynamics::findPin(Index point) const {
  Index pin = rest_->pin_of[point];
  if (pin < 0 && rest_->pinned[point] == kRidesOnPin) {
    const Lists& ring = rest_->rings.ring;
    for (const Index* j = ring.begin(point); j != ring.end(point) && pin < 0; ++j)
      if (rest_->pinned[*j] == kInPin) pin = rest_->pin_of[*j];
  }
  return pin < 0 ? params_.pins.size() : static_cast<std::size_t>(pin);
}

// Starts the pins that follow a path. A point of two pins goes with the first.
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

// The edge of a region that has just been pinned or gripped; inside (m): its points.
ClampEdges Dynamics::findEdges(const std::vector<char>& inside, const Contains& contains) const {
  if (!canClamp(params_)) return {};
  const std::vector<model::WeightedTriangle>& triangles = trianglesOf(*model_);
  const ClampedSurface surface{rest_->points, now_.points.positions, rest_->rings.ring, rest_->rings.open, triangles};
  std::vector<char> clamping = markClamping(rest_->points, findTwoRings(rest_->rings.ring, inside), inside, activity_.spacing());
  markWide(surface, inside, contains, rest_->dense_spacing, clamping);
  return findClampEdges(surface, clamping, contains);
}

// The same of a pin, which holds it from now on. Returns the points that ride on it.
std::vector<Index> Dynamics::clampPin(const std::vector<char>& inside, const Contains& contains) {
  const ClampEdges found = findEdges(inside, contains);
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

// After points have been released: points that rode on them are released too.
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

// Clamps the points of tools that have just taken hold. Returns a notice of grips on too few points.
std::string Dynamics::clampGrips(const std::vector<std::size_t>& begun) {
  std::string notice;
  if (!canClamp(params_)) return notice;
  const bool is_simplified = rest_->dense_spacing < kSameSpacing * activity_.spacing();
  for (const std::size_t g : begun) {
    const Grips::Grip& grip = grips_.all()[g];
    const tool::Pose pose = tool::interpolate(grip.tool.path, time());
    std::vector<char> inside(now_.points.positions.size(), 0);
    for (const Index i : grip.points) inside[i] = 1;
    ClampEdges found = findEdges(
        inside, [&](const Vec3& place) { return tool::findSignedDistance(grip.tool.shape, pose, place, 0.0).distance <= 0.0; });
    const auto isHeld = [&](Index i) { return held_[i] != 0; };
    found.riding.erase(std::remove_if(found.riding.begin(), found.riding.end(), isHeld), found.riding.end());
    grips_.clamp(g, time(), std::move(found.edges), found.riding, now_.points);
    const std::size_t num_held = grip.points.size();
    if (is_simplified && num_held > 0 && num_held < kFewHeld)
      appendNotice(notice, "tool " + quote(grip.tool.id) + " holds only " + std::to_string(num_held) +
                               " of the simulation points: the surface may bend around it by a tenth too much or more; more "
                               "simulation points or a wider tool are more accurate");
  }
  return notice;
}

// Sets the held points in the model, in patches that move as one. With other clamps, everything measured and stored before is
// void.
void Dynamics::clampHeld() {
  held_ = now_.pinned;
  held_turns_ = now_.pinned_turns;
  model::Clamping* const clamping = model_->clamping();
  if (clamping) {
    patches_.assign(held_.begin(), held_.end());
    for (char& patch : patches_) patch = patch != kNotPinned;
    patch_edges_ = now_.clamp_edges;
    grips_.addPatches(patches_, patch_edges_);
    if (clamping->setHeld(patches_, patch_edges_)) {
      march_.restart();
      wakeAll();
    }
  }
  evolution_->hold(now_.points, held_, held_turns_);
}

}  // namespace deformable_surface::simulation
