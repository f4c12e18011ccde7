#include "deformable_surface/ros/convert/robot_tools.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/mesh_files.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/ros/convert/find_package.h"
#include "deformable_surface/ros/convert/tool_commands.h"

#include <urdf/model.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

namespace deformable_surface::node {
namespace {

using shape_msgs::SolidPrimitive;

std::string toToolId(const std::string& link, std::size_t piece) {
  std::string id = link;
  for (char& c : id)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  if (!std::isalpha(static_cast<unsigned char>(id[0]))) id = "link_" + id;
  return piece == 0 ? id : id + "_" + std::to_string(piece);
}

// Of two tools with one id the second would never be there, and one without an acceptable id would wait for ever. link_of_id:
// those before it.
void requireOwnId(const std::string& id, const std::string& link, std::map<std::string, std::string>& link_of_id) {
  if (!isToolId(id))
    throw InputError("robot.links: link " + quote(link) + " becomes the tool " + quote(id) +
                     "; accepted: names that give ids of up to 64 characters");
  const auto [before, is_new] = link_of_id.emplace(id, link);
  if (!is_new)
    throw InputError("robot.links: links " + quote(before->second) + " and " + quote(link) + " both become the tool " +
                     quote(id) + "; accepted: each link once, and names that differ in letters or digits");
}

void setPrimitive(std::uint8_t type, const std::vector<double>& dimensions, Tool& tool) {
  tool.shape = Tool::PRIMITIVE;
  tool.primitive.type = type;
  tool.primitive.dimensions = dimensions;
}

void setMesh(const urdf::Mesh& mesh, Tool& tool) {
  tool.shape = Tool::MESH;
  const geometry::Solid solid = io::readMeshFile(mesh.filename, Vec3(mesh.scale.x, mesh.scale.y, mesh.scale.z), findPackage);
  for (const Vec3& v : solid.mesh->vertices()) {
    geometry_msgs::Point vertex;
    vertex.x = v.x();
    vertex.y = v.y();
    vertex.z = v.z();
    tool.mesh.vertices.push_back(vertex);
  }
  for (const geometry::Polyhedron::Triangle& t : solid.mesh->triangles()) {
    tool.mesh.triangles.emplace_back();
    std::copy(t.begin(), t.end(), tool.mesh.triangles.back().vertex_indices.begin());
  }
}

void setShape(const urdf::Geometry& geometry, Tool& tool) {
  switch (geometry.type) {
    case urdf::Geometry::SPHERE:
      return setPrimitive(SolidPrimitive::SPHERE, {static_cast<const urdf::Sphere&>(geometry).radius}, tool);
    case urdf::Geometry::BOX: {
      const urdf::Vector3& size = static_cast<const urdf::Box&>(geometry).dim;
      return setPrimitive(SolidPrimitive::BOX, {size.x, size.y, size.z}, tool);
    }
    case urdf::Geometry::CYLINDER: {
      const urdf::Cylinder& cylinder = static_cast<const urdf::Cylinder&>(geometry);
      return setPrimitive(SolidPrimitive::CYLINDER, {cylinder.length, cylinder.radius}, tool);
    }
    case urdf::Geometry::MESH: return setMesh(static_cast<const urdf::Mesh&>(geometry), tool);
  }
}

}  // namespace

std::vector<Tool> makeRobotTools(const std::string& urdf, const std::vector<tool::RobotLinkParams>& links) {
  urdf::Model model;
  if (!model.initString(urdf)) throw InputError("robot: found a description that cannot be read; accepted: a URDF");
  std::vector<Tool> tools;
  std::map<std::string, std::string> link_of_id;
  for (const tool::RobotLinkParams& params : links) {
    const urdf::LinkConstSharedPtr link = model.getLink(params.name);
    if (!link)
      throw InputError("robot.links: the description has no link " + quote(params.name) + "; accepted: links that it has");
    std::size_t piece = 0;
    for (const urdf::CollisionSharedPtr& collision : link->collision_array) {
      if (!collision || !collision->geometry) continue;
      Tool tool;
      tool.id = toToolId(params.name, piece++);
      requireOwnId(tool.id, params.name, link_of_id);
      tool.header.frame_id = params.name;
      tool.follow_frame = true;
      tool.friction = params.friction;
      try {
        setShape(*collision->geometry, tool);
      } catch (const InputError& error) {
        throw InputError("robot link " + quote(params.name) + ": " + error.what());
      }
      const urdf::Pose& origin = collision->origin;
      tool.pose.position.x = origin.position.x;
      tool.pose.position.y = origin.position.y;
      tool.pose.position.z = origin.position.z;
      origin.rotation.getQuaternion(tool.pose.orientation.x, tool.pose.orientation.y, tool.pose.orientation.z,
                                    tool.pose.orientation.w);
      tools.push_back(tool);
    }
    if (piece == 0)
      throw InputError("robot.links: link " + quote(params.name) + " has no collision geometry; accepted: links that have");
  }
  return tools;
}

std::string readDescription(const std::string& file) {
  std::ifstream stream(io::findPointFile(file, findPackage));
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream || text.str().empty())
    throw InputError("robot.file: found " + quote(file) + ", which cannot be read; accepted: a URDF");
  return text.str();
}

}  // namespace deformable_surface::node
