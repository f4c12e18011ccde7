// Whether a surface or body is stretched so far that its material law means nothing there, and what holds or pushes it there.
#pragma once

#include "deformable_surface/model/deformable_model.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

class Dynamics;

class StretchWatch {
 public:
  /// |l / l0 - 1| of a link: above it, the link is more than twice as long as at rest. Compression never reaches it.
  static constexpr double kMost = 1.0;

  /// Ends a step that has cost as much as so many sub-steps. Looks are far apart, so that they take next to no time; must_look:
  /// at this step in any case. Returns whether the largest stretch stays above kMost: in two looks in a row, or where it must
  /// look.
  bool endStep(const model::DeformableModel& model, const model::State& state, Index substeps, bool must_look);
  /// Of the last look.
  bool isOver() const { return is_over_; }
  double stretch() const { return stretch_; }
  void clear() { *this = StretchWatch(); }

 private:
  Index since_look_ = 0;  // sub-steps
  double stretch_ = 0.0;
  bool is_above_ = false, is_over_ = false;
};

/// Where it is worst, and what acts on the points around that are linked by such stretches.
struct Overstretch {
  bool is_surface = true;            // else a body
  bool has_law_for_it = false;       // one for large strains
  double stretch = 0.0;              // |l / l0 - 1|
  Vec3 place = Vec3::Zero();         // m
  std::vector<std::string> holders;  // "tool 'left'", "pins[0]", each once
  std::vector<std::string> pushers;  // tools
};

/// O(n), and looks for contacts.
Overstretch findOverstretch(const Dynamics& dynamics);
/// "the surface is stretched by 340 % at (0, 0, 0.1) m ..."
std::string describeOverstretch(const Overstretch& over);

}  // namespace deformable_surface::simulation
