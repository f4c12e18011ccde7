#include "faster_steps.h"

#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace deformable_surface::node {
namespace {

constexpr double kGoodShare = 0.1;  // of a step; what takes less is not worth a change

std::string sayShare(double seconds, double of) {
  return std::to_string(std::lround(100.0 * seconds / of)) + " % of the last step";
}

}  // namespace

bool touchesCloudPoints(const simulation::Simulation& simulation) {
  const Points& positions = simulation.state().positions;
  const std::vector<simulation::Contact> contacts = simulation.contacts();
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](const simulation::Contact& contact) { return contact.position != positions[contact.point]; });
}

std::string nameFaster(const simulation::SceneParams& params, const simulation::Statistics& last, bool touches_cloud_points) {
  const double total = last.time_total;
  const bool is_implicit = last.solver_iterations > 0;
  std::string names;
  if (last.time_estimate > kGoodShare * total)
    names += "accuracy.estimate: false (it is " + sayShare(last.time_estimate, total) + "), ";
  // Stiff contact can also be why steps are implicit, of which it then takes no time that tells.
  if (touches_cloud_points && (is_implicit || last.time_contact > kGoodShare * total)) names += "contact.cloud_points: 0, ";
  if (is_implicit) names += "a larger integrator.tolerance, ";
  names += simulation::findModel(params.model).traits().has_population ? "a larger oriented_particles.spacing"
                                                                       : "fewer simulation points";
  if (last.self_contacts > 0) names += ", contact.self: false (parts then pass through each other)";
  return names;
}

}  // namespace deformable_surface::node
