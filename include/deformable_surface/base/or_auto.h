// A parameter that is either given or left to the program: "auto" in scene files.
#pragma once

namespace deformable_surface {

template <class T>
struct OrAuto {
  bool is_auto = true;
  T value{};

  OrAuto() = default;
  OrAuto(T given) : is_auto(false), value(given) {}  // NOLINT: a plain value stands for itself
  /// The given value, or what the program chose.
  T valueOr(T chosen) const { return is_auto ? chosen : value; }
};

}  // namespace deformable_surface
