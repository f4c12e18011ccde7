#include "approach_samples.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 64;
constexpr Index kAround = 6;     // samples that say where the surface is: as many as lie around one
constexpr Index kLookedAt = 12;  // nearest ones among which those that face the same way are taken
constexpr double kFacing = 0.3;  // least cosine between the normals of a particle and of its samples
constexpr double kReach = 0.4;   // of the distance of the farthest of them: where weights have fallen to exp(-1/2)
constexpr double kLevel = 0.5;   // weight of a level plane: slopes of few samples are uncertain, above all at a border
constexpr double kNoisy = 0.07;  // spacings: scatter of samples about their planes above which they are noisy, or at an edge
constexpr double kMostScattered = 1.0 / 3.0;  // of the particles: 0.31 at most on a knot, 0.40 at least on a bear that tore
constexpr Index kRounds = 8, kRoundIterations = 4, kLastIterations = 10;  // hundreds of steps

// Where the samples would have the particles. Where these scatter, as at sharp edges, particles stay.
model::State moveOnto(const std::vector<SampleOffset>& offsets, const HeldPoints& held, double spacing,
                      const model::State& state) {
  model::State moved = state;
  for (Index i = 0; i < state.size(); ++i) {
    if (!(offsets[i].scatter <= kNoisy * spacing)) continue;
    const Vec3 normal = state.orientations[i] * Vec3::UnitZ();
    if (!held.places[i]) moved.positions[i] += offsets[i].height * normal;
    if (held.turns[i]) continue;
    moved.orientations[i] = (Quaternion::FromTwoVectors(normal, normal - offsets[i].slope) * state.orientations[i]).normalized();
  }
  return moved;
}

// The nearest samples that face the way of a particle, nearest first.
void findFacing(const cloud::KdTree& tree, const Points& normals, const Vec3& position, const Vec3& normal,
                std::vector<cloud::Neighbor>& near, std::vector<cloud::Neighbor>& facing) {
  tree.nearest(position, kLookedAt, near);
  facing.clear();
  for (const cloud::Neighbor& q : near)
    if (static_cast<Index>(facing.size()) < kAround && normals[q.index].dot(normal) > kFacing) facing.push_back(q);
}

// The plane of least squares through the heights of these samples above the quadratic surface of particle i.
SampleOffset fitPlane(const Points& samples, const std::vector<cloud::Neighbor>& facing, double spacing,
                      const model::State& state, Index i) {
  const double reach = kReach * kReach * facing.back().squared_distance;  // m^2
  if (!(reach > 0.0)) return {};
  const Mat3 frame = state.orientations[i].toRotationMatrix();
  const Vec3& k = state.traits[i].rest_curvature;
  Mat3 matrix = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double squares = 0.0;  // m^2
  for (const cloud::Neighbor& q : facing) {
    const Vec3 r = frame.transpose() * (samples[q.index] - state.positions[i]);
    const double x = r.x(), y = r.y(), height = r.z() + 0.5 * (k[0] * x * x + k[1] * y * y + 2.0 * k[2] * x * y);
    const double weight = std::exp(-0.5 * q.squared_distance / reach);
    const Vec3 terms(1.0, x, y);
    matrix += weight * terms * terms.transpose();
    right += weight * height * terms;
    squares += weight * height * height;
  }
  matrix(1, 1) += kLevel * matrix(0, 0) * reach;
  matrix(2, 2) += kLevel * matrix(0, 0) * reach;
  const Vec3 plane = matrix.ldlt().solve(right);
  if (!(std::abs(plane[0]) < spacing)) return {};  // another part of the surface
  return {plane[0], frame * Vec3(plane[1], plane[2], 0.0), std::sqrt(std::max(0.0, (squares - plane.dot(right)) / matrix(0, 0)))};
}

}  // namespace

std::vector<SampleOffset> findSampleOffsets(const Points& samples, const Points& normals, double spacing,
                                            const model::State& state) {
  const cloud::KdTree tree(samples);
  std::vector<SampleOffset> offsets(state.size());
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    std::vector<cloud::Neighbor> near, facing;
    for (Index i = begin; i < end; ++i) {
      findFacing(tree, normals, state.positions[i], state.orientations[i] * Vec3::UnitZ(), near, facing);
      if (facing.size() >= 3) offsets[i] = fitPlane(samples, facing, spacing, state, i);
    }
  });
  return offsets;
}

bool areNoisy(const std::vector<SampleOffset>& offsets, double spacing) {
  Index scattered = 0;
  for (const SampleOffset& offset : offsets) scattered += offset.scatter > kNoisy * spacing;
  return scattered > kMostScattered * offsets.size();
}

void settleOnSamples(const Points& samples, const Points& normals, const HeldPoints& held, model::OrientedParticles& model,
                     model::State& state) {
  restoreShape(model, held, state);
  for (Index round = 1; round <= kRounds; ++round) {
    endIfInterrupted();
    model::State found = state;
    model.adopt(found);
    model.keepShape(found);
    const double spacing = model.lattice().spacing;
    model::State target = moveOnto(findSampleOffsets(samples, normals, spacing, found), held, spacing, state);
    model::State wanted = target;
    model.adopt(wanted);
    model.keepShape(wanted);
    for (Index i = 0; i < state.size(); ++i)
      target.traits[i].rest_curvature += wanted.traits[i].rest_curvature - found.traits[i].rest_curvature;
    model.setSpacing(model.findSpacingWithoutTension(target));
    state = target;
    relaxFar(model, held, round < kRounds ? kRoundIterations : kLastIterations, state);
  }
}

}  // namespace deformable_surface::simulation
