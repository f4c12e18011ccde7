// Whether a solid tool has gone through a surface of particles, and how wide one must be that a deep dent holds. There is no mesh
// that would tell: particles part before the tool and bind again behind it.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/tool/tool.h"

#include <map>
#include <string>
#include <vector>

namespace deformable_surface::simulation {

class PiercingWatch {
 public:
  void reset() { sides_.clear(); }

  /// At a time, s. Returns the tools that have come to the other side of the particles that they touch (within half a spacing, m)
  /// since the last look, without leaving the surface in between; each until the next reset once. One that has moved by more than
  /// half its width in between was put there. O(n) for each solid tool.
  std::vector<const tool::ToolParams*> look(double time, const std::vector<tool::ToolParams>& tools, const model::State& state,
                                            double spacing);

 private:
  struct Side {
    double sign = 0.0;  // of the side of the surface that the tool's origin is on; 0: the tool touches nothing, or is between
    Vec3 place = Vec3::Zero();  // m, of the tool's origin at the last look
    bool is_told = false;
  };
  std::map<std::string, Side> sides_;  // by the tool's name
  std::vector<double> distances_;      // scratch: m, of the particles from a tool
};

/// The least width of a tool, m, that a deep dent in a surface of free bonds holds: narrower ones go through. spacing, m;
/// stiff_length: sqrt(bending rigidity / (Young's modulus thickness)), m.
double findLeastWidth(double spacing, double stiff_length);

}  // namespace deformable_surface::simulation
