#include "deformable_surface/io/mesh_files.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

namespace deformable_surface::io {

geometry::Solid readMeshFile(const std::string& file, const Vec3& scale, const FindPackage& find_package) {
  const std::string scheme = "file://";
  const std::string path =
      file.compare(0, scheme.size(), scheme) == 0 ? file.substr(scheme.size()) : findPointFile(file, find_package);
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* const scene =
      importer.ReadFile(path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  if (!scene) throw InputError("mesh " + quote(file) + ": " + importer.GetErrorString() + "; accepted: a mesh that can be read");
  Points vertices, triangles;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const double first = static_cast<double>(vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      vertices.push_back(scale.cwiseProduct(Vec3(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z)));
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const unsigned* const corners = mesh.mFaces[f].mIndices;
      triangles.push_back(Vec3::Constant(first) + Vec3(corners[0], corners[1], corners[2]));
    }
  }
  geometry::Solid solid;
  solid.kind = geometry::Solid::Kind::kMesh;
  const std::string problem = geometry::setMesh(vertices, triangles, solid);
  if (!problem.empty()) throw InputError("mesh " + quote(file) + ": " + problem);
  return solid;
}

void readMeshFiles(std::vector<tool::ToolParams>& tools, const FindPackage& find_package) {
  for (tool::ToolParams& tool : tools)
    if (!tool.shape.mesh_file.empty())
      tool.shape = readMeshFile(tool.shape.mesh_file, Vec3::Constant(tool.shape.mesh_scale), find_package);
}

}  // namespace deformable_surface::io
