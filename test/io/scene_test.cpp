// Scene files: what is read, what is refused and with which message, overriding, printing, and the page of parameters.
#include "deformable_surface/io/scene.h"
#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

using namespace deformable_surface;
using namespace deformable_surface::io;
using simulation::SceneParams;

namespace {

SceneParams read(const std::string& text) { return readScene(parseYaml(text, "test.yaml")); }

std::vector<std::string> problemsOf(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    return error.problems();
  }
  return {};
}

/// The only problem of a scene with a model and this text.
std::string problemOf(const std::string& text) {
  const std::vector<std::string> problems = problemsOf("model: mass_spring\n" + text);
  if (problems.empty()) return "accepted";
  return problems.size() == 1 ? problems[0] : problems[0] + " (and more)";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Every section of a scene.
const char* const kFullScene = R"(
model: mass_spring
frame_id: ""
cloud: {shape: two_bars, points: 1000, size: [1.0, 0.2], gap: 0.015, jitter: 0.1, seed: 3, scale: 1.0}
material:
  young_modulus: 1e5
  poisson_ratio: 0.25
  thickness: 0.002
  bending_rigidity: 1.5e-3
  density: 900
  damping: 0.5
  spring_damping: 0.001
neighbors: {k: 12, geodesic_exponent: 1, radius: auto}
simplification: {method: none, target_points: 0, threshold: 0.1}
mass_spring: {membrane: triangles, bending: none, volume_stiffness: 10.0}
oriented_particles: {}
elastic_solid:
integrator: {type: implicit, time_step: 0.005}
accuracy: {position_error: 0.0, step_budget: 0.0}
gravity: [0, 0, -1.6]
gravity_frame: map
viscous_drag: 0.1
pressure: 2.0
pins: [{box: {min: [0, -1, -1], max: [0.1, 1, 1]}, orientation: false}, {sphere: {center: [0, 0, 0], radius: 0.1}}]
anchors: [{point: [1, 0, 0], target: [2, 0, 0], stiffness: 5}]
forces: [{id: pull, point: [1, 0, 0], force: [0, 0, 2], radius: 0.05, start: 0.0, end: 1.0},
         {id: push, point: [1, 0, 0], force: [0, 0, 2]}]
force: {radius: 0.02, timeout: 1.0}
tools: [{id: ball, mode: solid, shape: {sphere: {radius: 0.1}}, friction: 0.0,
         path: [{time: 0.0, position: [0, 0, 1], orientation: [0, 0, 0, 1]}]},
        {id: floor, shape: {plane: {}}, path: [{position: [0, 0, -1]}]}]
duration: 1.0
threads: 2
output: {normals: false, resample: true, publish_rate: 10}
input: {policy: ignore, max_points: 1000}
save_directory: "/var/lib/clouds"
diagnostics: false
expect: {max_displacement: [0.01, 0.02], kinetic_energy: [-.inf, 1e3]}
)";

}  // namespace

TEST(ReadScene, ReadsEveryField) {
  const SceneParams p = read(kFullScene);
  EXPECT_EQ(p.cloud.shape, simulation::CloudParams::Shape::kTwoBars);
  EXPECT_EQ(p.cloud.size.y(), 0.2);
  EXPECT_EQ(p.material.young_modulus, 1e5);
  EXPECT_EQ(p.material.bending_rigidity.valueOr(0.0), 1.5e-3);
  EXPECT_EQ(p.neighbors.k, 12);
  EXPECT_EQ(p.simplification.method, cloud::SimplificationMethod::kNone);
  EXPECT_EQ(p.mass_spring.bending, model::Bending::kNone);
  EXPECT_EQ(p.integrator.type, solve::IntegratorType::kImplicit);
  EXPECT_EQ(p.gravity.z(), -1.6);
  ASSERT_EQ(p.pins.size(), 2u);
  EXPECT_EQ(p.pins[0].region.kind, geometry::Region::Kind::kBox);
  EXPECT_EQ(p.pins[1].region.kind, geometry::Region::Kind::kSphere);
  EXPECT_EQ(p.pins[1].region.radius, 0.1);
  EXPECT_EQ(p.anchors[0].stiffness, 5.0);
  ASSERT_EQ(p.forces.size(), 2u);
  EXPECT_EQ(p.forces[0].end, 1.0);
  EXPECT_EQ(p.force.timeout, 1.0);
  EXPECT_FALSE(p.output.normals);
  EXPECT_EQ(p.input.policy, simulation::InputPolicy::kIgnore);
  EXPECT_EQ(p.save_directory, "/var/lib/clouds");
  ASSERT_EQ(p.expect.size(), 2u);
  EXPECT_EQ(p.expect[0].quantity, "max_displacement");
  EXPECT_EQ(p.expect[0].max, 0.02);
}

