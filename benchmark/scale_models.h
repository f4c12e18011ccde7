// Growth of the models' force passes and steps with the number of simulation points, and the share of the machine's limits that
// each stage reaches.
#pragma once

#include "machine_limits.h"

#include "deformable_surface/model/deformable_model.h"

#include <string>
#include <vector>

namespace deformable_surface::benchmark {

/// A stage on one thread whose operations (a sum, product, quotient or root each) and bytes are counted in its source.
struct CountedStage {
  std::string name;
  Index points = 0;
  double operations = 0.0, bytes = 0.0, seconds = 0.0;  // of one pass over all points
};

/// Operations of a force pass over the membrane of triangles.
double countTriangleOperations(const model::DeformableModel& model);

/// A table of every model at a hundred to a hundred thousand simulation points, and one of the exponents of their growth. Appends
/// what is counted.
void measureModels(const Options& options, Report& report, std::vector<CountedStage>& counted);

/// A table of operations and bytes per second and the limits of the machine. scripts/draw_roofline.py draws it.
void reportRoofline(const std::vector<CountedStage>& counted, const MachineLimits& limits, Report& report);

}  // namespace deformable_surface::benchmark
