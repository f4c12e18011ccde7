#include "simulate.h"

#include "simulate_options.h"
#include "simulate_run.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/version.h"
#include "deformable_surface/io/load_scene.h"
#include "deformable_surface/ros/convert/find_package.h"
#include "deformable_surface/simulation/statistics.h"

#include <type_traits>

namespace deformable_surface::node {

namespace {

// The columns of numbers that --statistics writes: other programs ask for them before they run many scenes.
void listColumns(std::ostream& out) {
  simulation::visitFields(simulation::Statistics(), [&](const std::string& name, const auto& value) {
    if constexpr (std::is_arithmetic<std::decay_t<decltype(value)>>::value) out << "statistics " << name << '\n';
  });
}

}  // namespace

void prepare(const std::vector<std::string>& arguments, KeptSurfaces& kept) {
  try {
    const SimulateOptions options = parseOptions(arguments);
    if (options.bag_in.empty() && !options.check) kept.make(loadScene(options));
  } catch (const std::exception&) {}
}

int simulate(const std::vector<std::string>& arguments, const Terminal& terminal, KeptSurfaces* kept) {
  const auto report = [&](const std::string& line) { terminal.err << "simulate: " << line << '\n'; };
  try {
    const SimulateOptions options = parseOptions(arguments);
    if (options.help) {
      terminal.out << describeOptions();
      return kDone;
    }
    if (options.version) {
      terminal.out << version() << '\n';
      return kDone;
    }
    if (options.check) {
      const simulation::SceneParams params = loadScene(options);
      checkOptions(options, params);
      if (options.bag_in.empty()) io::loadCloud(params, findPackage);
      listColumns(terminal.out);
      return kDone;
    }
    return Run(options, terminal, kept).run();
  } catch (const InputError& error) {
    for (const std::string& problem : error.problems()) report(problem);
  } catch (const Interrupted&) {
    report("interrupted while a surface was built; no state of it is written");
    return kInterrupted + terminal.stop.number;
  } catch (const std::exception& error) {
    report(std::string("stopped: ") + error.what());
  }
  return kWrongInput;
}

}  // namespace deformable_surface::node
