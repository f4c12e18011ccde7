// Which links of a robot are tools. Their shapes and poses come from the URDF and tf.
#pragma once

#include "deformable_surface/base/params.h"

#include <string>
#include <vector>

namespace deformable_surface::tool {

struct RobotLinkParams {
  std::string name;
  double friction = 0.0;  // Coulomb's coefficient, >= 0
};

struct RobotParams {
  std::string description = "robot_description";  // the ROS parameter that holds the URDF
  std::string file;                               // a URDF in its place
  std::vector<RobotLinkParams> links;
};

inline void visit(Fields& fields, RobotLinkParams& p) {
  fields.required().text("name", p.name, "name of a link with collision geometry; also its tf frame");
  fields.require(!p.name.empty(), "name", "found empty text; accepted: the name of a link");
  fields.number("friction", p.friction, "", between(0.0, 1e3), "Coulomb coefficient");
}

inline void visit(Fields& fields, RobotParams& p) {
  fields.text("description", p.description, "the ROS parameter that holds the URDF");
  fields.text("file", p.file,
              "URDF file instead of the ROS parameter: path or `package://PACKAGE/PATH`. `simulate` needs it, and a bag with tf");
  fields.list("links", p.links, "Their collision geometry becomes solid tools that follow the tf frames.");
}

}  // namespace deformable_surface::tool
