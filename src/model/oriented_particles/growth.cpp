// The two rules: candidates of each particle in parallel, then a choice among those too close to each other, in a fixed order.
#include "deformable_surface/model/oriented_particles/growth.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "local_surface.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

namespace deformable_surface::model {
namespace {

// The gap between successive neighbours of a hexagonal arrangement.
constexpr double kEvenGap = kPi / 3.0;

// Cosine of the smallest angle at a new particle between its parent and the other side of the gap. In a hexagonal sheet with a
// hole the ends of the edge with the parent are at 120 and 150 degrees; the other side is beyond.
constexpr double kAhead = -0.9;

// Share of d / 2 that a wide pair keeps clear: d_min / 2 at the published d_max.
constexpr double kWideClearance = 0.8;

// Particles nearer to a new one, in spacings, must see it: the first neighbours, which lie on the same surface.
constexpr double kWitnesses = 1.5;

constexpr Index kBlock = 64;
constexpr std::size_t kLook = 256;  // candidates between two looks at an interrupt

constexpr double kMuch = 0.5;  // share of particles that have changed: looking at all of them then costs as little

using Candidate = ProposalMemory::Proposal;

void check(std::size_t num_particles, const std::vector<char>& flags, const std::vector<double>& reaches, double spacing,
           const GrowthParams& params) {
  if (flags.size() != num_particles) {
    throw InputError("found " + std::to_string(flags.size()) + " flags for " + std::to_string(num_particles) +
                     " particles; accepted: one for each");
  }
  if (!reaches.empty() && reaches.size() != num_particles) {
    throw InputError("found " + std::to_string(reaches.size()) + " reaches for " + std::to_string(num_particles) +
                     " particles; accepted: one for each, or none");
  }
  if (!(spacing > 0.0 && std::isfinite(spacing))) {
    throw InputError("found a spacing of " + formatShort(spacing) + " m; accepted: a length above 0");
  }
  const std::vector<std::string> problems = checkParams(params);
  if (!problems.empty()) throw InputError(problems);
}

// Whether both ends of a gap may close it.
bool isWithinReach(const std::vector<double>& reaches, Index i, const cloud::Neighbor& other) {
  if (reaches.empty()) return true;
  const double reach = std::min(reaches[i], reaches[other.index]);
  return other.squared_distance <= reach * reach;
}

// 1 where a particle's last look does not hold any more.
std::vector<char> findOutdated(const LocalSurface& surface, const Orientations& orientations, const ProposalMemory& memory) {
  const Index n = surface.size(), before = static_cast<Index>(memory.positions.size());
  Points changed;
  for (Index i = 0; i < n; ++i) {
    const Vec3& p = surface.positions()[i];
    if (i < before && p == memory.positions[i] && orientations[i].coeffs() == memory.orientations[i].coeffs()) continue;
    changed.push_back(p);
    if (i < before) changed.push_back(memory.positions[i]);
  }
  std::vector<char> is_outdated(n, 1);
  if (static_cast<double>(changed.size()) > kMuch * n) return is_outdated;
  const cloud::KdTree tree(changed);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<cloud::Neighbor> nearest;
    for (Index i = begin; i < std::min(end, before); ++i) {
      tree.nearest(surface.positions()[i], 1, nearest);
      const double reach = (1.0 + kRounding) * memory.looks[i].reach;
      is_outdated[i] = !nearest.empty() && nearest.front().squared_distance <= reach * reach;
    }
  });
  return is_outdated;
}

// Calls propose(i, scratch, look) for all particles whose last look does not hold, and returns all proposals, in their order.
template <class Propose>
std::vector<Candidate> collect(const LocalSurface& surface, const Orientations& orientations, ProposalMemory* memory,
                               const Propose& propose) {
  struct Scratch {
    std::vector<cloud::Neighbor> near, found;
  };
  ProposalMemory alone;
  if (!memory) memory = &alone;
  const std::vector<char> is_outdated = findOutdated(surface, orientations, *memory);
  memory->looks.resize(surface.size());
  parallelFor(surface.size(), kBlock, [&](Index begin, Index end) {
    Scratch scratch;
    for (Index i = begin; i < end; ++i) {
      if (!is_outdated[i]) continue;
      memory->looks[i] = {};
      propose(i, scratch, memory->looks[i]);
    }
  });
  memory->looked_at = static_cast<Index>(std::count(is_outdated.begin(), is_outdated.end(), 1));
  memory->positions = surface.positions();
  memory->orientations = orientations;
  std::vector<Candidate> all;
  for (const ProposalMemory::Look& look : memory->looks) all.insert(all.end(), look.proposals.begin(), look.proposals.end());
  return all;
}

