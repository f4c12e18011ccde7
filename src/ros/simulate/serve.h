// `simulate --serve`: one process after another for runs that a program asks for. Apart from a run, which knows nothing of it.
#pragma once

namespace deformable_surface::node {

/// Reads requests from descriptor `in` until it ends. A request is the arguments of `simulate`, each ended by a zero byte, and an
/// empty one behind them. The first argument is the folder in which the run works and whose files `out` and `err` take what it
/// prints. Each run is a copy of this process (fork), so that programs and libraries are loaded once and a run that crashes ends
/// nothing else. The answer on descriptor `out` is a line: the exit status, or "signal N". Returns the exit status of the server.
/// A run ends with its server, and the server with what asks it.
int serve(int in, int out);

}  // namespace deformable_surface::node
