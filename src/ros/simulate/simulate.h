// The program `simulate`: a scene in, and a bag if given; clouds, a bag and a CSV out. Apart from its main, for tests.
#pragma once

#include <atomic>
#include <ostream>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// A signal that is to end a run. A handler sets the number first.
struct StopSignal {
  std::atomic<int> number{0};
  std::atomic<bool> has_come{false};
};

/// Where a run shows itself, and how it is interrupted.
struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool show_progress;  // a bar on err
  const StopSignal& stop;
};

/// arguments: without the name of the program. Returns the exit status: 0 done; 2 the command line, the scene or an input file is
/// wrong (a line on err for each problem); 3 no sound step could be taken, and the last good state is written; 4
/// with --strict: the expectations of the scene are not kept, and everything is written; 128 + the signal.
int simulate(const std::vector<std::string>& arguments, const Terminal& terminal);

}  // namespace deformable_surface::node
