#include "problem.h"

#include "deformable_surface/base/timer.h"
#include "samplings.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace deformable_surface::physics {

std::string nameMembrane(const Variant& variant) {
  return variant.membrane == model::Membrane::kSprings ? "springs" : "triangles";
}

std::string nameBending(const Variant& variant) {
  switch (variant.bending) {
    case model::Bending::kSprings: return "springs";
    case model::Bending::kCurvature: return "curvature";
    case model::Bending::kNone: break;
  }
  return "none";
}

std::string nameSampling(const Variant& variant) {
  switch (variant.sampling) {
    case Sampling::kRegular: return "regular";
    case Sampling::kJittered: return "jittered";
    case Sampling::kScanned: break;
  }
  return "scanned";
}

std::vector<Variant> listSamplings(model::Membrane membrane, model::Bending bending) {
  std::vector<Variant> list{{membrane, bending, Sampling::kRegular, false}, {membrane, bending, Sampling::kJittered, true}};
  if (hasScan()) list.push_back({membrane, bending, Sampling::kScanned, true});
  return list;
}

std::vector<Variant> listMost(model::Bending bending) {
  std::vector<Variant> list = listSamplings(model::Membrane::kTriangles, bending);
  list.push_back({model::Membrane::kSprings, bending, Sampling::kJittered, true});
  return list;
}

std::vector<Variant> listAll(model::Bending bending) {
  std::vector<Variant> list = listSamplings(model::Membrane::kTriangles, bending);
  for (const Variant& variant : listSamplings(model::Membrane::kSprings, bending)) list.push_back(variant);
  return list;
}

Answer solve(const Problem& problem, const Variant& variant, double size) {
  const Timer timer;
  Answer answer;
  try {
    answer = problem.run(variant, size);
  } catch (const std::runtime_error& failure) {
    answer.failure = failure.what();
    answer.value = answer.reference = answer.error = std::numeric_limits<double>::quiet_NaN();
  }
  answer.size = size;
  answer.seconds = timer.seconds();
  return answer;
}

Order fitOrder(const std::vector<Answer>& answers) {
  const double n = static_cast<double>(answers.size());
  double mean_x = 0.0, mean_y = 0.0;
  for (const Answer& a : answers) {
    mean_x += std::log(a.size) / n;
    mean_y += std::log(a.error) / n;
  }
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (const Answer& a : answers) {
    const double x = std::log(a.size) - mean_x, y = std::log(a.error) - mean_y;
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  Order order;
  order.value = xy / xx;
  order.spread = std::numeric_limits<double>::quiet_NaN();
  if (n > 2.0) order.spread = std::sqrt(std::max(0.0, yy - xy * xy / xx) / (n - 2.0) / xx);
  return order;
}

Problem findProblem(const std::vector<Problem>& problems, const std::string& name) {
  for (const Problem& problem : problems)
    if (problem.name == name) return problem;
  throw std::logic_error("no problem is called " + name);
}

}  // namespace deformable_surface::physics
