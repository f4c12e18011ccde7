// The program `simulate`: a scene in, and a bag if given; clouds, a bag and a CSV out. Apart from its main, for tests.
#pragma once

#include <csignal>
#include <ostream>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// Where a run shows itself, and how it is interrupted.
struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool show_progress;                      // a bar on err
  const volatile std::sig_atomic_t& stop;  // the number of a signal that came, else 0
};

/// arguments: without the name of the program. Returns the exit status: 0 done; 2 the command line, the scene or an input file is
/// wrong (a line on err for each problem); 3 no sound step could be taken, and the last good state is written; 128 + the signal.
int simulate(const std::vector<std::string>& arguments, const Terminal& terminal);

}  // namespace deformable_surface::node
