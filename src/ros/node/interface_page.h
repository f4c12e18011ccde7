// The topics and services of the node as a table: what its help and docs/interface.md print, and what a test holds against the
// node that runs. In a file of its own so that the three say the same.
#pragma once

#include <string>
#include <vector>

namespace deformable_surface::node {

enum class InterfaceKind { kSubscribed, kPublished, kService };

/// A message file, or a part of a service's.
struct Definition {
  std::string type;  // of this package, as in "Tool"; empty: it belongs to the entry alone
  std::string text;
};

struct InterfaceEntry {
  InterfaceKind kind;
  std::string name;                     // below the node's private name; a leading slash: global
  std::string type;                     // as in "sensor_msgs/PointCloud2"
  std::string meaning;                  // Markdown, without the bar of tables
  std::vector<Definition> definitions;  // its message files, the types that they use behind them; none: of another package
};

const std::vector<InterfaceEntry>& interfaceTable();

/// The page docs/interface.md.
std::string interfacePage();

/// The same for a terminal: a line for each.
std::string interfaceHelp();

}  // namespace deformable_surface::node
