#include "membrane_choice.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

using Candidate = AccuracyChoice::Candidate;

// The first membrane that is tried has this share of the stated stiffness, so that its steps take half as many sub-steps.
constexpr double kSofter = 0.25;
constexpr double kSoftest = 1.0 / 4096.0;
constexpr double kWorthwhile = 0.9;   // of the work: a softer membrane must save this, else bending or loads set the sub-steps
constexpr double kMembraneAim = 0.7;  // of the room that the error of the points leaves

}  // namespace

void chooseMembrane(const SceneParams& params, const RestSurface& full, const Probe& stated, WorkBudget& budget,
                    AccuracyChoice& choice) {
  const double target = params.accuracy.position_error;
  double apart = 0.0;  // m, of the last trial
  const auto isBetter = [&](double share) {
    Candidate tried = stated.candidate;
    tried.error = tried.work = 0.0;
    tried.membrane_share = share;
    if (stated.candidate.work * std::sqrt(share) > budget.left()) return false;
    Probe probe = probeError(params, full, tried, target, &stated, {budget.left()});
    budget.spend(probe.spent);
    choice.candidates.push_back(probe.candidate);
    apart = probe.apart.empty() ? 0.0 : probe.apart.back();
    if (probe.failed || !probe.candidate.is_bounded || !(probe.candidate.work < kWorthwhile * choice.work)) return false;
    choice.take(probe.candidate);
    choice.softening = std::move(probe.apart);
    return true;
  };
  if (!isBetter(kSofter)) {
    if (apart > 0.0) isBetter(std::sqrt(kSofter));  // half way back
    return;
  }
  const double room = kMembraneAim * (target - stated.candidate.error), each = apart / (1.0 / kSofter - 1.0);
  const double softest = std::max(kSoftest, each > 0.0 ? each / (each + std::max(0.0, room)) : kSoftest);
  if (softest < kWorthwhile * kWorthwhile * kSofter && !isBetter(softest)) isBetter(std::sqrt(softest * kSofter));
}

}  // namespace deformable_surface::simulation
