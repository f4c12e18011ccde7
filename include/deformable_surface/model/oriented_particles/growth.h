// Where a surface of oriented particles gets new ones: the stretching rule, the growing rule, and the place of a new particle
// on the surface of its neighbours. One pass each, as pure geometry. The caller handles forces and time.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/oriented_particles/growth_params.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <vector>

namespace deformable_surface::model {

/// What a particle may do in a pass. Particles without flags still take room and shape the surface around them.
enum GrowthFlag : char {
  kGrowsNothing = 0,
  kFillsGaps = 1,    // be a parent where another side lies within max_gap
  kExtendsEdge = 2,  // grow into the open as well
};

struct NewParticle {
  Vec3 position;  // m
  Eigen::Quaterniond orientation;
  Index parents[2];  // the second is -1 if it grew from one alone
};

/// What one rule has found, for its next call with the same spacing and parameters: it then looks only at particles around which
/// something has changed, with the same result. Flags and reaches of particles that there were must be the same, and none apart.
struct ProposalMemory {
  struct Proposal {
    double squared_gap;  // m^2: the order of proposals before their indices; the growing rule has none
    NewParticle particle;
  };
  struct Look {
    double reach = 0.0;  // m: what is farther from the particle had no part in it
    std::vector<Proposal> proposals;
  };

  Points positions;  // (n x 3) m, of the last call
  Orientations orientations;
  std::vector<Look> looks;  // (n)
  Index looked_at = 0;      // number of particles in the last call
};

/// The stretching rule [Szeliski and Tonnesen 1991, sec. 7]: two particles at d_min <= d <= d_max, both with kFillsGaps, get one
/// halfway between them if no other lies within d_min / 2 of it. Pairs farther apart than the published d_max of 2.5 spacings
/// (params.max_gap above it) need four fifths of d / 2 clear, which at that distance equals the published rule: only the two
/// sides of a gap are joined. The pair must see each other: normals less than 90 degrees apart, and their line at most 30 degrees
/// from the plane of the mean normal. Each must see the new one as well. Of candidates closer than d_min / 2 to each other
/// the one with the smaller d stays, then that with the smaller indices.
///
/// params.witnessed, for either rule: all particles within one and a half spacings of a new one facing its way must see it. For
/// a pair farther apart than min_gap no particle may lie above or below the new one, within d / 2: where the line between them
/// crosses a valley or a ridge there is no gap.
///
/// positions (n x 3) m; orientations, flags (n); spacing: r0, m, > 0; reaches (n or none): the widest gap, m, that a particle
/// closes if that is less than max_gap; apart: particles that do not see each other, called in parallel; memory: none, or of
/// the last call. In the order of acceptance. Parallel; O(n (log n + k^2)) for k particles within max_gap. Throws InputError.
std::vector<NewParticle> proposeStretched(const Points& positions, const Orientations& orientations,
                                          const std::vector<char>& flags, double spacing, const GrowthParams& params,
                                          const std::vector<double>& reaches = {}, const AreApart& apart = {},
                                          ProposalMemory* memory = nullptr);

/// The growing rule [sec. 7]: a particle with n_min to n_max neighbours (within neighbor_range, and seen) fills every gap between
/// successive neighbours of theta_min to theta_max, seen along its normal, with round(gap / 60 degrees) - 1 particles at r0,
/// evenly. Without a neighbour the gap is the full turn, from its x axis. A particle with kFillsGaps grows towards others
/// within max_gap (the new one sees the two at an angle of 154 degrees or more), one with kExtendsEdge also outwards. Candidates
/// closer than clearance to a particle are dropped; of two that are so close to each other the one from the smaller index,
/// then from the earlier gap, stays. In a chain the directions are the two of the curve, each open if it has no neighbour.
std::vector<NewParticle> proposeGrown(const Points& positions, const Orientations& orientations, const std::vector<char>& flags,
                                      double spacing, const GrowthParams& params, const std::vector<double>& reaches = {},
                                      const AreApart& apart = {}, ProposalMemory* memory = nullptr);

/// Drops new particles nearer than a distance, m, to any given particle, whichever way it faces. The rules only see particles
/// that face the same way; nearer to any other, repulsion would throw the new one off.
void leaveOutCrowded(const Points& positions, double distance, std::vector<NewParticle>& newborn);

}  // namespace deformable_surface::model
