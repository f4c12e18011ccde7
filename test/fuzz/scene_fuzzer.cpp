// libFuzzer on the reader of scenes: any text gives a scene whose print reads back as itself, or sentences without control
// characters.
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/scene.h"

#include <algorithm>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace deformable_surface;
  try {
    const simulation::SceneParams scene =
        io::readScene(io::parseYaml(std::string(reinterpret_cast<const char*>(bytes), size), "scene.yaml"));
    const std::string printed = io::printScene(scene);
    if (io::printScene(io::readScene(io::parseYaml(printed, "printed.yaml"))) != printed) std::abort();
  } catch (const InputError& error) {
    for (const std::string& problem : error.problems())
      if (std::any_of(problem.begin(), problem.end(), [](unsigned char c) { return (c < 0x20 && c != '\n') || c == 0x7f; }))
        std::abort();
  }
  return 0;
}
