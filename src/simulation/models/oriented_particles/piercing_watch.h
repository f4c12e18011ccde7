// Whether a solid tool has gone through a surface of particles or has torn it open, and how wide one must be that a deep dent
// holds. With free bonds there is no mesh that would tell: particles part before the tool, and bind again behind it or do not.
// Kept bonds break once and for all.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/tool/tool.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

class PiercingWatch {
 public:
  struct Found {
    const tool::ToolParams* tool;
    bool is_through;  // else it has torn the surface open
    bool is_first;    // that is found of this tool
  };
  /// Leaves 1 of those particles (n) that are 1 which lie at an open edge.
  using KeepOpen = std::function<void(std::vector<char>&)>;

  void reset() { tools_.clear(); }

  /// At a time, s. Finds the tools that have come to the other side of the particles that they touch (within half a spacing, m)
  /// since the last look, without leaving the surface in between; one that has moved by more than half its width and a spacing in
  /// between was put there, and one at an edge of the cloud has slipped off it. And those at which particles that had others all
  /// around have come to lie at an open edge for many looks. Each until the next reset once; one that has gone through is not
  /// found to tear the surface open. O(n) for each solid tool.
  std::vector<Found> look(double time, const std::vector<tool::ToolParams>& tools, const model::State& state, double spacing,
                          const KeepOpen& keepOpen);
  /// At a time, s. The solid tools that are within a spacing, m, of places where kept bonds have just broken. Each until the next
  /// reset once, with what look() finds.
  std::vector<const tool::ToolParams*> lookAtBroken(double time, const std::vector<tool::ToolParams>& tools, const Points& broken,
                                                    double spacing);

 private:
  struct Watched {
    // Of each point of the tool's axis: of the side of the surface that it is on; 0: the tool touches nothing, or it is between.
    std::vector<double> signs;
    Points places;                              // m, of these points at the last look
    bool is_at_edge = false;                    // at the last look at which the tool touched the surface: of the cloud
    bool is_through = false, has_torn = false;  // and this was told
    // By the id of a particle: 0, it has not had others all around at the tool; else 1 and the looks for which it has been open.
    std::vector<std::uint8_t> open_looks;

    /// But for what was told.
    void forgetLooks() {
      Watched told;
      told.is_through = is_through;
      told.has_torn = has_torn;
      *this = std::move(told);
    }
  };

  // Particles at the tool that lie at an open edge.
  struct Open {
    bool is_edge = false;  // any that has not had others all around at the tool: of the cloud
    int torn = 0;          // that had, and have been open for many looks
  };

  bool hasGoneThrough(const tool::ToolParams& tool, double time, const model::State& state, double spacing, bool is_edge,
                      Watched& watched);
  Open findOpen(const model::State& state, double spacing, const KeepOpen& keepOpen, Watched& watched);

  std::map<std::string, Watched> tools_;  // by name
  // Scratch.
  std::vector<double> distances_;  // m, of the particles from a tool
  std::vector<char> is_open_;
};

/// The least width of a tool, m, that a deep dent in a surface of free bonds holds: narrower ones go through. spacing, m;
/// stiff_length: sqrt(bending rigidity / (Young's modulus thickness)), m.
double findLeastWidth(double spacing, double stiff_length);

}  // namespace deformable_surface::simulation
