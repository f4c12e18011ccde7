// The program `simulate`: signals, streams and nothing else.
#include "simulate.h"

#include <unistd.h>

#include <iostream>

namespace {

volatile std::sig_atomic_t stop_signal = 0;

void onSignal(int number) { stop_signal = number; }

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  return deformable_surface::node::simulate({argv + 1, argv + argc},
                                            {std::cout, std::cerr, isatty(STDERR_FILENO) == 1, stop_signal});
}
