// Grows a surface through given particles: alternates the two growth rules until neither finds room, with the model's relaxation
// between them.
#pragma once

#include "deformable_surface/model/oriented_particles/growth.h"

#include <functional>

namespace deformable_surface::model {

/// Brings particles near their equilibrium, in place. The rules assume surroundings near equilibrium. A function that does
/// nothing is allowed. fixed (n): 1 = does not move or turn. awake (n); null: all move. Before: 1 = new, or still moving at the
/// end of the last relaxation. After: 1 = still moving.
using Relaxation =
    std::function<void(Points& positions, Orientations& orientations, const std::vector<char>& fixed, std::vector<char>* awake)>;

/// Growth on a surface that is cut. Empty functions: nothing is cut.
struct GrowthCuts {
  AreApart apart;  // also of particles added before
  /// The particles from index first on are new.
  std::function<void(const Points& positions, Index first, const std::vector<NewParticle>& added)> follow;
};

enum class GrowthEnd { kNoRoom, kMaxPasses, kMaxParticles };

struct GrownSurface {
  Points positions;  // the given particles in their order, then the new ones in theirs
  Orientations orientations;
  std::vector<NewParticle> added;  // as they were when added; parents as indices into positions
  Index passes = 0;                // that added something
  GrowthEnd end = GrowthEnd::kNoRoom;
};

/// Fits a surface to particles [Szeliski and Tonnesen 1991, sec. 7]. A pass applies the stretching rule, which interpolates, and
/// the growing rule only where the stretching rule finds nothing at all. Rows are counted: given particles are row 0; a grown one
/// is in the row after its parent's, one between two in the larger of their rows. Rows below params.edge_rows grow outwards.
/// Particles fill gaps up to half of max_gap and one row beyond: a gap's sides are that far from its middle. Growth ends: added
/// particles are near the samples and keep their distance, and a closed surface has no gaps. Else it ends at the stated maxima,
/// and says so. Released samples (fix_samples and release_samples) are relaxed once. If that does not remove their stated noise,
/// they are relaxed again until they have moved that far along their normals (Morozov's discrepancy principle), at most six
/// times. Given particles that lie farther from all others than max_gap stay alone unless edge_rows lets them grow. Deterministic
/// if relax is. Throws InputError.
GrownSurface growSurface(const Points& positions, const Orientations& orientations, double spacing, const GrowthParams& params,
                         const Relaxation& relax, const GrowthCuts& cuts = {});

}  // namespace deformable_surface::model
