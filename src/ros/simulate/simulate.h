// The program `simulate`: reads a scene, and a bag if given; writes clouds, a bag and a CSV. Tests call it without its main.
#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace deformable_surface::node {

class KeptSurfaces;

/// A signal that ends a run. A handler sets the number first.
struct StopSignal {
  std::atomic<int> number{0};
  std::atomic<bool> has_come{false};
};

/// The terminal of a run, and how it is interrupted.
struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool show_progress;  // a bar on err
  const StopSignal& stop;
};

/// arguments: without the name of the program. Returns the exit status: 0 success; 2 the command line, the scene or an input file
/// is wrong (a line on err for each problem); 3 no sound step could be taken, and the last good state is written; 4
/// with --strict: the expectations of the scene are not met, and everything is written; 128 + the signal. kept: prepared surfaces
/// that it may use; null: none.
int simulate(const std::vector<std::string>& arguments, const Terminal& terminal, KeptSurfaces* kept = nullptr);

/// Adds to `kept` the prepared surface that a run with these arguments would use. Errors are ignored here: the run reports them.
void prepare(const std::vector<std::string>& arguments, KeptSurfaces& kept);

}  // namespace deformable_surface::node
