#include "stretch_watch.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

#include "dynamics.h"
#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

// A look takes less than a sub-step.
constexpr Index kSubstepsPerLook = 50;
// A stretch that reaches from one grip to another is largest beside one of them.
constexpr double kAround = 0.3;
constexpr std::size_t kMostNamed = 4;  // more names make no line that is read

void addNew(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// Marks the points that are linked to a first one through points of strains above kAround alone.
std::vector<char> markAround(Index first, const std::vector<double>& strain, const std::vector<std::pair<Index, Index>>& links) {
  std::vector<char> marks(strain.size(), 0);
  marks[first] = 1;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const auto& [i, j] : links) {
      if (marks[i] == marks[j] || !(strain[i] > kAround && strain[j] > kAround)) continue;
      marks[i] = marks[j] = 1;
      has_grown = true;
    }
  }
  return marks;
}

std::string list(const std::vector<std::string>& names, const std::string& of_one, const std::string& of_many) {
  std::string text;
  for (std::size_t k = 0; k < std::min(names.size(), kMostNamed); ++k)
    text += (k == 0 ? "" : k + 1 == names.size() ? " and " : ", ") + names[k];
  if (names.size() > kMostNamed) text += " and " + std::to_string(names.size() - kMostNamed) + " more";
  return names.empty() ? "" : text + " " + (names.size() == 1 ? of_one : of_many) + " it there";
}

}  // namespace

bool StretchWatch::endStep(const model::DeformableModel& model, const model::State& state, Index substeps, bool must_look) {
  since_look_ += substeps;
  if (since_look_ < kSubstepsPerLook && !must_look) return is_over_;
  since_look_ = 0;
  const bool was_above = is_above_;
  stretch_ = maxStretchOf(model, state);
  is_above_ = stretch_ > kMost;
  is_over_ = is_above_ && (was_above || must_look);
  return is_over_;
}

Overstretch findOverstretch(const Dynamics& dynamics) {
  const model::State& state = dynamics.state();
  std::vector<double> strain;
  computePointStrain(dynamics.model(), state, strain);
  const Index worst = static_cast<Index>(std::max_element(strain.begin(), strain.end()) - strain.begin());
  Overstretch over;
  over.is_surface = dynamics.kind().traits().is_surface;
  over.has_law_for_it = !over.is_surface && dynamics.params().elastic_solid.law == model::SolidLaw::kNeoHookean;
  over.stretch = strain[worst];
  over.place = state.positions[worst];

  const std::vector<char> around = markAround(worst, strain, stretchLinksOf(dynamics.model()));
  for (const Grips::Grip& grip : dynamics.grips().all())
    for (const Index i : grip.points)
      if (around[i]) addNew(over.holders, grip.is_pin ? grip.tool.id : "tool " + quote(grip.tool.id));
  const std::size_t pins = dynamics.params().pins.size();
  for (Index i = 0; i < state.size(); ++i) {
    if (!around[i] || !dynamics.pinned()[i] || dynamics.grips().isOnPin(i)) continue;
    const std::size_t pin = dynamics.findPin(i);
    addNew(over.holders, pin < pins ? "pins[" + std::to_string(pin) + "]" : "a pin set by a command");
  }
  for (const Contact& contact : dynamics.contacts())
    if (around[contact.point] && !contact.force.isZero(0.0))
      addNew(over.pushers, "tool " + quote(dynamics.tools()[contact.tool].id));
  return over;
}

std::string describeOverstretch(const Overstretch& over) {
  const std::string what = over.is_surface ? "the surface" : "the body";
  const std::string held = list(over.holders, "holds", "hold"), touched = list(over.pushers, "touches", "touch");
  const std::string told =
      what + " is stretched by " + std::to_string(std::llround(100.0 * over.stretch)) + " % at " + formatPlace(over.place) +
      " m" +
      (over.has_law_for_it
           ? "; "
           : ": its material law is meant for small strains, and shape and forces there are not those of a material; ");
  if (held.empty() && touched.empty())
    return told + "no tool or pin acts there: loads or speeds are too large for its stiffness (statistics: max_stretch)";
  return told + held + (!held.empty() && !touched.empty() ? " and " : "") + touched +
         (over.holders.size() + over.pushers.size() > 1 ? ": they move apart by more than " : ": it moves by more than ") + what +
         " can give way (statistics: max_stretch)";
}

}  // namespace deformable_surface::simulation
