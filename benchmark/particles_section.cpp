// Part 9: time of a force pass of the oriented particles per pair, and its growth with their number. The sum over all pairs of
// the paper's section 4.2 is measured, too; it is also the reference of the forces.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "sections.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::benchmark {
namespace {

using model::OrientedParticles;
using model::PairPotentials;
using model::State;

constexpr double kSpacing = 0.01;  // m
constexpr Index kCompared = 200;   // particles whose force is compared with the sum over all others

double randomNumber(std::mt19937& generator) { return static_cast<double>(generator()) / 2147483648.0 - 1.0; }

// A square patch of the hexagonal lattice, row by row or in random order, wavy and jittered.
State makeWavyPatch(Index n, bool is_shuffled) {
  std::mt19937 generator(3);
  const Index across = static_cast<Index>(std::lround(std::sqrt(n * std::sqrt(0.75))));
  std::vector<Index> order(n);
  for (Index i = 0; i < n; ++i) order[i] = i;
  for (Index i = n - 1; is_shuffled && i > 0; --i) std::swap(order[i], order[generator() % (i + 1)]);
  State s;
  s.positions.resize(n);
  s.velocities.assign(n, Vec3::Zero());
  s.orientations.resize(n);
  s.spins = s.velocities;
  s.traits.resize(n);
  for (Index k = 0; k < n; ++k) {
    const Index row = k / across, column = k % across;
    const Vec3 shake(randomNumber(generator), randomNumber(generator), randomNumber(generator));
    Vec3& p = s.positions[order[k]];
    p = kSpacing * (Vec3(column + 0.5 * (row % 2), row * std::sqrt(0.75), 0.0) + 0.05 * shake);
    p.z() += kSpacing * std::sin(0.2 * p.x() / kSpacing);
    const Vec3 axis(randomNumber(generator), randomNumber(generator), randomNumber(generator));
    s.orientations[order[k]] = Quaternion(Eigen::AngleAxisd(0.3 * axis.norm(), axis.normalized()));
  }
  return s;
}

OrientedParticles makeParticles(const State& s, model::ParticleWeighting weighting) {
  model::OrientedParticlesParams params;
  params.co_circularity = 1.0;
  params.weighting = weighting;
  return OrientedParticles(s.positions, Points(s.positions.size(), Vec3::UnitZ()), kSpacing, {}, params);
}

// The normal of every particle.
Points findNormals(const State& s) {
  Points normals;
  for (const Quaternion& q : s.orientations) normals.push_back(q * Vec3::UnitZ());
  return normals;
}

// The force on particle i from all others in turn: plain sums of minus the gradients, both orders of a pair, nothing shared.
Vec3 sumOverAll(const PairPotentials& p, const Points& positions, const Points& normals, Index i) {
  Vec3 force = Vec3::Zero();
  const double most = p.cutoff * p.cutoff;
  for (Index j = 0; j < static_cast<Index>(positions.size()); ++j) {
    const Vec3 r = positions[j] - positions[i];
    const double squared = r.squaredNorm();
    if (!(squared < most) || j == i) continue;
    const double d = std::sqrt(squared);
    double on, on_slope, phi, phi_slope;
    model::switchOff(p, d, on, on_slope);
    model::evaluateLennardJones(p, d, 1.0 / d, on, on_slope, phi, phi_slope);
    force += 2.0 * phi_slope / d * r;
    for (const Vec3* n : {&normals[i], &normals[j]}) {
      const double u = n->dot(r), s = (normals[i] + normals[j]).dot(r), q = (normals[i] - normals[j]).squaredNorm();
      double psi;
      Vec3 slope;
      if (p.is_anisotropic) {
        const double bell = std::exp(-0.5 * p.inverse_width * (squared - u * u) - 0.5 * p.inverse_height * u * u);
        psi = on * bell;
        slope = bell * on_slope / d * r - psi * (p.inverse_width * (r - u * *n) + p.inverse_height * u * *n);
      } else {
        double slope_by_distance;
        model::weighByDistance(p, squared, psi, slope_by_distance);
        slope = slope_by_distance * r;
      }
      force += (p.co_planarity * u * u + p.co_normality * q + p.co_circularity * s * s) * slope;
      force += 2.0 * psi * (p.co_planarity * u * *n + p.co_circularity * s * (normals[i] + normals[j]));
    }
  }
  return force;
}

// Largest difference of the forces from the sums over all others, over the largest force.
double compareWithSums(const OrientedParticles& particles, const State& s, const Points& forces) {
  const Points normals = findNormals(s);
  const Index n = s.size(), stride = std::max(Index{1}, n / kCompared);
  double difference = 0.0, largest = 0.0;
  for (Index i = 0; i < n; i += stride) {
    difference = std::max(difference, (forces[i] - sumOverAll(particles.lattice().pair, s.positions, normals, i)).norm());
    largest = std::max(largest, forces[i].norm());
  }
  return difference / largest;
}

Index countPairs(const OrientedParticles& particles, const State& s) {
  model::NeighborList lists(particles.lattice().pair.cutoff, 1e-9);
  lists.update(s.positions);
  Index ends = 0;
  for (Index i = 0; i < s.size(); ++i) ends += static_cast<Index>(lists.end(i) - lists.begin(i));
  return ends / 2;
}

}  // namespace

