// Grown particles come to rest beside the samples that they were grown through. Here they are led back onto them. Private.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include "settle_particles.h"

namespace deformable_surface::simulation {

/// Where the surface through the samples around a particle lies, seen from the particle.
struct SampleOffset {
  double height = 0.0;        // m, of that surface above the particle along its normal
  Vec3 slope = Vec3::Zero();  // rad, its gradient across the normal
  double scatter = 0.0;       // m, rms, of the samples about it
};

/// By the nearest samples that face the way of each particle: the plane of least squares through their heights above the
/// particle's own quadratic surface, weighted by distance. The state's rest curvatures must be its present ones (keepShape()).
/// normals: unit, of the samples. Zero where fewer than three samples are near. O(n log m).
std::vector<SampleOffset> findSampleOffsets(const Points& samples, const Points& normals, double spacing,
                                            const model::State& state);

/// Whether samples scatter about the planes of more than a third of the particles, from noise or from features as fine as their
/// distance: particles that follow them would be uneven, and the surface may tear.
bool areNoisy(const std::vector<SampleOffset>& offsets, double spacing);

/// Particles grown through samples, with the rest curvatures of the grown surface, towards an equilibrium that lies on the
/// samples. Progressive and iterative: each round moves particles onto the samples, adds the curvature of that move to their rest
/// curvature, takes the spacing without tension, and lets them go for some hundreds of steps. The spacing of the lattice and
/// rest curvatures change.
void settleOnSamples(const Points& samples, const Points& normals, const HeldPoints& held, model::OrientedParticles& model,
                     model::State& state);

}  // namespace deformable_surface::simulation
