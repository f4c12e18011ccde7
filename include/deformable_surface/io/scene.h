// Scene files: from YAML text to the parameters of a scene and back. The node makes the Value from its ROS parameters instead;
// the rest is the same.
#pragma once

#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/scene_params.h"

#include <string>

namespace deformable_surface::io {

/// The map in one YAML document. Throws InputError, with the name of the text and the line, for invalid YAML, several
/// documents, a root that is no map, duplicate keys, aliases, tags and nesting deeper than any scene's.
Value parseYaml(const std::string& text, const std::string& name);

/// The same for a file. Also throws if it cannot be read or is larger than any scene.
Value loadYamlFile(const std::string& path);

/// Sets one value by "path=YAML value", e.g. "integrator.time_step=0.002", "forces.0.radius=0.1" or "forces[0].radius=0.1". List
/// items, from 0, must exist. Nothing after the = means the empty text. Throws InputError; readScene() finds unknown keys.
void setByPath(Value& root, const std::string& assignment);

/// The scene that a map describes. Keys may have the names of the version before (SceneParams::notices). Throws InputError with
/// all problems at once.
simulation::SceneParams readScene(const Value& value);

/// Further rules for a run without a node: the scene gives a cloud if it needs one, and the duration is a multiple of the time
/// step. Throws InputError.
void checkForSimulate(const simulation::SceneParams& params, bool needs_cloud = true);

/// Every value of the scene as YAML that readScene() accepts.
std::string printScene(const simulation::SceneParams& params);

/// The page docs/parameters.md.
std::string parametersPage();

/// The scene scenes/default.yaml: the default of every value, except of the few that make it a scene, with comments.
std::string defaultScene();

}  // namespace deformable_surface::io
