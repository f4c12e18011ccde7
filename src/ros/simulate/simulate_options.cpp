#include "simulate_options.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/io/scene_old_names.h"
#include "deformable_surface/simulation/scene_params.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace deformable_surface::node {
namespace {

// What the arguments have given until now.
struct Parse {
  SimulateOptions options;
  std::vector<std::string> problems;
  std::vector<std::string> late_assignments;  // behind those of --set
  std::set<std::string> given;                // options with a value
};

// NAME=TOPIC.
void addTopic(const std::string& value, Parse& parse) {
  const std::size_t equals = value.find('=');
  const std::string name = value.substr(0, equals);
  if (equals == std::string::npos || equals + 1 == value.size()) {
    parse.problems.push_back("--topic: found " + quote(value) + "; accepted: NAME=TOPIC, e.g. cloud_in=/camera/points");
  } else if (parse.options.topics.count(name) == 0) {
    parse.problems.push_back("--topic: found the name " + quote(name) + "; accepted: cloud_in, force, wrench, tools");
  } else {
    parse.options.topics[name] = value.substr(equals + 1);
    parse.options.given_topics.insert(name);
  }
}

void addQuantity(const std::string& name, Parse& parse) {
  const std::vector<std::string> known = simulation::expectQuantities();
  if (std::find(known.begin(), known.end(), io::findNewQuantity(name)) == known.end()) {
    parse.problems.push_back("--measure: found " + quote(name) + "; the nearest known one is " + nearestWord(name, known) +
                             "; accepted: the quantities of expect, see docs/parameters.md");
  } else {
    parse.options.measured.push_back(name);
  }
}

constexpr Index kMostMeshPieces = 64;

void setFrameRate(const std::string& value, Parse& parse) {
  const Value number = parseNumber(value);
  const double rate = number.asReal() ? *number.asReal() : number.asInteger() ? static_cast<double>(*number.asInteger()) : 0.0;
  if (rate > 0.0 && std::isfinite(rate)) {
    parse.options.frame_rate = rate;
  } else {
    parse.problems.push_back("--frame_rate: found " + quote(value) + "; accepted: a number above 0 (Hz)");
  }
}

void setMeshPieces(const std::string& value, Parse& parse) {
  const Value number = parseNumber(value);
  if (number.asInteger() && *number.asInteger() >= 1 && *number.asInteger() <= kMostMeshPieces) {
    parse.options.mesh_pieces = static_cast<Index>(*number.asInteger());
  } else {
    parse.problems.push_back("--mesh_pieces: found " + quote(value) + "; accepted: a whole number from 1 to " +
                             std::to_string(kMostMeshPieces));
  }
}

struct Option {
  const char *name, *value;  // null: it has none
  bool is_repeatable;
  void (*take)(const std::string& value, Parse& parse);
  const char* help;
};

using Text = const std::string&;

// In the order of --help.
const Option kOptions[] = {
    {"--set", "KEY=VALUE", true, [](Text value, Parse& p) { p.options.assignments.push_back(value); },
     "override one scene value by its dotted path, e.g. tools[0].friction=0.2; repeatable"},
    {"--duration", "S", false, [](Text value, Parse& p) { p.late_assignments.push_back("duration=" + value); },
     "simulated seconds, a multiple of the time step (else the scene's duration)"},
    {"--final", "FILE", false, [](Text value, Parse& p) { p.options.final_file = value; },
     "the full cloud after the last step, with normals; .ply or .pcd"},
    {"--filtered", "FILE", false, [](Text value, Parse& p) { p.options.filtered_file = value; },
     "the first cloud of the input, with a field that names the input.filter that removed each\n"
     "point (docs/camera_clouds.md); .ply or .pcd"},
    {"--mesh", "FILE.obj", false, [](Text value, Parse& p) { p.options.mesh_file = value; },
     "the triangles between oriented particles after the last step, with normals"},
    {"--mesh_pieces", "N", false, setMeshPieces, "--mesh with cubic patches: each edge in N pieces (else 1: flat triangles)"},
    {"--frames", "DIR", false, [](Text value, Parse& p) { p.options.frames_directory = value; },
     "the full cloud as numbered files from time 0 on; a folder without frames"},
    {"--frame_rate", "HZ", false, setFrameRate, "rate of --frames, at most one per step (else the scene's output.publish_rate)"},
    {"--bag_in", "IN.bag", false, [](Text value, Parse& p) { p.options.bag_in = value; },
     "take clouds, forces, wrenches and tools from a bag, in stamp order, instead of the scene's"},
    {"--topic", "NAME=TOPIC", true, addTopic,
     "topic in the bag of cloud_in, force, wrench or tools (else /deformable_surface/NAME); repeatable"},
    {"--bag_out", "OUT.bag", false, [](Text value, Parse& p) { p.options.bag_out = value; },
     "what the node would publish, under /deformable_surface/, stamped in simulation time"},
    {"--statistics", "FILE.csv", false, [](Text value, Parse& p) { p.options.statistics_file = value; }, "one row per step"},
    {"--wrenches", "FILE.csv", false, [](Text value, Parse& p) { p.options.wrenches_file = value; },
     "one row per step and tool or pin: force and torque on it, as in the topic tool_wrenches"},
    {"--measure", "QUANTITY", true, addQuantity, "print a quantity of expect after the last step, with all digits; repeatable"},
    {"--threads", "N", false, [](Text value, Parse& p) { p.late_assignments.push_back("threads=" + value); },
     "worker threads; the result is the same for every N"},
    {"--strict", nullptr, true, [](Text, Parse& p) { p.options.strict = true; },
     "exit status 4 if a bound of the scene's expect is not met"},
    {"--check", nullptr, true, [](Text, Parse& p) { p.options.check = true; },
     "read the scene, its cloud and the options only; print problems and the columns of --statistics"},
    {"--quiet", nullptr, true, [](Text, Parse& p) { p.options.quiet = true; }, "errors and measured quantities only"},
    {"--version", nullptr, true, [](Text, Parse& p) { p.options.version = true; }, "print the version of the package"},
    {"--help", nullptr, true, [](Text, Parse& p) { p.options.help = true; }, "print this"},
};

std::string refuseUnknown(const std::string& option) {
  std::vector<std::string> known;
  for (const Option& each : kOptions) known.push_back(each.name);
  return "found the option " + quote(option) + "; the nearest known one is " + nearestWord(option, known) +
         "; accepted: those of --help";
}

// A line of --help, or several.
std::string describe(const std::string& option, std::string help) {
  constexpr std::size_t kColumn = 24;
  const std::string indent(kColumn, ' ');
  for (std::size_t at = 0; (at = help.find('\n', at)) != std::string::npos; ++at) help.insert(at + 1, indent);
  const std::string begin = "  " + option + " ";
  return begin + indent.substr(std::min(begin.size(), kColumn)) + help + "\n";
}

}  // namespace

