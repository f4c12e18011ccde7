// A surface that grows inside of an iso-surface: how it begins, joins itself, and arrives.
#include "particle_guide.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "particle_life.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kLook = 1024;  // particles between two looks at an interrupt

}  // namespace

void requireSeed(const model::GuideParams& guide, const model::State& state) {
  if (!guide.grid)
    throw InputError("oriented_particles.guide.volume: found one that has not been read; accepted: a grid of values");
  Index inside = 0;
  for (const Vec3& p : state.positions) inside += guide.distance(p) > 0.0;
  if (2 * inside < state.size())
    throw InputError(
        "oriented_particles.guide: found " + std::to_string(inside) + " of " + std::to_string(state.size()) +
        " particles inside of the iso-surface; accepted: half of them or more (guide.inside states which side it is)");
}

bool reachesBorder(const model::GuideParams& guide) {
  const double side = guide.inside == model::GuideInside::kAbove ? 1.0 : -1.0;
  const std::array<Index, 3>& size = guide.grid->size();
  std::size_t at = 0;
  for (Index k = 0; k < size[2]; ++k)
    for (Index j = 0; j < size[1]; ++j)
      for (Index i = 0; i < size[0]; ++i, ++at) {
        const bool is_border = i == 0 || j == 0 || k == 0 || i + 1 == size[0] || j + 1 == size[1] || k + 1 == size[2];
        if (is_border && side * (guide.grid->values()[at] - guide.iso_value) > 0.0) return true;
      }
  return false;
}

// Where two fronts of the surface meet inside of the iso-surface that guides it, both go. Their rims then join, and the surface
// has a handle more.
void ParticleLife::markMeeting(const model::State& state) {
  constexpr double kMeeting = 2.0;  // spacings: in reach of bonds, which hold fronts apart
  constexpr double kFacing = -0.5;  // cosine between normals
  constexpr double kAhead = 0.7;    // cosine between a normal and the line to the other
  const cloud::KdTree tree(state.positions);
  std::vector<cloud::Neighbor> near;
  for (Index i = 0; i < state.size(); ++i) {
    endIfInterrupted(i, kLook);
    const Vec3 normal = state.orientations[i] * Vec3::UnitZ();
    tree.withinRadius(state.positions[i], kMeeting * model_.lattice().spacing, near);
    for (const cloud::Neighbor& q : near) {
      const Vec3 line = state.positions[q.index] - state.positions[i], other = state.orientations[q.index] * Vec3::UnitZ();
      if (!(normal.dot(other) < kFacing && normal.dot(line) > kAhead * line.norm())) continue;
      if (scene_.oriented_particles.guide.distance(state.positions[i] + 0.5 * line) > 0.0) is_gone_[i] = is_gone_[q.index] = 1;
    }
  }
}

// Once, when the surface lies on the iso-surface that guides it, or hardly moves elsewhere.
void ParticleLife::reportArrival(const model::State& state, Population& changes) {
  constexpr double kNear = 1.0;   // spacings: what still grows is farther from what is ahead of it
  constexpr double kSlow = 1e-3;  // spacings between two looks: growing surfaces move a hundred times as fast
  const model::GuideParams& guide = scene_.oriented_particles.guide;
  if (has_arrived_ || !guide.grid || state.size() == 0) return;
  const double spacing = model_.lattice().spacing;
  double squares = 0.0, largest = 0.0, fastest = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    const double d = std::abs(guide.distance(state.positions[i])) / spacing;
    squares += d * d;
    largest = std::max(largest, d);
    fastest = std::max(fastest, state.velocities[i].norm());
  }
  const bool is_near = largest<kNear, has_moved = fastest> 0.0;
  has_arrived_ = is_near || (has_moved && fastest * scene_.oriented_particles.growth_interval < kSlow * spacing);
  if (!has_arrived_) return;
  model_.refreshDisplay(state);
  const model::ParticleTopology found = model::measureTopology(state.size(), model_.triangles());
  appendNotice(changes.notice, (is_near ? std::string("the surface has come to the iso-surface: ")
                                        : std::string("the surface hardly moves, and not all of it is at the iso-surface: ")) +
                                   std::to_string(state.size()) + " particles, " +
                                   formatShort(std::sqrt(squares / state.size())) + " spacings from it (rms), " +
                                   formatShort(largest) + " at most; components " + std::to_string(found.components) +
                                   ", boundary loops " + std::to_string(found.boundary_loops) + ", Euler characteristic " +
                                   std::to_string(found.euler_characteristic));
}

}  // namespace deformable_surface::simulation
