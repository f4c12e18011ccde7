// The loop over passes; the rules are in growth.cpp.
#include "deformable_surface/model/oriented_particles/grow_surface.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kNearest = 4;        // neighbours whose distance gives the density of samples: one close pair does not matter
constexpr double kLeastReach = 2.5;  // spacings: as published
// For noisy samples: further passes remove less than the defects of a lattice add at rest.
constexpr Index kMostReleases = 6;

// The widest gap, m, that each sample closes; empty if it is the same for all.
std::vector<double> findReaches(const Points& samples, double spacing, const GrowthParams& params) {
  std::vector<double> reaches;
  if (!(params.sample_gap > 0.0)) return reaches;
  const cloud::KdTree tree(samples);
  std::vector<cloud::Neighbor> nearest;
  for (const Vec3& p : samples) {
    tree.nearest(p, kNearest + 1, nearest);  // the sample is one of them
    const double distance = nearest.empty() ? 0.0 : std::sqrt(nearest.back().squared_distance);
    reaches.push_back(std::max(kLeastReach * spacing, params.sample_gap * distance));
  }
  return reaches;
}

// Root mean square, m, of the displacement of samples along their normals.
double measureRise(const Points& samples, const Points& positions, const Orientations& orientations) {
  double squares = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double rise = (positions[i] - samples[i]).dot(orientations[i] * Vec3::UnitZ());
    squares += rise * rise;
  }
  return std::sqrt(squares / static_cast<double>(samples.size()));
}

}  // namespace

GrownSurface growSurface(const Points& positions, const Orientations& orientations, double spacing, const GrowthParams& given,
                         const Relaxation& relax, const GrowthCuts& cuts) {
  GrowthParams params = given;
  params.witnessed = true;
  GrownSurface surface;
  surface.positions = positions;
  surface.orientations = orientations;
  std::vector<Index> row(positions.size(), 0);
  std::vector<char> fixed(positions.size(), params.fix_samples), awake(positions.size(), 1);

  std::vector<double> reaches = findReaches(positions, spacing, params);

  const auto makeFlags = [&] {
    std::vector<char> flags;
    for (Index r : row) {
      const bool fills = r < params.edge_rows + 0.5 * params.max_gap + 1.0, extends = r < params.edge_rows;
      flags.push_back((fills ? kFillsGaps : kGrowsNothing) | (extends ? kExtendsEdge : kGrowsNothing));
    }
    return flags;
  };
  const auto add = [&](const NewParticle& particle) {
    const auto& [first, second] = particle.parents;
    row.push_back(second < 0 ? row[first] + 1 : std::max(row[first], row[second]));
    fixed.push_back(0);
    awake.push_back(1);
    if (!reaches.empty()) reaches.push_back(second < 0 ? reaches[first] : std::max(reaches[first], reaches[second]));
    surface.positions.push_back(particle.position);
    surface.orientations.push_back(particle.orientation);
    surface.added.push_back(particle);
  };

  ProposalMemory stretched, grown;
  const auto remember = [&](ProposalMemory& memory) { return cuts.apart ? nullptr : &memory; };
  for (;;) {
    endIfInterrupted();
    std::vector<NewParticle> found = proposeStretched(surface.positions, surface.orientations, makeFlags(), spacing, params,
                                                      reaches, cuts.apart, remember(stretched));
    leaveOutCrowded(surface.positions, params.clearance * spacing, found);
    if (found.empty()) {
      found = proposeGrown(surface.positions, surface.orientations, makeFlags(), spacing, params, reaches, cuts.apart,
                           remember(grown));
      leaveOutCrowded(surface.positions, params.clearance * spacing, found);
    }
    if (found.empty()) break;
    if (surface.passes == params.max_passes) {
      surface.end = GrowthEnd::kMaxPasses;
      break;
    }
    if (surface.positions.size() + found.size() > static_cast<std::size_t>(params.max_particles)) {
      surface.end = GrowthEnd::kMaxParticles;
      break;
    }
    const Index first = static_cast<Index>(surface.positions.size());
    for (const NewParticle& particle : found) add(particle);
    if (cuts.follow) cuts.follow(surface.positions, first, found);
    ++surface.passes;
    relax(surface.positions, surface.orientations, fixed, &awake);
  }

  if (params.fix_samples && params.release_samples) {
    const std::vector<char> none(surface.positions.size(), 0);
    Index releases = 0;
    do relax(surface.positions, surface.orientations, none, nullptr);
    while (++releases < kMostReleases &&
           measureRise(positions, surface.positions, surface.orientations) < params.noise * spacing);
  }
  return surface;
}

}  // namespace deformable_surface::model
