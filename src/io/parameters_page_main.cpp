// Prints the pages made from the schema of scenes: docs/parameters.md, or with --scene scenes/default.yaml.
#include "deformable_surface/io/scene.h"

#include <cstdio>
#include <string>

int main(int argc, char** argv) {
  using namespace deformable_surface::io;
  const bool is_scene = argc == 2 && argv[1] == std::string("--scene");
  if (argc > 1 && !is_scene) {
    std::fprintf(stderr, "parameters_page: found arguments; accepted: none (docs/parameters.md), --scene (a scene)\n");
    return 2;
  }
  return std::fputs((is_scene ? defaultScene() : parametersPage()).c_str(), stdout) < 0 ? 1 : 0;
}
