// Which links of a robot are tools. Apart from tools, because what they look like and where they are comes from elsewhere.
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
  fields.required().text("name", p.name, "of a link with collision geometry, which is a frame of tf");
  fields.require(!p.name.empty(), "name", "found empty text; accepted: the name of a link");
  fields.number("friction", p.friction, "", between(0.0, 1e3), "Coulomb's coefficient");
}

inline void visit(Fields& fields, RobotParams& p) {
  fields.text("description", p.description, "the ROS parameter that holds the URDF");
  fields.text("file", p.file,
              "a URDF in its place: a path or `package://PACKAGE/PATH`; what `simulate` needs, with a bag that has tf");
  fields.list("links", p.links, "Their collision geometry is solid and follows their frames.");
}

}  // namespace deformable_surface::tool
