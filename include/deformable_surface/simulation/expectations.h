// What a scene's `expect` block promises, checked on a finished run. Apart from the simulation, because only tests and tools ask.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

/// The quantity of that name now; the names are those of expectQuantities(). Displacements and bounds are those of all finite
/// points of the full cloud; volume_ratio is the volume that the simulation points enclose now over that at rest. Distances
/// (m) are those of the simulation points: to the shape that the scene's cloud was made on, to tangent planes of the input, to
/// the sphere or round torus nearest to them (geometry/fitted_shape.h, as its radii are), and signed to the nearest solid tool;
/// `touching` are the particles within a twentieth of a spacing of one. Throws InputError for an unknown name and for what there
/// is not: the volume of an open surface, a distance to no tool.
double computeQuantity(const std::string& name, Simulation& simulation);

/// The signed distances (m) of the simulation points from the nearest of the solid tools that there are now. Throws InputError,
/// of the quantity of that name, if there is none.
std::vector<double> findToolDistances(const std::string& name, const Simulation& simulation);

/// One sentence for each bound of params().expect that does not hold; NaN holds none.
std::vector<std::string> checkExpectations(Simulation& simulation);

}  // namespace deformable_surface::simulation