// Drops candidates closer than clearance to an earlier one that faces the same way.
std::vector<NewParticle> chooseApart(std::vector<Candidate> candidates, double clearance) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.squared_gap, a.particle.parents[0], a.particle.parents[1]) <
           std::tie(b.squared_gap, b.particle.parents[0], b.particle.parents[1]);
  });
  Points positions, normals;
  for (const Candidate& c : candidates) {
    positions.push_back(c.particle.position);
    normals.push_back(c.particle.orientation * Vec3::UnitZ());
  }
  const cloud::KdTree tree(positions);
  std::vector<char> refused(candidates.size(), 0);
  std::vector<NewParticle> chosen;
  std::vector<cloud::Neighbor> near;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    endIfInterrupted(c, kLook);
    if (refused[c]) continue;
    chosen.push_back(candidates[c].particle);
    tree.withinRadius(positions[c], (1.0 - kRounding) * clearance, near);
    for (const cloud::Neighbor& q : near) {
      if (normals[q.index].dot(normals[c]) > 0.0) refused[q.index] = 1;
    }
  }
  return chosen;
}

// The directions, unit and in its tangent plane, in which particle i has room for a neighbour.
void findOpenDirections(const LocalSurface& surface, Index i, const std::vector<cloud::Neighbor>& near, double range,
                        const GrowthParams& params, std::vector<Vec3>& directions) {
  directions.clear();
  const Vec3 &origin = surface.positions()[i], &normal = surface.normals()[i];
  const Vec3 x_axis = params.chain ? Vec3::UnitY().cross(normal).normalized() : surface.xAxis(i), y_axis = normal.cross(x_axis);
  std::vector<double> angles;  // rad, -pi .. pi, of the neighbours from the x axis
  for (const cloud::Neighbor& q : near) {
    if (q.index == i || !(q.squared_distance <= range * range) || !surface.sees(i, q.index)) continue;
    const Vec3 line = surface.positions()[q.index] - origin;
    angles.push_back(std::atan2(line.dot(y_axis), line.dot(x_axis)));
  }
  const Index count = static_cast<Index>(angles.size());
  if (count < params.min_neighbors || count > params.max_neighbors) return;

  if (params.chain) {
    for (double side : {1.0, -1.0}) {
      const auto isHere = [&](double angle) { return side * std::cos(angle) > 0.0; };
      if (std::none_of(angles.begin(), angles.end(), isHere)) directions.push_back(side * x_axis);
    }
    return;
  }
  if (angles.empty()) angles.push_back(0.0);
  std::sort(angles.begin(), angles.end());
  for (std::size_t a = 0; a < angles.size(); ++a) {
    const double gap = a + 1 < angles.size() ? angles[a + 1] - angles[a] : angles.front() + 2.0 * kPi - angles.back();
    if (!(gap >= params.min_angle && gap <= params.max_angle)) continue;
    const int parts = static_cast<int>(std::lround(gap / kEvenGap));
    for (int part = count == 0 ? 0 : 1; part < parts; ++part) {
      const double angle = angles[a] + gap * part / parts;
      directions.push_back(std::cos(angle) * x_axis + std::sin(angle) * y_axis);
    }
  }
}

}  // namespace