TEST(ReadScene, AcceptsWhatItPrints) {
  const SceneParams creased = read("model: oriented_particles\ncreases: [{box: {min: [0, 0, 0], max: [1, 1, 1]}}]");
  ASSERT_EQ(creased.creases.size(), 1u);
  EXPECT_EQ(creased.creases[0].region.max, Vec3(1, 1, 1));
  for (const SceneParams& params : {SceneParams(), read(kFullScene), creased}) {
    const std::string text = printScene(params);
    EXPECT_EQ(printScene(read(text)), text);
  }
  // Printing omits nothing: another value gives another text.
  SceneParams changed = read(kFullScene);
  changed.forces[1].start = 0.1 + 0.2;
  EXPECT_NE(printScene(changed), printScene(read(kFullScene)));
  EXPECT_EQ(read(printScene(changed)).forces[1].start, 0.1 + 0.2);
}

TEST(ReadScene, NeedsAModelAndNothingElse) {
  ASSERT_EQ(problemsOf("duration: 1").size(), 1u);
  EXPECT_EQ(problemsOf("duration: 1")[0], "model: missing; accepted: mass_spring, oriented_particles, elastic_solid");
  EXPECT_EQ(problemOf(""), "accepted");
}

TEST(ReadScene, EveryToolNeedsAShape) {
  const std::string path = "path: [{position: [0, 0, 0]}]";
  for (const char* shape : {"", "shape: , ", "shape: null, "})
    EXPECT_EQ(problemOf("tools: [{id: a, shape: {plane: {}}, " + path + "}, {id: b, " + shape + path + "}]"),
              "tools[1].shape: missing; accepted: one of sphere, box, cylinder, cone, plane, mesh")
        << shape;
  EXPECT_EQ(problemOf("tools: [{id: a, shape: {}, " + path + "}]"),
            "tools[0].shape: found 0 of sphere, box, cylinder, cone, plane and mesh; accepted: one");
}

TEST(ReadScene, TellsHowFarBondsOfParticlesMayBeToldToStretch) {
  const auto problem = [](const std::string& options) {
    const std::vector<std::string> problems = problemsOf("{model: oriented_particles, oriented_particles: {" + options + "}}");
    return problems.empty() ? "accepted" : problems[0];
  };
  const std::string free = problem("tear_strain: 0.42"), most = free.substr(free.find("up to ") + 6, 6);
  EXPECT_EQ(free, "oriented_particles.tear_strain: found 0.42; accepted: up to " + most +
                      ", where bonds of these exponents and this cutoff carry most");
  EXPECT_EQ(problem("tear_strain: " + most), "accepted");
  EXPECT_NE(problem("tear_strain: " + most + "9"), "accepted");
  EXPECT_EQ(problem("bonds: kept, tear_strain: 0.6"), "accepted");
  EXPECT_EQ(
      problem("bonds: kept, tear_strain: 0.61"),
      "oriented_particles.tear_strain: found 0.61; accepted: up to 0.6, the strain at the cutoff, beyond which no bond holds");
  EXPECT_EQ(problem("bonds: kept, cutoff: 1.9, tear_strain: 0.9"), "accepted");
}

TEST(ReadScene, TellsWhatTakesTheRestShapeFromKeptBonds) {
  const auto problem = [](const std::string& options) {
    const std::vector<std::string> problems =
        problemsOf("{model: oriented_particles, oriented_particles: {bonds: kept" + options + "}}");
    return problems.empty() ? "accepted" : problems[0];
  };
  const auto refuse = [](const std::string& found) {
    return "oriented_particles.bonds: found kept with " + found +
           "; accepted: kept with rest_shape cloud or auto, mode space and weighting isotropic";
  };
  EXPECT_EQ(problem(""), "accepted");
  EXPECT_EQ(problem(", rest_shape: flat"), refuse("rest_shape flat"));
  EXPECT_EQ(problem(", mode: plane"), refuse("mode plane"));
  EXPECT_EQ(problem(", weighting: anisotropic"), refuse("weighting anisotropic"));
}