SimulateOptions parseOptions(const std::vector<std::string>& arguments) {
  Parse parse;
  SimulateOptions& options = parse.options;
  std::vector<std::string>& problems = parse.problems;
  for (const char* name : {"cloud_in", "force", "wrench", "tools"})
    options.topics[name] = std::string("/deformable_surface/") + name;

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
    const auto option =
        std::find_if(std::begin(kOptions), std::end(kOptions), [&](const Option& each) { return argument == each.name; });
    if (option == std::end(kOptions)) {
      problems.push_back(refuseUnknown(argument));
      continue;
    }
    if (!option->value) {
      option->take({}, parse);
      continue;
    }
    if (i + 1 == arguments.size() || arguments[i + 1].empty()) {
      problems.push_back(argument + ": found nothing behind it; accepted: a value, see --help");
      ++i;
      continue;
    }
    const bool is_new = parse.given.insert(argument).second;
    if (!is_new && !option->is_repeatable) problems.push_back(argument + ": found twice; accepted: once");
    option->take(arguments[++i], parse);
  }
  options.assignments.insert(options.assignments.end(), parse.late_assignments.begin(), parse.late_assignments.end());

  if (options.help || options.version) return options;
  if (options.scene.empty() && problems.empty())
    problems.push_back("found no scene; accepted: simulate SCENE.yaml [options], see --help");
  if (parse.given.count("--frame_rate") > 0 && options.frames_directory.empty()) {
    problems.push_back("--frame_rate: found without --frames; accepted: together with --frames DIR");
  }
  if (parse.given.count("--mesh_pieces") > 0 && options.mesh_file.empty()) {
    problems.push_back("--mesh_pieces: found without --mesh; accepted: together with --mesh FILE.obj");
  }
  if (parse.given.count("--topic") > 0 && options.bag_in.empty()) {
    problems.push_back("--topic: found without --bag_in; accepted: together with --bag_in IN.bag");
  }
  if (!problems.empty()) throw InputError(std::move(problems));
  return options;
}

std::string describeOptions() {
  std::string text =
      "simulate SCENE.yaml [options]\n"
      "Runs a scene without a roscore, as fast as possible.\n\n";
  for (const Option& option : kOptions)
    text += describe(option.name + (option.value ? std::string(" ") + option.value : ""), option.help);
  return text +
         describe("--serve",
                  "without other options: execute the runs that a program requests on the standard input\n(docs/sweeps.md)") +
         "\nThe bounds of the scene's expect are checked after the last step. They hold for the scene's own cloud and duration.\n"
         "A bound that is not met is a note, with --strict an error.\n"
         "Exit status: 0 done; 2 the command line, the scene or an input file is wrong; 3 a step was refused, and the last\n"
         "good state is written; 4 with --strict: done, but a bound is not met; 128 + the signal: interrupted, and only the\n"
         "frames and the rows of --statistics and --wrenches until then are written.\n";
}

}  // namespace deformable_surface::node
