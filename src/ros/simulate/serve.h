// `simulate --serve`: runs for another program, one after the other. A run itself does not know of it.
#pragma once

namespace deformable_surface::node {

/// Reads requests from descriptor `in` until it ends. A request is the arguments of `simulate`, each ended by a zero byte, and an
/// empty one after them. The first argument is the folder in which the run works; its files `out` and `err` take what it
/// prints. Each run is a copy of this process (fork), so that programs and libraries are loaded once, runs of the same cloud
/// share its preparation (kept_surfaces.h), and a run that crashes ends nothing else. The answer on descriptor `out` is a line:
/// the exit status, or "signal N". Returns the exit status of the server. A run ends with its server, and the server with its
/// caller.
int serve(int in, int out);

}  // namespace deformable_surface::node