TEST(ReadScene, NamesTheNearestKnownKey) {
  EXPECT_EQ(problemOf("material: {yung_modulus: 1}"),
            "material.yung_modulus: unknown key; the nearest known one is material.young_modulus");
  EXPECT_EQ(problemOf("young_modulus: 1"), "young_modulus: unknown key; the nearest known one is material.young_modulus");
  EXPECT_EQ(problemOf("forces: [{id: a, pont: [0, 0, 0], point: [0, 0, 0], force: [0, 0, 0]}]"),
            "forces[0].pont: unknown key; the nearest known one is forces[].point");
  EXPECT_TRUE(contains(problemsOf("model: mass_spring\ntools: [{id: a, shape: {ball: {radius: 1}}}]")[1],
                       "tools[0].shape.ball: unknown key; accepted: box, "));
  EXPECT_EQ(problemOf("expect: {max_displacment: [0, 1]}"),
            "expect.max_displacment: unknown quantity; the nearest known one is max_displacement");
}

TEST(ReadScene, CollectsAllProblems) {
  EXPECT_EQ(problemsOf("model: cloth\nduration: -1\nmaterial: {density: heavy}\nintegrator: {typ: verlet}").size(), 4u);
}

TEST(ReadScene, RefusesTheOutsideOfEveryRange) {
  // Numbers that no field of this kind accepts: above every upper limit, not finite, or NaN.
  const std::vector<std::string> numbers = {"cloud: {radius: X}",
                                            "cloud: {gap: X}",
                                            "cloud: {scale: X}",
                                            "cloud: {jitter: X}",
                                            "cloud: {points: X}",
                                            "cloud: {seed: X}",
                                            "cloud: {size: [1, X]}",
                                            "material: {young_modulus: X}",
                                            "material: {poisson_ratio: X}",
                                            "material: {thickness: X}",
                                            "material: {bending_rigidity: X}",
                                            "material: {bending_poisson_ratio: X}",
                                            "material: {density: X}",
                                            "material: {damping: X}",
                                            "material: {spring_damping: X}",
                                            "neighbors: {k: X}",
                                            "simplification: {target_points: X}",
                                            "simplification: {threshold: X}",
                                            "mass_spring: {volume_stiffness: X}",
                                            "mass_spring: {bending_spring_ratio: X}",
                                            "mass_spring: {membrane: springs, stiffness: uniform, spring_constant: X}",
                                            "integrator: {time_step: X}",
                                            "integrator: {max_substeps: X}",
                                            "integrator: {tolerance: X}",
                                            "integrator: {max_iterations: X}",
                                            "viscous_drag: X",
                                            "pressure: X",
                                            "gravity: [0, X, 0]",
                                            "force: {radius: X}",
                                            "force: {timeout: X}",
                                            "duration: X",
                                            "threads: X",
                                            "output: {publish_rate: X}",
                                            "output: {pieces_per_edge: X}",
                                            "input: {max_points: X}",
                                            "anchors: [{point: [0, 0, 0], target: [0, 0, 0], stiffness: X}]",
                                            "pins: [{sphere: {center: [0, 0, 0], radius: X}}]",
                                            "forces: [{id: a, point: [0, 0, 0], force: [0, 0, X]}]",
                                            "forces: [{id: a, point: [0, 0, X], force: [0, 0, 0]}]"};
  for (const std::string& number : numbers) {
    const std::size_t place = number.find('X');
    for (const char* bad : {"1e308", "-1e308", ".nan", ".inf", "-.inf", "much", "[]", "{}", "true", "~"}) {
      const std::string text = number.substr(0, place) + bad + number.substr(place + 1);
      EXPECT_TRUE(contains(problemOf(text), "; accepted: ")) << text << ": " << problemOf(text);
    }
    // Where a field must be positive, a value that is positive by rounding only is refused.
    if (contains(number, "modulus") || contains(number, "density") || contains(number, "thickness") ||
        contains(number, "time_step") || contains(number, "threshold") || contains(number, "tolerance") ||
        contains(number, "duration") || contains(number, "scale")) {
      for (const char* bad : {"0", "-1", "1e-310"}) {
        const std::string text = number.substr(0, place) + bad + number.substr(place + 1);
        EXPECT_NE(problemOf(text), "accepted") << text;
      }
    }
  }
}

