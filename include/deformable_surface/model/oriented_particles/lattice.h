// The flat lattice that particles settle into: its spacing and its stiffness. The constants of the potentials follow from it.
// It treats infinite lattices, without single particles.
#pragma once

#include "deformable_surface/model/material_params.h"
#include "deformable_surface/model/oriented_particles/oriented_particles_params.h"
#include "deformable_surface/model/oriented_particles/pair_potentials.h"

namespace deformable_surface::model {

/// Hexagonal for a surface; for a curve a row of particles, each of which stands for a square of the surface.
struct Lattice {
  PairPotentials pair;
  double spacing = 0.0;              // m, where the lattice has no tension
  double area_per_particle = 0.0;    // m^2
  double energy_per_particle = 0.0;  // J, below zero
  double inertia_by_mass = 0.0;  // m^2: of that a particle turns back no faster than it moves back; at least that of the plate
};

/// The potentials with which the lattice has that spacing (m), Young's modulus times thickness and bending rigidity of the
/// material, each times its weight. Throws InputError if the exponents and the cutoff let a surface collapse, or for no spacing.
Lattice calibrateLattice(double spacing, const MaterialParams& material, const OrientedParticlesParams& params);

}  // namespace deformable_surface::model
