// Checks the `expect` block of a scene after a run. Only tests and tools need it.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

/// The present value of a quantity; the names are those of expectQuantities(). Displacements and bounds are those of all finite
/// points of the full cloud. volume_ratio is the volume enclosed by the simulation points over that at rest. Distances
/// (m) are those of the simulation points: to the shape that the scene's cloud was made on, to tangent planes of the input, to
/// the nearest sphere or round torus (geometry/fitted_shape.h, as its radii are), and signed to the nearest solid tool.
/// `touching` counts particles within a twentieth of a spacing of one. Throws InputError for an unknown name and for a quantity
/// that does not exist: the volume of an open surface, a distance without a tool.
double computeQuantity(const std::string& name, Simulation& simulation);

/// The signed distances (m) of the simulation points from the nearest solid tool. Throws InputError, naming the quantity,
/// if there is none.
std::vector<double> findToolDistances(const std::string& name, const Simulation& simulation);

/// One sentence for each violated bound of params().expect; NaN violates every bound.
std::vector<std::string> checkExpectations(Simulation& simulation);

}  // namespace deformable_surface::simulation
