// The program `simulate`: signals, streams and nothing else.
#include "serve.h"
#include "simulate.h"

#include <unistd.h>

#include <csignal>
#include <iostream>
#include <string>

namespace {

deformable_surface::node::StopSignal stop_signal;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "else a handler must not touch them");

void onSignal(int number) {
  stop_signal.number = number;
  stop_signal.has_come = true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && argv[1] == std::string("--serve")) return deformable_surface::node::serve(STDIN_FILENO, STDOUT_FILENO);
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  return deformable_surface::node::simulate({argv + 1, argv + argc},
                                            {std::cout, std::cerr, isatty(STDERR_FILENO) == 1, stop_signal});
}
