#include "simulate_options.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/io/scene_old_names.h"
#include "deformable_surface/simulation/scene_params.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace deformable_surface::node {
namespace {

const std::vector<std::string> kValueOptions{"--set",        "--duration", "--final",   "--filtered", "--frames",
                                             "--frame_rate", "--bag_in",   "--topic",   "--bag_out",  "--statistics",
                                             "--threads",    "--wrenches", "--measure", "--mesh",     "--mesh_pieces"};
const std::vector<std::string> kFlags{"--check", "--quiet", "--strict", "--help", "--version"};

std::string refuseUnknown(const std::string& option) {
  std::vector<std::string> known = kValueOptions;
  known.insert(known.end(), kFlags.begin(), kFlags.end());
  return "found the option " + quote(option) + "; the nearest known one is " + nearestWord(option, known) +
         "; accepted: those of --help";
}

// NAME=TOPIC.
void addTopic(const std::string& value, SimulateOptions& options, std::vector<std::string>& problems) {
  const std::size_t equals = value.find('=');
  const std::string name = value.substr(0, equals);
  if (equals == std::string::npos || equals + 1 == value.size()) {
    problems.push_back("--topic: found " + quote(value) + "; accepted: NAME=TOPIC, e.g. cloud_in=/camera/points");
  } else if (options.topics.count(name) == 0) {
    problems.push_back("--topic: found the name " + quote(name) + "; accepted: cloud_in, force, wrench, tools");
  } else {
    options.topics[name] = value.substr(equals + 1);
    options.given_topics.insert(name);
  }
}

void addQuantity(const std::string& name, SimulateOptions& options, std::vector<std::string>& problems) {
  const std::vector<std::string> known = simulation::expectQuantities();
  if (std::find(known.begin(), known.end(), io::findNewQuantity(name)) == known.end()) {
    problems.push_back("--measure: found " + quote(name) + "; the nearest known one is " + nearestWord(name, known) +
                       "; accepted: the quantities of expect, see docs/parameters.md");
  } else {
    options.measured.push_back(name);
  }
}

constexpr Index kMostMeshPieces = 64;

void setFrameRate(const std::string& value, SimulateOptions& options, std::vector<std::string>& problems) {
  const Value number = parseNumber(value);
  const double rate = number.asReal() ? *number.asReal() : number.asInteger() ? static_cast<double>(*number.asInteger()) : 0.0;
  if (rate > 0.0 && std::isfinite(rate)) {
    options.frame_rate = rate;
  } else {
    problems.push_back("--frame_rate: found " + quote(value) + "; accepted: a number above 0 (Hz)");
  }
}

void setMeshPieces(const std::string& value, SimulateOptions& options, std::vector<std::string>& problems) {
  const Value number = parseNumber(value);
  if (number.asInteger() && *number.asInteger() >= 1 && *number.asInteger() <= kMostMeshPieces) {
    options.mesh_pieces = static_cast<Index>(*number.asInteger());
  } else {
    problems.push_back("--mesh_pieces: found " + quote(value) + "; accepted: a whole number from 1 to " +
                       std::to_string(kMostMeshPieces));
  }
}

}  // namespace