void runParticlesSection(const Options& options, Report& report) {
  setNumThreads(1);
  report.begin("particles", "9. Oriented particles: a force pass with all four potentials on one core",
               {"particles", "order", "weighting", "pairs", "wall_ms", "spread_%", "cpu_ms", "ns_per_pair", "rebuild_cpu_ms",
                "bytes_per_particle", "force_error"});
  std::vector<Index> sizes{1000, 4000, 16000, 64000};
  if (options.large) sizes.insert(sizes.end(), {250000, 1000000});
  std::vector<double> counts, passes;
  struct Row {
    Index n;
    bool is_shuffled;
    model::ParticleWeighting weighting;
  };
  std::vector<Row> rows;
  for (Index n : sizes) rows.push_back({n, false, model::ParticleWeighting::kIsotropic});
  for (Index n : {sizes[0], sizes[2], sizes.back()}) rows.push_back({n, false, model::ParticleWeighting::kAnisotropic});
  rows.push_back({sizes.back(), true, model::ParticleWeighting::kIsotropic});
  for (const Row& row : rows) {
    const State s = makeWavyPatch(row.n, row.is_shuffled);
    const OrientedParticles particles = makeParticles(s, row.weighting);
    Points forces(row.n, Vec3::Zero()), torques(row.n, Vec3::Zero());
    particles.addForcesAndTorques(s, forces, torques);
    const double error = compareWithSums(particles, s, forces);
    const Timing pass = measure([&] { particles.addForcesAndTorques(s, forces, torques); }, options.budget);
    const bool is_plain = !row.is_shuffled && row.weighting == model::ParticleWeighting::kIsotropic;
    if (is_plain) {
      counts.push_back(row.n);
      passes.push_back(pass.cpu);
    }
    // All particles there and back again, farther than half the skin each time.
    const double skin = 0.3 * particles.lattice().pair.distance;
    Points moved = s.positions;
    for (Vec3& p : moved) p.x() += skin;
    model::NeighborList lists(particles.lattice().pair.cutoff, skin);
    bool is_moved = false;
    const Timing rebuild = measure([&] { lists.update((is_moved = !is_moved) ? moved : s.positions); }, options.budget);
    const Index pairs = countPairs(particles, s);
    report.add({std::to_string(row.n), row.is_shuffled ? "random" : "rows",
                row.weighting == model::ParticleWeighting::kIsotropic ? "isotropic" : "anisotropic", std::to_string(pairs),
                showMilliseconds(pass.wall), showPercent(pass.spread), showMilliseconds(pass.cpu), show(1e9 * pass.cpu / pairs),
                showMilliseconds(rebuild.cpu), show(static_cast<double>(particles.bytes()) / row.n), show(error)});
  }
  report.end();
  report.note("a pair is one within the cutoff, counted once; the pass computes it from both of its ends; ns_per_pair by cpu");
  report.note("force_error: against the sum over all other particles at " + std::to_string(kCompared) +
              " of them, over the largest force; bytes: lists and copies, without the state");
  report.note("cpu time grows as n to the power " + show(fitExponent(counts, passes)));

  report.begin("particles_all_pairs", "The same forces by the sum over all pairs",
               {"particles", "wall_ms", "spread_%", "cpu_ms"});
  counts.clear();
  passes.clear();
  for (Index n : {1000, 2000, 4000}) {
    const State s = makeWavyPatch(n, false);
    const OrientedParticles particles = makeParticles(s, model::ParticleWeighting::kIsotropic);
    const Points normals = findNormals(s);
    Points forces(n);
    const Timing pass = measure(
        [&] {
          for (Index i = 0; i < n; ++i) forces[i] = sumOverAll(particles.lattice().pair, s.positions, normals, i);
        },
        options.budget);
    counts.push_back(n);
    passes.push_back(pass.cpu);
    report.add({std::to_string(n), showMilliseconds(pass.wall), showPercent(pass.spread), showMilliseconds(pass.cpu)});
  }
  report.end();
  report.note("cpu time grows as n to the power " + show(fitExponent(counts, passes)));
  setNumThreads(0);
}

}  // namespace deformable_surface::benchmark