TEST(ReadScene, RefusesWrongKinds) {
  EXPECT_EQ(problemOf("material: [1]"), "material: found a list of 1; accepted: a map");
  EXPECT_EQ(problemOf("pins: {}"), "pins: found an empty map; accepted: a list of maps");
  EXPECT_EQ(problemOf("gravity: [0, 0]"), "gravity: found a list of 2; accepted: a list of 3 numbers, each -1e6 to 1e6 (m/s^2)");
  EXPECT_EQ(problemOf("diagnostics: yes"), "diagnostics: found the text 'yes'; accepted: true or false");
  EXPECT_EQ(problemOf("frame_id: 5"), "frame_id: found 5; accepted: text (in quotes if it looks like something else)");
  EXPECT_EQ(problemOf("threads: 1.5"), "threads: found 1.5; accepted: an integer, 0 to 1024");
  EXPECT_EQ(problemOf("integrator: {type: rk4}"),
            "integrator.type: found the text 'rk4'; accepted: auto, verlet, symplectic_euler, explicit_euler, implicit, static");
}

TEST(ReadScene, SaysWhatIsNotBuiltYet) {
  EXPECT_TRUE(contains(problemOf("neighbors: {radius: 0.1}"), "found a number; accepted: auto"));
  EXPECT_TRUE(
      contains(problemOf("pins: [{sphere: {center: [0, 0, 0], radius: 1}, orientation: true}]"), "only oriented_particles"));
}

TEST(ReadScene, RefusesChoicesOfElasticSolidsThatDoNotGoTogether) {
  EXPECT_TRUE(
      contains(problemOf("elastic_solid: {dimension: planar, fill: true}"), "elastic_solid.fill: found true for a planar solid"));
  EXPECT_TRUE(contains(problemOf("elastic_solid: {law: linear, plasticity: {yield_stress: 1}}"), "found one with law: linear"));
  EXPECT_TRUE(contains(problemOf("elastic_solid: {law: neo_hookean, plasticity: {yield_stress: 1}}"),
                       "found one with law: neo_hookean; accepted: 0, or law: corotated"));
}

TEST(ReadScene, TakesOneAccuracyTargetWhereTheNumberOfPointsIsFree) {
  EXPECT_EQ(problemOf("accuracy: {position_error: 0.01}"), "accepted");
  EXPECT_EQ(problemOf("accuracy: {step_budget: 0.01}"), "accepted");
  EXPECT_EQ(problemOf("accuracy: {position_error: 0.01, step_budget: 0.01}"),
            "accuracy.step_budget: found beside a position_error; accepted: one of the two");
  EXPECT_EQ(problemOf("accuracy: {position_error: 0.01, estimate: false}"), "accepted");
  EXPECT_TRUE(contains(problemOf("accuracy: {position_error: -1}"), "accuracy.position_error"));
  EXPECT_TRUE(contains(problemOf("accuracy: {position_error: .nan}"), "accuracy.position_error"));
}

TEST(ReadScene, TakesADensityWherePointsAreChosenByIt) {
  const std::string adaptive = "simplification: {density: adaptive}";
  EXPECT_EQ(problemOf(adaptive), "accepted");
  EXPECT_EQ(problemOf("simplification: {density: uniform, method: none}"), "accepted");
  const std::string refused = "simplification.density: found adaptive where no points are chosen by it";
  EXPECT_TRUE(contains(problemOf("simplification: {density: adaptive, method: none}"), refused));
  for (const std::string model : {"elastic_solid", "oriented_particles"}) {
    const std::vector<std::string> problems = problemsOf("model: " + model + "\n" + adaptive);
    ASSERT_EQ(problems.size(), 1u) << model;
    EXPECT_TRUE(contains(problems[0], refused)) << problems[0];
  }
}

TEST(ReadScene, NamesWhatStatesTheNumberOfPointsBesideAnAccuracyTargetAndFollowsItsOwnAdvice) {
  const std::string target = "accuracy: {step_budget: 0.01}\nsimplification: ";
  const std::vector<std::array<std::string, 3>> cases{
      {"{target_points: 100}", "simplification.target_points 100", "simplification.target_points=0"},
      {"{threshold: 0.1}", "simplification.threshold 0.1", "simplification.threshold=auto"},
      {"{method: none}", "simplification.method none", "simplification.method=delaunay"}};
  for (const auto& [number, found, advice] : cases) {
    EXPECT_TRUE(contains(problemOf(target + number), "accuracy: found an accuracy target beside " + found + ", which states"))
        << number;
    EXPECT_TRUE(contains(problemOf(target + number), "give --set " + advice)) << number;
    Value root = parseYaml("model: mass_spring\n" + target + number, "test.yaml");
    setByPath(root, advice);
    EXPECT_NO_THROW(readScene(root)) << number;
  }
  EXPECT_TRUE(contains(problemOf(target + "{target_points: 100, threshold: 0.1}"),
                       "target_points 100, simplification.threshold 0.1, which states"));
}