std::vector<NewParticle> proposeStretched(const Points& positions, const Orientations& orientations,
                                          const std::vector<char>& flags, double spacing, const GrowthParams& params,
                                          const std::vector<double>& reaches, const AreApart& apart, ProposalMemory* memory) {
  check(positions.size(), flags, reaches, spacing, params);
  const LocalSurface surface(positions, orientations, apart);
  const double min_clearance = 0.5 * params.min_gap * spacing;
  const double min_gap = (1.0 - kRounding) * params.min_gap * spacing, max_gap = (1.0 + kRounding) * params.max_gap * spacing;

  const auto propose = [&](Index i, auto& scratch, ProposalMemory::Look& look) {
    if (!(flags[i] & kFillsGaps)) return;
    look.reach = max_gap;
    surface.tree().withinRadius(positions[i], max_gap, scratch.near);
    for (const cloud::Neighbor& q : scratch.near) {
      const Index j = q.index;
      if (j <= i || !(flags[j] & kFillsGaps) || !(q.squared_distance >= min_gap * min_gap) || !surface.sees(i, j)) continue;
      if (!isWithinReach(reaches, i, q)) continue;
      const Vec3 middle = 0.5 * (positions[i] + positions[j]), normal = surface.normals()[i] + surface.normals()[j];
      const double half = 0.5 * std::sqrt(q.squared_distance);
      const double clearance = (1.0 - kRounding) * std::max(min_clearance, kWideClearance * half);
      const Index parents[2] = {i, j};
      const auto isInTheWay = [&](const cloud::Neighbor& other) {  // all that can be are within max_gap of i
        return other.index != i && other.index != j && surface.normals()[other.index].dot(normal) > 0.0 &&
               (positions[other.index] - middle).squaredNorm() <= clearance * clearance;
      };
      if (std::any_of(scratch.near.begin(), scratch.near.end(), isInTheWay)) continue;
      const Placed placed = surface.place(middle, half, parents, scratch.found);
      look.reach =
          std::max({look.reach, half + LocalSurface::reachOf(half),
                    (placed.position - positions[i]).norm() + std::max(std::hypot(clearance, half), kWitnesses * spacing)});
      if (!surface.sees(i, placed) || !surface.sees(j, placed)) continue;
      if (!surface.isClear(placed.position, normal, min_clearance, parents, scratch.found)) continue;
      // Seen along the normal: below a bridge over a valley, and above a cut through a ridge, there is no gap.
      if (params.witnessed && half > min_clearance &&
          !surface.isOpen(placed.position, normal, clearance, half, parents, scratch.found))
        continue;
      if (params.witnessed && !surface.fits(placed, kWitnesses * spacing, scratch.found)) continue;
      look.proposals.push_back({q.squared_distance, {placed.position, placed.orientation, {i, j}}});
    }
  };
  return chooseApart(collect(surface, orientations, memory, propose), min_clearance);
}

std::vector<NewParticle> proposeGrown(const Points& positions, const Orientations& orientations, const std::vector<char>& flags,
                                      double spacing, const GrowthParams& params, const std::vector<double>& reaches,
                                      const AreApart& apart, ProposalMemory* memory) {
  check(positions.size(), flags, reaches, spacing, params);
  const LocalSurface surface(positions, orientations, apart);
  const double range = params.neighbor_range * spacing, max_gap = params.max_gap * spacing;
  const double clearance = params.clearance * spacing;

  const auto propose = [&](Index i, auto& scratch, ProposalMemory::Look& look) {
    if (flags[i] == kGrowsNothing) return;
    look.reach =
        std::max({range, max_gap, spacing + LocalSurface::reachOf(spacing), spacing + std::max(clearance, kWitnesses * spacing)});
    const Vec3& normal = surface.normals()[i];
    surface.tree().withinRadius(positions[i], std::max(range, max_gap), scratch.near);
    std::vector<Vec3> directions;
    findOpenDirections(surface, i, scratch.near, range, params, directions);
    for (const Vec3& direction : directions) {
      const auto isAhead = [&](const cloud::Neighbor& q) {
        if (q.index == i || !(q.squared_distance <= max_gap * max_gap) || !isWithinReach(reaches, i, q)) return false;
        if (!surface.sees(i, q.index)) return false;
        const Vec3 line = positions[q.index] - positions[i], on = line - line.dot(normal) * normal - spacing * direction;
        return on.dot(-direction) <= kAhead * on.norm();
      };
      if (!(flags[i] & kExtendsEdge) && std::none_of(scratch.near.begin(), scratch.near.end(), isAhead)) continue;
      const Index parents[2] = {i, -1};
      Placed placed = surface.place(positions[i] + spacing * direction, spacing, parents, scratch.found);
      placed.position = positions[i] + spacing * (placed.position - positions[i]).normalized();
      if (!surface.sees(i, placed)) continue;
      if (!surface.isClear(placed.position, normal, clearance, parents, scratch.found)) continue;
      if (params.witnessed && !surface.fits(placed, kWitnesses * spacing, scratch.found)) continue;
      look.proposals.push_back({0.0, {placed.position, placed.orientation, {i, -1}}});
    }
  };
  return chooseApart(collect(surface, orientations, memory, propose), clearance);
}

void leaveOutCrowded(const Points& positions, double distance, std::vector<NewParticle>& newborn) {
  if (newborn.empty()) return;
  const double least = (1.0 - kRounding) * distance;
  const cloud::KdTree tree(positions);
  std::vector<cloud::Neighbor> nearest;
  const auto isCrowded = [&](const NewParticle& particle) {
    tree.nearest(particle.position, 1, nearest);
    return !(nearest.front().squared_distance >= least * least);
  };
  newborn.erase(std::remove_if(newborn.begin(), newborn.end(), isCrowded), newborn.end());
}

}  // namespace deformable_surface::model
