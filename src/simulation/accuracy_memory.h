// What trials chose for an accuracy target, kept in a folder from run to run. Trials of the same scene choose the same again, so
// that this changes no bit of a result, only the time that choosing takes.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <string>

namespace deformable_surface::simulation {

/// The folder: $DEFORMABLE_SURFACE_CACHE; without that variable $XDG_CACHE_HOME/deformable_surface or
/// $HOME/.cache/deformable_surface. Empty: there is none.
std::string findCacheFolder();

/// About five megabytes.
constexpr int kMostKeptChoices = 1000;

class ChoiceMemory {
 public:
  /// full: the surface that the trials are made of. It remembers nothing if params.accuracy.remember is false. Whatever the
  /// trials depend on is part of the name of the file: the scene, the surface and the build of this library.
  ChoiceMemory(const SceneParams& params, const RestSurface& full);

  /// False, and the choice is as it was: it was not kept, or the file is damaged.
  bool recall(AccuracyChoice& choice) const;
  /// Removes the choices that were used longest ago if there are more than kMostKeptChoices then. False: the folder cannot be
  /// written to. Only if isOn().
  bool keep(const AccuracyChoice& choice) const;
  bool isOn() const { return !path_.empty(); }

 private:
  std::string path_;  // empty: nothing is kept
};

}  // namespace deformable_surface::simulation