TEST(ReadScene, HoldsRulesAmongFields) {
  EXPECT_EQ(problemOf("mass_spring: {membrane: springs}\nmaterial: {poisson_ratio: 0.333}"), "accepted");
  EXPECT_TRUE(contains(problemOf("mass_spring: {membrane: springs}\nmaterial: {poisson_ratio: 0.3}"), "by construction"));
  EXPECT_EQ(problemOf("material: {bending_poisson_ratio: 0.3}"), "accepted");
  EXPECT_TRUE(contains(problemOf("material: {bending_poisson_ratio: 0.3}\nmass_spring: {bending: none}"),
                       "material.bending_poisson_ratio: found one where nothing bends by it"));
  EXPECT_TRUE(contains(problemOf("material: {bending_poisson_ratio: 0.3, bending_rigidity: 0}"),
                       "material.bending_poisson_ratio: found one where nothing bends by it"));
  EXPECT_EQ(problemOf("mass_spring: {membrane: springs, stiffness: uniform, spring_constant: 100}"), "accepted");
  EXPECT_TRUE(contains(problemOf("mass_spring: {stiffness: uniform, spring_constant: 100}"), "mass_spring.stiffness: found"));
  EXPECT_EQ(problemOf("mass_spring: {membrane: springs, stiffness: uniform}"),
            "mass_spring.spring_constant: found 0 with stiffness: uniform; accepted: a constant above 0 (N/m)");
  EXPECT_EQ(problemOf("mass_spring: {membrane: springs, spring_constant: 100}"),
            "mass_spring.spring_constant: found 100.0 with stiffness: material; accepted: 0, or stiffness: uniform");
  EXPECT_EQ(problemOf("mass_spring: {damping: relative_velocity}\nmaterial: {spring_damping: 1e-4}"), "accepted");
  EXPECT_TRUE(contains(problemOf("mass_spring: {damping: relative_velocity}"), "which damps nothing; accepted: along_spring"));
  const std::string particles = "model: oriented_particles\n", bent = particles + "oriented_particles: {yield_curvature: 1.0";
  const std::vector<std::string> damped = problemsOf(particles + "material: {spring_damping: 1e-4}");
  ASSERT_EQ(damped.size(), 1u);
  EXPECT_TRUE(contains(damped[0], "a model that has no springs; accepted: 0"));
  EXPECT_TRUE(problemsOf(bent + "}").empty());
  const std::vector<std::string> anisotropic = problemsOf(bent + ", weighting: anisotropic}");
  ASSERT_EQ(anisotropic.size(), 1u);
  EXPECT_TRUE(contains(anisotropic[0], "which remember no shape; accepted: 0"));
  EXPECT_TRUE(
      contains(problemOf("creases: [{sphere: {center: [0, 0, 0], radius: 1}}]"), "only oriented_particles have an orientation"));
  EXPECT_EQ(problemOf("pins: [{}]"), "pins[0]: found neither of box and sphere; accepted: one");
  EXPECT_EQ(problemOf("pins: [{box: {min: [0, 0, 0], max: [0, 0, 0]}, sphere: {center: [0, 0, 0], radius: 1}}]"),
            "pins[0]: found both of box and sphere; accepted: one");
  EXPECT_EQ(problemOf("pins: [{box: {min: [0, 1, 0], max: [0, 0, 0]}}]"),
            "pins[0].box.min: found 1.0 in y, which is above max, 0.0; accepted: min <= max in x, y and z");
  EXPECT_TRUE(contains(problemOf("pins: [{box: {min: [0, 0, 0]}}]"), "pins[0].box.max: missing"));
  EXPECT_TRUE(contains(problemOf("forces: [{id: a, point: [0, 0, 0], force: [0, 0, 0], start: 2, end: 1}]"), "forces[0].end"));
  EXPECT_TRUE(contains(problemOf("forces: [{id: a, point: [0, 0, 0], force: [0, 0, 0], start: 2, end: 2}]"), "forces[0].end"));
  EXPECT_TRUE(contains(problemOf("forces: [{id: '', point: [0, 0, 0], force: [0, 0, 0]}]"), "forces[0].id"));
  EXPECT_TRUE(
      contains(problemOf("forces: [{id: a, point: [0, 0, 0], force: [0, 0, 0]}, {id: a, point: [0, 0, 0], force: [0, 0, 0]}]"),
               "forces[1].id: found 'a' a second time"));
  EXPECT_TRUE(contains(problemOf("cloud: {file: a.pcd, shape: sheet}"), "cloud.shape"));
  EXPECT_TRUE(contains(problemOf("simplification: {target_points: 2}"), "at least 3"));
  EXPECT_TRUE(contains(problemOf("expect: {max_speed: [2, 1]}"), "expect.max_speed: found [2, 1]"));
}

