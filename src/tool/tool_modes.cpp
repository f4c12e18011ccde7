// Text of messages and pages about tool modes, generated from their table.
#include "deformable_surface/tool/tool_params.h"

#include <algorithm>
#include <cctype>

namespace deformable_surface::tool {

std::string messageName(const ModeInfo& info) {
  std::string name = info.name;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return name;
}

const char* describeModes() {
  static const std::string all = [] {
    std::string text;
    for (const ModeInfo& info : kModes) text += (text.empty() ? "`" : "; `") + std::string(info.name) + "` " + info.meaning;
    return text;
  }();
  return all.c_str();
}

const char* describeStrengths() {
  static const std::string all = [] {
    std::string text;
    for (const ModeInfo& info : kModes)
      if (info.strength) text += (text.empty() ? "" : "; ") + std::string(info.name) + ": " + info.strength;
    return text;
  }();
  return all.c_str();
}

std::vector<std::pair<const char*, Mode>> listModes() {
  std::vector<std::pair<const char*, Mode>> names;
  for (const ModeInfo& info : kModes) names.emplace_back(info.name, info.mode);
  return names;
}

}  // namespace deformable_surface::tool
