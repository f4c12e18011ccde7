#include "quantities.h"

#include <algorithm>

namespace deformable_surface::simulation {

const std::vector<Quantity>& quantities() {
  // All particles may be gone: counts are then 0, measurements do not exist.
  static const std::vector<Quantity> kQuantities{
      {"max_displacement"},
      {"mean_displacement"},
      {"rms_displacement"},
      {"min_x"},
      {"max_x"},
      {"min_y"},
      {"max_y"},
      {"min_z"},
      {"max_z"},
      {"volume_ratio"},
      {"components", false, 0},
      {"boundary_loops", true, 0},
      {"euler_characteristic", true, 0},
      {"isolated", false, 0},
      {"plastic_dissipation"},
      {"spacing_mean", true, 2},
      {"spacing_cv", true, 2},
      {"spacing_max", true, 2},
      {"added", true, 0},
      {"removed", true, 0},
      {"principal_angle_mean", true},
      {"distance_to_shape_max"},
      {"distance_to_shape_rms"},
      {"distance_to_input_max"},
      {"distance_to_input_rms"},
      {"distance_to_sphere_max"},
      {"distance_to_sphere_rms"},
      {"sphere_radius"},
      {"distance_to_torus_max"},
      {"distance_to_torus_rms"},
      {"torus_radius"},
      {"torus_tube_radius"},
      {"distance_to_tools_min"},
      {"guide_distance_max", true},
      {"guide_distance_rms", true},
      {"touching", true},
  };
  return kQuantities;
}

const Quantity* findQuantity(const std::string& name) {
  const auto found =
      std::find_if(quantities().begin(), quantities().end(), [&](const Quantity& quantity) { return name == quantity.name; });
  return found == quantities().end() ? nullptr : &*found;
}

}  // namespace deformable_surface::simulation