TEST(ParseYaml, RefusesWhatIsNoPlainMap) {
  const auto problem = [](const std::string& text) { return problemsOf(text).empty() ? "accepted" : problemsOf(text)[0]; };
  EXPECT_TRUE(contains(problem("a: [1, 2"), "test.yaml, line 1, column "));
  EXPECT_TRUE(contains(problem("- 1"), "a list of 1; accepted: a map"));
  EXPECT_TRUE(contains(problem(""), "nothing; accepted: a map"));
  EXPECT_TRUE(contains(problem("a: 1\n---\nb: 1"), "several YAML documents"));
  EXPECT_TRUE(
      contains(problem("a: &x [1]\nb: *x"),
               "line 2, column 4: found an alias (*name); accepted: the value written out (PyYAML: Dumper.ignore_aliases)"));
  EXPECT_TRUE(contains(problem("a: !degrees 90"), "the tag '!degrees'"));
  EXPECT_TRUE(contains(problem("a: 1\na: 2"), "the key 'a' twice"));
  EXPECT_TRUE(contains(problem("[1]: 2"), "not a word"));
  EXPECT_TRUE(contains(problem(std::string("a: \0", 4)), "zero byte"));
  EXPECT_TRUE(contains(problem("a: " + std::string(100, '[') + std::string(100, ']')), "levels of nesting"));
  // Far deeper than the stack allows.
  EXPECT_FALSE(problemsOf("a: " + std::string(200000, '[') + std::string(200000, ']')).empty());
  EXPECT_FALSE(problemsOf("a: " + std::string(200000, '{')).empty());
}

TEST(ParseYaml, KeepsQuotedNumbersAsText) {
  const Value value = parseYaml("a: '1'\nb: 1\nc: \"true\"", "test");
  EXPECT_TRUE(value.find("a")->asText());
  EXPECT_TRUE(value.find("b")->asInteger());
  EXPECT_TRUE(value.find("c")->asText());
}

TEST(LoadYamlFile, NamesTheFileThatCannotBeRead) {
  for (const char* path : {"/no/such/scene.yaml", "/"}) {
    try {
      loadYamlFile(path);
      FAIL() << path;
    } catch (const InputError& error) {
      EXPECT_TRUE(contains(error.what(), path)) << error.what();
    }
  }
}

TEST(SetByPath, OverridesAndAdds) {
  Value scene = parseYaml(kFullScene, "test.yaml");
  setByPath(scene, "integrator.time_step=2e-3");
  setByPath(scene, "forces.1.force=[1, 2, 3]");
  setByPath(scene, "forces[1].radius=0.5");
  setByPath(scene, "tools[0].path[0].position[2]=7");
  setByPath(scene, "frame_id=map");
  setByPath(scene, "save_directory=");
  const SceneParams params = readScene(scene);
  EXPECT_EQ(params.integrator.time_step, 2e-3);
  EXPECT_EQ(params.forces[1].force, Vec3(1, 2, 3));
  EXPECT_EQ(params.forces[1].radius, 0.5);
  EXPECT_EQ(params.tools[0].path[0].position.z(), 7.0);
  EXPECT_EQ(params.frame_id, "map");
  EXPECT_EQ(params.save_directory, "");

  Value empty = parseYaml("model: mass_spring", "test.yaml");
  setByPath(empty, "material.density=500");
  EXPECT_EQ(readScene(empty).material.density, 500.0);
  setByPath(empty, "materal.density=500");
  EXPECT_THROW(readScene(empty), InputError);
}

