#include "deformable_surface/io/load_scene.h"

#include "deformable_surface/io/mesh_files.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/io/volume_files.h"

namespace deformable_surface::io {

simulation::SceneParams loadScene(const std::string& file, const std::vector<std::string>& assignments,
                                  const FindPackage& find_package) {
  Value root = loadYamlFile(file);
  for (const std::string& assignment : assignments) setByPath(root, assignment);
  simulation::SceneParams params = readScene(root);
  readMeshFiles(params.tools, find_package);
  readGuide(params.oriented_particles.guide, find_package);
  return params;
}

cloud::PointCloud loadCloud(const simulation::SceneParams& params, const FindPackage& find_package) {
  if (params.cloud.file.empty()) return makeShape(params.cloud);
  return readPointFile(params.cloud.file, params.cloud.scale, params.input.max_points, find_package);
}

}  // namespace deformable_surface::io
