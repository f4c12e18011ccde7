// The topics and services of the node as a table. The node's help and docs/interface.md print it, and a test compares it with
// the running node.
#pragma once

#include <string>
#include <vector>

namespace deformable_surface::node {

enum class InterfaceKind { kSubscribed, kPublished, kService };

/// A message file, or a part of a service file.
struct Definition {
  std::string type;  // of this package, as in "Tool"; empty: it belongs to the entry alone
  std::string text;
};

struct InterfaceEntry {
  InterfaceKind kind;
  std::string name;                     // below the node's private name; a leading slash: global
  std::string type;                     // as in "sensor_msgs/PointCloud2"
  std::string meaning;                  // Markdown, without the bar of tables
  std::vector<Definition> definitions;  // its message files, then the types that they use; empty: of another package
};

const std::vector<InterfaceEntry>& interfaceTable();

/// The page docs/interface.md.
std::string interfacePage();

/// The same for a terminal, one line each.
std::string interfaceHelp();

}  // namespace deformable_surface::node
