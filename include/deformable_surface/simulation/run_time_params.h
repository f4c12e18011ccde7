// The values of a scene that may change while its surface runs. The simulation takes them, snapshots hold them, and the node
// offers them, all by the same list.
#pragma once

#include "deformable_surface/simulation/scene_params.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

/// The values that a step reads. They belong to the state.
struct RunTimePhysics {
  Vec3 gravity = Vec3::Zero();  // m/s^2
  double young_modulus = 0.0;   // Pa
  double damping = 0.0;         // 1/s
  double viscous_drag = 0.0;    // N s/m per m^2
  double pressure = 0.0;        // Pa
};

inline RunTimePhysics findPhysics(const SceneParams& p) {
  return {p.gravity, p.material.young_modulus, p.material.damping, p.viscous_drag, p.pressure};
}

inline void setPhysics(const RunTimePhysics& physics, SceneParams& p) {
  p.gravity = physics.gravity;
  p.material.young_modulus = physics.young_modulus;
  p.material.damping = physics.damping;
  p.viscous_drag = physics.viscous_drag;
  p.pressure = physics.pressure;
}

/// The scene with those values of the other one that may change at run time: the above and those of outputs.
inline SceneParams withRunTimeValues(SceneParams scene, const SceneParams& other) {
  setPhysics(findPhysics(other), scene);
  scene.output.normals = other.output.normals;
  scene.output.publish_rate = other.output.publish_rate;
  return scene;
}

/// The keys of these values.
inline const std::vector<std::string>& runTimeKeys() {
  static const std::vector<std::string> keys = {"gravity",  "material.young_modulus", "material.damping",   "viscous_drag",
                                                "pressure", "output.normals",         "output.publish_rate"};
  return keys;
}

}  // namespace deformable_surface::simulation
