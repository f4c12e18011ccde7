// How far grown particles are from the samples around them, and whether these are noisy.
#include "../../src/simulation/models/oriented_particles/approach_samples.h"
#include "cloud/test_surfaces.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::simulation {
namespace {

// A ball of another size about the same centre.
cloud::TestSurface makeBall(double radius, int count) {
  cloud::TestSurface ball = cloud::makeSphere(count);
  for (Vec3& p : ball.positions) p *= radius;
  return ball;
}

constexpr double kSpacing = 0.12;  // m, of 900 particles

// Particles on the unit sphere that know its curvature.
model::State makeParticles() {
  const cloud::TestSurface ball = makeBall(1.0, 900);
  model::State state;
  state.positions = ball.positions;
  for (const Vec3& normal : ball.normals)
    state.orientations.push_back(Quaternion::FromTwoVectors(Vec3::UnitZ(), normal).normalized());
  state.traits.resize(state.positions.size());
  for (model::ParticleTraits& traits : state.traits) traits.rest_curvature = Vec3(1.0, 1.0, 0.0);
  return state;
}

TEST(ApproachSamples, ParticlesOnASphereSeeSamplesOnALargerOneAtTheirDistance) {
  constexpr double kAbove = 0.02;  // m
  const cloud::TestSurface samples = makeBall(1.0 + kAbove, 400);
  for (const SampleOffset& offset : findSampleOffsets(samples.positions, samples.normals, kSpacing, makeParticles())) {
    EXPECT_NEAR(offset.height, kAbove, 0.03 * kAbove);
    EXPECT_LT(offset.slope.norm(), 0.01);
  }
}

// The other side of a thin body is no place to go to.
TEST(ApproachSamples, SamplesThatFaceAwayAreNotSeen) {
  cloud::TestSurface samples = makeBall(0.98, 400);
  for (Vec3& normal : samples.normals) normal = -normal;
  for (const SampleOffset& offset : findSampleOffsets(samples.positions, samples.normals, kSpacing, makeParticles()))
    EXPECT_EQ(offset.height, 0.0);
}

TEST(ApproachSamples, SamplesMovedByNoiseAreToldFromThoseOnTheSurface) {
  cloud::TestSurface samples = makeBall(1.0, 400);
  EXPECT_FALSE(areNoisy(findSampleOffsets(samples.positions, samples.normals, kSpacing, makeParticles()), kSpacing));
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.2 * kSpacing);
  for (Vec3& p : samples.positions) p *= 1.0 + noise(random);
  EXPECT_TRUE(areNoisy(findSampleOffsets(samples.positions, samples.normals, kSpacing, makeParticles()), kSpacing));
}

}  // namespace
}  // namespace deformable_surface::simulation