TEST(SetByPath, SaysHowManyItemsThereAre) {
  Value scene = parseYaml("tools: [{id: a}, {id: b}]\npins: []", "test.yaml");
  const auto findProblem = [&](const std::string& text) -> std::string {
    try {
      setByPath(scene, text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(findProblem("tools[9].friction=1").find("in a list of 2; accepted: 0 to 1"), std::string::npos);
  EXPECT_NE(findProblem("pins[0].orientation=true").find("in a list of 0; accepted: none"), std::string::npos);
  EXPECT_NE(findProblem("forces[0].radius=1").find("in a list that the scene does not have"), std::string::npos);
}

TEST(SetByPath, RefusesWhatIsNoAssignment) {
  Value scene = parseYaml(kFullScene, "test.yaml");
  for (const char* text : {"", "duration", "=1", "a..b=1", "forces.2.id=x", "forces.x.id=y", "forces[2].id=x", "forces[-1].id=x",
                           "[0].id=x", "duration.x=1", "duration=[1", "duration=*a"}) {
    EXPECT_THROW(setByPath(scene, text), InputError) << text;
  }
}

TEST(CheckForSimulate, NeedsACloudAndWholeSteps) {
  SceneParams params = read("{model: mass_spring, cloud: {shape: sheet}, duration: 0.3, integrator: {time_step: 0.1}}");
  EXPECT_NO_THROW(checkForSimulate(params));
  params.duration = 0.25;
  EXPECT_THROW(checkForSimulate(params), InputError);
  params.duration = 0.01;
  EXPECT_THROW(checkForSimulate(params), InputError);
  params.duration = 0.3;
  params.cloud.shape = simulation::CloudParams::Shape::kNone;
  EXPECT_THROW(checkForSimulate(params), InputError);
}

TEST(ReadScene, ShowsNoCharacterThatATerminalObeys) {
  const std::string clear = "\x1b[2J";
  for (const std::string& text :
       {"\"a" + clear + "\": 1", "expect: {\"max_x" + clear + "\": [0, 1]}", "integrator: {type: \"" + clear + "\"}",
        "tools: [{id: \"x" + clear + "\", shape: {sphere: {radius: 1}}, mode: \"" + clear + "\"}]"}) {
    // YAML itself refuses some of them, with a message of its own.
    std::string said;
    try {
      read("model: mass_spring\n" + text);
    } catch (const InputError& error) {
      said = error.what();
    }
    EXPECT_FALSE(said.empty()) << text;
    EXPECT_EQ(said.find('\x1b'), std::string::npos);
  }
  // A name of several megabytes is neither shown nor compared as a whole.
  const std::string long_name(4 << 20, 'q');
  const std::vector<std::string> problems = problemsOf("model: mass_spring\nexpect: {? " + long_name + " : [0, 1]}");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_LT(problems[0].size(), 300u);
}

// Every row of a table has as many cells as its head.
TEST(ParametersPage, HasRowsOfFiveCells) {
  std::istringstream page(parametersPage());
  int rows = 0;
  for (std::string line; std::getline(page, line);) {
    if (line.empty() || line[0] != '|') continue;
    int bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i) bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    EXPECT_EQ(bars, 6) << line;
    ++rows;
  }
  EXPECT_GT(rows, 100);
}

TEST(DefaultScene, IsTheOneInTheRepositoryAndReadsBackAsTheDefaults) {
  std::ifstream file(DEFORMABLE_SURFACE_SOURCE_DIR "/scenes/default.yaml");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), defaultScene()) << "make it anew with: parameters_page --scene > scenes/default.yaml";
  const Value root = parseYaml(defaultScene(), "default.yaml");
  SceneParams params = readScene(root);
  checkForSimulate(params);
  params.cloud.shape = simulation::CloudParams::Shape::kNone;
  params.cloud.points = SceneParams().cloud.points;
  params.duration = SceneParams().duration;
  params.expect.clear();
  EXPECT_EQ(printScene(params), printScene(SceneParams()));
  // Nothing is left out: every printed default is in the file, key by key.
  const Value defaults = parseYaml(printScene(SceneParams()), "defaults");
  for (const auto& [key, value] : *defaults.asMap()) {
    const Value* const section = root.find(key);
    ASSERT_TRUE(section) << key;
    if (!value.isMap()) continue;
    for (const auto& member : *value.asMap())
      EXPECT_TRUE(key == "expect" || section->find(member.first)) << key << "." << member.first;
  }
}

