// A surface is grown through the particles that there are, before time 0 or by a command: growth to its end, then relaxation.
#include "particle_life.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/grow_surface.h"
#include "deformable_surface/model/oriented_particles/relax_on_surface.h"

#include <algorithm>
#include <cmath>

#include "../../rest_parts.h"
#include "approach_samples.h"
#include "settle_particles.h"

namespace deformable_surface::simulation {
namespace {

using model::State;

constexpr Index kSweeps = 20;     // between two passes of growth: near equilibrium is enough
constexpr Index kSmoothings = 4;  // of rest curvatures if samples are noisy: about the distance between samples
// Of the spacing: the growth rules leave a looser arrangement than a lattice, which would contract when released.
constexpr double kDensity = 0.95;
constexpr Index kLastIterations = 40;    // the same when growth has ended
constexpr double kLastTolerance = 1e-4;  // of its first force
constexpr double kClosest = 0.3;         // of the spacing: as near as particles may be after growth, as after an edit

// Growth leaves varying distances, and not the area of as many particles of a lattice. At the stated spacing the whole surface
// would pull, and closed surfaces would contract. Particles slide until they are evenly spaced, and the
// lattice takes the spacing at which they have no tension as a whole.
void takeSpacingOf(const HeldPoints& fixed, model::OrientedParticles& particles, State& state) {
  cloud::CleanCloud surface;
  surface.positions = state.positions;
  for (const Quaternion& q : state.orientations) surface.normals.push_back(q * Vec3::UnitZ());
  model::OrientedParticles attraction = particles;
  const double even = attraction.measureSpacing(state);
  if (even > 0.0) attraction.setSpacing(even);
  attraction.leaveOnlyAttraction();
  slideParticles(surface, attraction, fixed, state);
  particles.setSpacing(particles.findSpacingWithoutTension(state));
}

// Tells of particles that are on no triangle. Beside a grown surface, samples there did not tell which way it goes.
template <class Warn>
void warnOfLonely(const model::OrientedParticles& particles, const State& state, const Warn& warn) {
  particles.refreshDisplay(state);
  std::vector<char> is_lonely(state.positions.size(), 1);
  for (const model::WeightedTriangle& t : particles.triangles())
    for (const Index i : t.corner) is_lonely[i] = 0;
  const auto first = std::find(is_lonely.begin(), is_lonely.end(), 1);
  if (first == is_lonely.end()) return;
  const Index count = static_cast<Index>(std::count(is_lonely.begin(), is_lonely.end(), 1));
  warn(std::to_string(count) + (count == 1 ? " particle belongs" : " particles belong") + " to no surface, the first at " +
       formatPlace(state.positions[first - is_lonely.begin()]) + " m");
}

// Samples that are farther than a distance, m, from all others.
Index countAlone(const Points& samples, double distance) {
  const cloud::KdTree tree(samples);
  std::vector<cloud::Neighbor> nearest;
  Index count = 0;
  for (const Vec3& p : samples) {
    tree.nearest(p, 2, nearest);  // the sample is one of them
    count += nearest.size() < 2 || nearest.back().squared_distance > distance * distance;
  }
  return count;
}

// Tells that particles will move by themselves. held: of those that there are at first; samples held in growth alone are free.
template <class Warn>
void warnOfUnrest(model::OrientedParticles& particles, std::vector<char> held, const State& state, const Warn& warn) {
  held.resize(state.positions.size(), 0);
  particles.adopt(state);
  const double unrest = findUnrest(particles, held, state);
  if (unrest > 0.0)
    warn(
        "particles were led towards rest after growth; they are not at rest, for none was found near the samples: without loads "
        "the first to move starts with " +
        formatShort(unrest) + " m/s^2");
}

// Tells that the surface has left its samples, (m x 3) m. Samples with little room between them leave particles farther apart
// than they rest, and denser ones nearer: the surface then shrinks, widens or tears as it relaxes.
template <class Warn>
void warnOfLeftSamples(const Points& samples, double noise, double spacing, bool keeps_shape, const State& state,
                       const Warn& warn) {
  // Of the spacing, root of the mean square: a lattice on the samples has 0.37. Noise, in spacings, comes to it.
  constexpr double kFar = 0.6;
  const cloud::KdTree tree(state.positions), among(samples);
  std::vector<cloud::Neighbor> nearest;
  std::vector<double> apart;
  double squares = 0.0, most = 0.0;
  Vec3 place = Vec3::Zero();
  for (const Vec3& sample : samples) {
    among.nearest(sample, 2, nearest);
    apart.push_back(std::sqrt(nearest.back().squared_distance));
    tree.nearest(sample, 1, nearest);
    const double squared = nearest.front().squared_distance;
    squares += squared;
    if (squared <= most) continue;
    most = squared;
    place = sample;
  }
  const double far = std::sqrt(squares / static_cast<double>(samples.size()));
  if (!(far > std::hypot(kFar, noise) * spacing)) return;
  warn("the grown surface has left its samples by " + formatShort(far / spacing) + " spacings (rms of their distances from the " +
       "nearest particles; " + formatShort(std::sqrt(most) / spacing) + " at " + formatPlace(place) + " m): " +
       (keeps_shape ? "samples are " + formatShort(findMedian(std::move(apart)) / spacing) +
                          " spacings from the next (median); another oriented_particles.spacing may do better"
                    : "oriented_particles.rest_shape cloud keeps it there"));
}

// Moves particles nearer to each other than a distance, m, apart to it along the line between them, those in one place along the
// x axis of the first. Growth and relaxation on both sides of something thin can bring two into nearly one place, where repulsion
// does not part them. fixed (n) stay. One after the other, in the order of their numbers. Returns the number of pairs that are
// still nearer.
Index moveApart(double least, const std::vector<char>& fixed, State& state) {
  constexpr Index kPasses = 50;
  constexpr double kBeyond = 1e-6;  // of the distance: rounding must not undo it
  Index near_pairs = 0;
  std::vector<cloud::Neighbor> near;
  for (Index pass = 0; pass <= kPasses; ++pass) {
    endIfInterrupted();
    near_pairs = 0;
    const cloud::KdTree tree(state.positions);
    for (Index i = 0; i < state.size(); ++i) {
      tree.withinRadius(state.positions[i], least, near);
      std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
      for (const cloud::Neighbor& q : near) {
        const Index j = q.index;
        if (j <= i) continue;
        Vec3 line = state.positions[j] - state.positions[i];
        const double distance = line.norm();
        if (!(distance < least)) continue;
        ++near_pairs;
        if (pass == kPasses || (fixed[i] && fixed[j])) continue;
        line = distance > 0.0 ? Vec3(line / distance) : Vec3(state.orientations[i] * Vec3::UnitX());
        const double missing = (1.0 + kBeyond) * least - distance;
        const double share = fixed[i] ? 0.0 : fixed[j] ? 1.0 : 0.5;  // of particle i
        state.positions[i] -= share * missing * line;
        state.positions[j] += (1.0 - share) * missing * line;
      }
    }
    if (near_pairs == 0) break;
  }
  return near_pairs;
}

}  // namespace

Population ParticleLife::growSurface(const model::GrowthParams& given, const std::vector<char>& held,
                                     const std::vector<char>& held_turns, bool is_start, State& state) {
  if (model_.hasKeptBonds())
    throw InputError(
        "grow_surface: found oriented_particles.bonds kept, with which new particles have no rest shape; accepted: free");
  model::GrowthParams growth = given;
  growth.chain = growthParams().chain;
  const bool keeps_shape = model_.params().restsAsCloud(), lets_go = !growth.fix_samples || growth.release_samples;
  const double spacing = kDensity * model_.lattice().spacing;
  const auto relax = [&](Points& positions, Orientations& orientations, const std::vector<char>& still,
                         std::vector<char>* awake) {
    std::vector<char> fixed = still;
    for (std::size_t i = 0; i < held.size(); ++i) fixed[i] = fixed[i] || held[i];
    model::relaxOnSurface(spacing, kSweeps, fixed, positions, orientations, awake);
  };
  model::ParticleCuts cuts = model_.cuts();
  std::vector<model::ParticleTraits> traits = state.traits;
  model::GrowthCuts growth_cuts;
  if (!cuts.isEmpty()) {
    growth_cuts.apart = [&](Index i, Index j) { return !cuts.mayBind(traits[i].id, traits[j].id); };
    growth_cuts.follow = [&](const Points& positions, Index first, const std::vector<model::NewParticle>& added) {
      std::vector<model::ParticleCuts::Pair> parents;
      for (const model::NewParticle& particle : added) {
        parents.emplace_back(particle.parents[0], particle.parents[1]);
        traits.emplace_back();
        traits.back().id = state.next_id + static_cast<Index>(traits.size() - 1 - state.traits.size());  // as append() numbers
      }
      cuts = cuts.inherit(positions, traits, first, parents, model_.cutLengths());
    };
  }
  const Points samples = state.positions;
  Points sample_normals;
  for (const Quaternion& q : state.orientations) sample_normals.push_back(q * Vec3::UnitZ());
  const model::GrownSurface grown = model::growSurface(state.positions, state.orientations, spacing, growth, relax, growth_cuts);

  // Made in copies: an interrupt leaves what was there.
  Population changes;
  const std::size_t before = state.positions.size();
  State after = state;
  for (const model::NewParticle& particle : grown.added) append(particle, after);
  after.positions = grown.positions;
  after.orientations = grown.orientations;
  // A separate dynamics for the particles alone, without loads.
  HeldPoints fixed{held, held_turns};
  for (std::vector<char>* which : {&fixed.places, &fixed.turns}) {
    which->resize(after.positions.size(), 0);
    if (!lets_go) std::fill_n(which->begin(), before, char{1});
  }
  model::OrientedParticles particles = model_;
  particles.setCuts(cuts);
  particles.adopt(after);
  State trial = after;
  if (keeps_shape && is_start) takeSpacingOf(fixed, particles, trial);
  if (keeps_shape) particles.keepShape(trial);
  if (keeps_shape && growth.noise > 0.0) particles.smoothShape(kSmoothings, trial);
  // Existing particles keep their motion and, except at the start, their rest shape: their bending may come from a load.
  for (std::size_t i = 0; !is_start && i < before; ++i) trial.traits[i].rest_curvature = after.traits[i].rest_curvature;
  const double rest_spacing = particles.lattice().spacing, least = kClosest * rest_spacing;
  moveApart(least, fixed.places, trial);
  const bool remembers = keeps_shape && is_start && !(growth.noise > 0.0);
  if (remembers && lets_go && !growth.chain && before > 0 &&
      !areNoisy(findSampleOffsets(samples, sample_normals, rest_spacing, trial), rest_spacing)) {
    settleOnSamples(samples, sample_normals, fixed, particles, trial);
  } else if (remembers) {
    relaxInShape(particles, fixed, trial);
  } else {
    relaxParticles(particles, fixed, kLastIterations, kLastTolerance, trial);
  }
  const Index near_pairs = moveApart(least, fixed.places, trial);
  after.positions = trial.positions;
  after.orientations = trial.orientations;
  after.traits = trial.traits;
  changes.born = static_cast<Index>(after.positions.size() - before);
  static const char* const kEnds[] = {"until there was no more room", "until growth.max_passes was reached",
                                      "until another pass would have gone beyond growth.max_particles"};
  const double widest = growth.max_gap * spacing;
  const Index num_alone = grown.end == model::GrowthEnd::kNoRoom && before > 1 ? countAlone(samples, widest) : 0;
  const char* const end =
      num_alone > 0 ? "until all gaps that were left were wider than growth.max_gap" : kEnds[static_cast<int>(grown.end)];
  changes.notice = "a surface is grown: " + std::to_string(changes.born) + " particles were added to " + std::to_string(before) +
                   " in " + std::to_string(grown.passes) + " passes, " + end;
  const auto warn = [&](const std::string& sentence) { appendNotice(changes.warning, sentence); };
  if (num_alone > 0)
    warn(std::to_string(num_alone) + " of " + std::to_string(before) +
         " samples are farther from all others than growth.max_gap, " + formatShort(growth.max_gap) + " spacings (" +
         formatShort(widest) + " m): growth joins them to nothing; a larger growth.max_gap or oriented_particles.spacing does");
  if (grown.end == model::GrowthEnd::kMaxPasses)
    warn("growth ended at growth.max_passes, " + std::to_string(growth.max_passes) + ": the surface is not complete");
  if (grown.end == model::GrowthEnd::kMaxParticles)
    warn("growth ended at growth.max_particles, " + std::to_string(growth.max_particles) + ": the surface is not complete");
  if (!growth.chain) warnOfLonely(particles, after, warn);
  if (is_start) warnOfUnrest(particles, held, trial, warn);
  if (is_start) warnOfLeftSamples(samples, growth.noise, rest_spacing, keeps_shape, after, warn);
  if (near_pairs > 0)
    appendNotice(changes.notice, std::to_string(near_pairs) + " pairs of held particles are nearer to each other than " +
                                     formatShort(kClosest) + " of the spacing, where repulsion hardly parts them");
  model_.setCuts(cuts);
  if (keeps_shape && is_start) model_.setSpacing(particles.lattice().spacing);
  state = std::move(after);
  return changes;
}

}  // namespace deformable_surface::simulation