SimulateOptions parseOptions(const std::vector<std::string>& arguments) {
  SimulateOptions options;
  for (const char* name : {"cloud_in", "force", "wrench", "tools"})
    options.topics[name] = std::string("/deformable_surface/") + name;
  const std::map<std::string, std::string*> texts{
      {"--final", &options.final_file},           {"--filtered", &options.filtered_file}, {"--frames", &options.frames_directory},
      {"--statistics", &options.statistics_file}, {"--bag_in", &options.bag_in},          {"--bag_out", &options.bag_out},
      {"--wrenches", &options.wrenches_file},     {"--mesh", &options.mesh_file}};
  std::vector<std::string> problems, late_assignments;
  std::set<std::string> given;

  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    // The scene.
    if (argument.empty() || argument[0] != '-') {
      if (!options.scene.empty()) {
        problems.push_back("found a second scene, " + quote(argument) + "; accepted: one scene file");
      } else if (argument.empty()) {
        problems.push_back("found an empty name of a scene; accepted: a scene file");
      } else {
        options.scene = argument;
      }
      continue;
    }
    // Options without a value.
    if (std::find(kFlags.begin(), kFlags.end(), argument) != kFlags.end()) {
      (argument == "--check"    ? options.check
       : argument == "--quiet"  ? options.quiet
       : argument == "--strict" ? options.strict
       : argument == "--help"   ? options.help
                                : options.version) = true;
      continue;
    }
    // Options with a value.
    if (std::find(kValueOptions.begin(), kValueOptions.end(), argument) == kValueOptions.end()) {
      problems.push_back(refuseUnknown(argument));
      continue;
    }
    if (i + 1 == arguments.size() || arguments[i + 1].empty()) {
      problems.push_back(argument + ": found nothing behind it; accepted: a value, see --help");
      ++i;
      continue;
    }
    const std::string& value = arguments[++i];
    if (argument == "--set") {
      options.assignments.push_back(value);
      continue;
    }
    if (argument == "--measure") {
      addQuantity(value, options, problems);
      continue;
    }
    if (argument == "--topic") {
      addTopic(value, options, problems);
      given.insert(argument);
      continue;
    }
    if (!given.insert(argument).second) problems.push_back(argument + ": found twice; accepted: once");
    if (argument == "--mesh_pieces") {
      setMeshPieces(value, options, problems);
    } else if (argument == "--frame_rate") {
      setFrameRate(value, options, problems);
    } else if (texts.count(argument) > 0) {
      *texts.at(argument) = value;
    } else {
      late_assignments.push_back(argument.substr(2) + "=" + value);  // --duration, --threads
    }
  }
  options.assignments.insert(options.assignments.end(), late_assignments.begin(), late_assignments.end());

  if (options.help || options.version) return options;
  if (options.scene.empty() && problems.empty())
    problems.push_back("found no scene; accepted: simulate SCENE.yaml [options], see --help");
  if (given.count("--frame_rate") > 0 && options.frames_directory.empty()) {
    problems.push_back("--frame_rate: found without --frames; accepted: together with --frames DIR");
  }
  if (given.count("--mesh_pieces") > 0 && options.mesh_file.empty()) {
    problems.push_back("--mesh_pieces: found without --mesh; accepted: together with --mesh FILE.obj");
  }
  if (given.count("--topic") > 0 && options.bag_in.empty()) {
    problems.push_back("--topic: found without --bag_in; accepted: together with --bag_in IN.bag");
  }
  if (!problems.empty()) throw InputError(std::move(problems));
  return options;
}

std::string describeOptions() {
  return "simulate SCENE.yaml [options]\n"
         "Runs a scene without a roscore, as fast as possible.\n\n"
         "  --set KEY=VALUE       override one scene value by its dotted path, e.g. tools[0].friction=0.2; repeatable\n"
         "  --duration S          simulated seconds, a multiple of the time step (else the scene's duration)\n"
         "  --final FILE          the full cloud after the last step, with normals; .ply or .pcd\n"
         "  --filtered FILE       the first cloud of the input, with a field that names the input.filter that removed each\n"
         "                        point (docs/camera_clouds.md); .ply or .pcd\n"
         "  --mesh FILE.obj       the triangles between oriented particles after the last step, with normals\n"
         "  --mesh_pieces N       --mesh with cubic patches: each edge in N pieces (else 1: flat triangles)\n"
         "  --frames DIR          the full cloud as numbered files from time 0 on; a folder without frames\n"
         "  --frame_rate HZ       rate of --frames, at most one per step (else the scene's output.publish_rate)\n"
         "  --bag_in IN.bag       take clouds, forces, wrenches and tools from a bag, in stamp order, instead of the scene's\n"
         "  --topic NAME=TOPIC    topic in the bag of cloud_in, force, wrench or tools (else /deformable_surface/NAME); "
         "repeatable\n"
         "  --bag_out OUT.bag     what the node would publish, under /deformable_surface/, stamped in simulation time\n"
         "  --statistics FILE.csv one row per step\n"
         "  --wrenches FILE.csv   one row per step and tool or pin: force and torque on it, as in the topic tool_wrenches\n"
         "  --measure QUANTITY    print a quantity of expect after the last step, with all digits; repeatable\n"
         "  --threads N           worker threads; the result is the same for every N\n"
         "  --strict              exit status 4 if a bound of the scene's expect is not met\n"
         "  --check               read the scene, its cloud and the options only; print problems and the columns of "
         "--statistics\n"
         "  --quiet               errors and measured quantities only\n"
         "  --version             print the version of the package\n"
         "  --serve               without other options: execute the runs that a program requests on the standard input\n"
         "                        (docs/sweeps.md)\n\n"
         "The bounds of the scene's expect are checked after the last step. They hold for the scene's own cloud and duration.\n"
         "A bound that is not met is a note, with --strict an error.\n"
         "Exit status: 0 done; 2 the command line, the scene or an input file is wrong; 3 a step was refused, and the last\n"
         "good state is written; 4 with --strict: done, but a bound is not met; 128 + the signal: interrupted, and only the\n"
         "frames and the rows of --statistics and --wrenches until then are written.\n";
}

}  // namespace deformable_surface::node