TEST(ParametersPage, IsWhatTheRepositoryHolds) {
  std::ifstream file(DEFORMABLE_SURFACE_SOURCE_DIR "/docs/parameters.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), parametersPage()) << "make it anew with: parameters_page > docs/parameters.md";
}

TEST(ReadScene, FiltersOfTheInputAreReadAndAllOffByDefault) {
  EXPECT_FALSE(read("model: mass_spring").input.filter.isOn());
  const SceneParams p = read(
      "model: mass_spring\n"
      "input:\n"
      "  filter:\n"
      "    crop: [{box: {min: [0, 0, 0], max: [1, 1, 1]}}, {sphere: {center: [1, 2, 3], radius: 0.5}, outside: true}]\n"
      "    range: {min: 0.3, max: 1.5}\n"
      "    flying_pixels: 0.02\n"
      "    plane: {distance: 0.003, radius: 0.01, min_share: 0.3, keep: far_side}\n"
      "    outliers: {method: statistical, neighbors: 12, deviations: 1.5}\n");
  const simulation::InputFilterParams& filter = p.input.filter;
  EXPECT_TRUE(filter.isOn());
  ASSERT_EQ(filter.crop.size(), 2u);
  EXPECT_TRUE(filter.crop[1].region.outside);
  EXPECT_EQ(filter.range.max, 1.5);
  EXPECT_EQ(filter.plane.keep, simulation::PlaneFilterParams::Keep::kFarSide);
  EXPECT_EQ(filter.outliers.neighbors, 12);
  const std::string text = printScene(p);
  EXPECT_EQ(printScene(read(text)), text);
  // Each one alone is on.
  for (const char* one : {"crop: [{sphere: {center: [0, 0, 0], radius: 1}}]", "range: {min: 0.1}", "range: {max: 5}",
                          "flying_pixels: 0.01", "plane: {distance: 0.001}", "outliers: {method: statistical}"})
    EXPECT_TRUE(read(std::string("model: mass_spring\ninput: {filter: {") + one + "}}").input.filter.isOn()) << one;
}

TEST(ReadScene, FiltersOfTheInputThatCannotBeAreRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"range: {min: 2, max: 1}", "input.filter.range.max: found 1.0, which is not above min, 2.0; accepted: min < max"},
      {"range: {min: 1, max: 1}", "input.filter.range.max: found 1.0"},
      {"range: {min: -1}", "input.filter.range.min: found -1"},
      {"range: {max: .nan}", "input.filter.range.max: found "},
      {"range: {max: .inf}", "input.filter.range.max: found "},
      {"flying_pixels: -0.1", "input.filter.flying_pixels: found -0.1"},
      {"flying_pixels: .nan", "input.filter.flying_pixels: found "},
      {"plane: {distance: -1}", "input.filter.plane.distance: found -1"},
      {"plane: {radius: .inf}", "input.filter.plane.radius: found "},
      {"plane: {min_share: 0}", "input.filter.plane.min_share: found 0"},
      {"plane: {min_share: 1.1}", "input.filter.plane.min_share: found 1.1"},
      {"plane: {keep: above}", "input.filter.plane.keep: found "},
      {"outliers: {method: radius}", "input.filter.outliers.radius: found 0 with the method radius"},
      {"outliers: {radius: 0.01}", "input.filter.outliers.radius: found 0.01 without the method that uses it; accepted: method "},
      {"outliers: {method: statistical, radius: 1}", "input.filter.outliers.radius: found 1.0 without the method that uses it"},
      {"outliers: {deviations: 3}", "input.filter.outliers.deviations: found 3.0 without the method that uses it"},
      {"outliers: {neighbors: 3}", "input.filter.outliers.neighbors: found 3 without a method that uses it"},
      {"plane: {radius: 0.1}", "input.filter.plane.distance: found 0, which turns the filter off, beside its other parameters"},
      {"plane: {keep: near_side}", "input.filter.plane.distance: found 0, which turns the filter off"},
      {"outliers: {method: mean}", "input.filter.outliers.method: found "},
      {"outliers: {neighbors: 0}", "input.filter.outliers.neighbors: found 0"},
      {"outliers: {neighbors: 1001}", "input.filter.outliers.neighbors: found 1001"},
      {"outliers: {deviations: -1}", "input.filter.outliers.deviations: found -1"},
      {"crop: [{outside: true}]", "input.filter.crop[0]: found neither of box and sphere"},
      {"crop: [{box: {min: [1, 0, 0], max: [0, 1, 1]}}]", "input.filter.crop[0].box.min: found 1.0 in x, which is above max"},
      {"crop: {box: {min: [0, 0, 0], max: [1, 1, 1]}}", "input.filter.crop: found "},
      {"crops: []", "input.filter.crops: unknown key; the nearest known one is input.filter.crop"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string problem = problemOf(std::string("input: {filter: {") + text + "}}");
    EXPECT_TRUE(contains(problem, expected)) << text << ": " << problem;
  }
}
