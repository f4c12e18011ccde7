// The table of tool modes: names, message codes, colours, and the fields that each mode uses with each model. Scenes, messages,
// menus and markers all read it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace deformable_surface::tool {

/// Effect of a tool; see docs/tools.md.
enum class Mode { kSolid, kAttract, kMove, kErase, kCut, kHeat };

/// The fields that a mode reads; others must not be given.
struct ModeUse {
  bool is_known = false;  // the model has this mode
  bool friction = false, strength = false, reach = false;
};

struct ModeInfo {
  Mode mode;
  const char* name;   // in scenes; in upper case in messages
  std::uint8_t code;  // in messages
  const char* meaning;
  const char* strength;        // its unit and meaning; null: no model uses it
  bool needs_strength;         // the mode has no effect with 0
  ModeUse everywhere;          // with every model; a model may add to it (ModelKind::useOf())
  std::array<float, 3> color;  // red, green, blue
};

inline constexpr ModeUse kUnknown{}, kPlain{true}, kRubs{true, true}, kStrong{true, false, true}, kRubsHot{true, true, true},
    kReaches{true, false, true, true};

/// In the order of Mode.
inline constexpr ModeInfo kModes[] = {
    {Mode::kSolid, "solid", 0, "pushes the surface out", nullptr, false, kRubs, {0.6f, 0.6f, 0.6f}},
    {Mode::kAttract,
     "attract",
     1,
     "pulls the surface to the tool's surface",
     "N/m, shared among all points by mass",
     true,
     kReaches,
     {0.2f, 0.4f, 0.9f}},
    {Mode::kMove,
     "move",
     2,
     "carries the points that are inside when it "
     "starts",
     "force in N at which the grip slips, 0 = never",
     false,
     kStrong,
     {0.2f, 0.8f, 0.3f}},
    {Mode::kErase, "erase", 3, "deletes the particles inside (oriented particles)", nullptr, false, kUnknown, {0.9f, 0.9f, 0.9f}},
    {Mode::kCut,
     "cut",
     4,
     "cuts the links or bonds that it passes between (mass_spring, oriented_particles); with a strength it is solid and heats "
     "what it touches instead (oriented particles)",
     "K above ambient, 0 = it cuts and does not heat (oriented particles)",
     false,
     kUnknown,
     {0.9f, 0.8f, 0.1f}},
    {Mode::kHeat,
     "heat",
     5,
     "heats the particles inside (oriented "
     "particles)",
     "K above ambient",
     true,
     kUnknown,
     {0.9f, 0.3f, 0.1f}},
};

/// False of a value that is none of the modes, as programs can make one.
constexpr bool isMode(Mode mode) { return static_cast<std::size_t>(mode) < std::size(kModes); }

/// Only if isMode().
constexpr const ModeInfo& infoOf(Mode mode) { return kModes[static_cast<int>(mode)]; }

/// The mode with this message code; null: none.
inline const ModeInfo* findMode(int code) {
  for (const ModeInfo& info : kModes)
    if (info.code == code) return &info;
  return nullptr;
}

/// "SOLID", as the message has it.
std::string messageName(const ModeInfo& info);

}  // namespace deformable_surface::tool
