// Part 7: errors against closed forms and published tables, and the order with which they fall. Every problem is a file in
// physics/. The tests in test/physics use the same problems at coarse resolutions.
#include "physics/problem.h"
#include "physics/samplings.h"
#include "sections.h"

#include <cmath>

namespace deformable_surface::benchmark {
namespace {

constexpr std::size_t kQuickSizes = 3;  // the fewest from which an order has a spread
constexpr double kExact = 1e-9;         // an error below this is rounding or the solver's tolerance, and has no order

std::string showOrder(const physics::Problem& problem, const std::vector<physics::Answer>& answers) {
  if (problem.other_law) return "other law";
  for (const physics::Answer& a : answers)
    if (!a.failure.empty()) return "-";
  for (const physics::Answer& a : answers)
    if (!(a.error > kExact)) return "exact";
  const physics::Order order = physics::fitOrder(answers);
  char text[64];
  std::snprintf(text, sizeof text, "%.2f +- %.2f", order.value, order.spread);
  return text;
}

std::string nameMembrane(const physics::Problem& problem, const physics::Variant& variant) {
  return problem.is_solid ? "-" : physics::nameMembrane(variant);
}

std::string nameBending(const physics::Problem& problem, const physics::Variant& variant) {
  return problem.is_solid ? "-" : physics::nameBending(variant);
}

}  // namespace

void runPhysicsSection(const Options& options, Report& report) {
  std::vector<physics::Problem> problems;
  for (const auto& list :
       {physics::listMotions, physics::listHanging, physics::listMembranes, physics::listStrips, physics::listVibrations,
        physics::listShells, physics::listMeasured, physics::listSolids, physics::listContacts})
    for (const physics::Problem& problem : list())
      if (problem.name.compare(0, options.scene.size(), options.scene) == 0) problems.push_back(problem);

  std::vector<std::vector<std::string>> series;
  report.begin("physics", "7. Physics: errors against closed forms and published tables",
               {"case", "membrane", "bending", "sampling", "rotated", "points", "spacing_m_or_step_s", "value", "reference",
                "error", "s", "what", "error_is_a_share_of", "source", "failure"});
  for (const physics::Problem& problem : problems)
    for (const physics::Variant& variant : problem.variants) {
      std::vector<physics::Answer> answers;
      for (std::size_t k = 0; k < problem.sizes.size() && (options.large || k < kQuickSizes); ++k) {
        const physics::Answer a = physics::solve(problem, variant, problem.sizes[k]);
        answers.push_back(a);
        report.add({problem.name, nameMembrane(problem, variant), nameBending(problem, variant), physics::nameSampling(variant),
                    variant.rotated ? "yes" : "no", std::to_string(a.points), show(a.size), show(a.value), show(a.reference),
                    show(a.error), show(a.seconds), problem.value, problem.scale, problem.source, a.failure});
      }
      series.push_back({problem.name, nameMembrane(problem, variant), nameBending(problem, variant),
                        physics::nameSampling(variant), show(answers.front().size) + " .. " + show(answers.back().size),
                        std::to_string(answers.front().points) + " .. " + std::to_string(answers.back().points),
                        showPercent(answers.front().error) + " .. " + showPercent(answers.back().error),
                        showOrder(problem, answers), problem.source});
    }
  report.end();
  report.begin("physics_orders", "   The same by series: coarsest .. finest, order by least squares in log(error) over log(size)",
               {"case", "membrane", "bending", "sampling", "spacing_m_or_step_s", "points", "error_%", "order", "source"});
  for (const auto& row : series) report.add(row);
  report.end();
  report.note(
      "membrane: co-rotated triangles with the scene's Poisson's ratio, or springs, whose is 1/3; regular samplings are aligned");
  report.note("with the axes, all others are turned in space; the spread of an order is its standard error over the sizes shown");
  if (!physics::hasScan())
    report.note("no scanned samplings: DEFORMABLE_SURFACE_DATA names no folder with pcl_scans/sac_plane_test.pcd");
}

}  // namespace deformable_surface::benchmark
