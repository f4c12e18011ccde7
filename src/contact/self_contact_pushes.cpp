// The forces that push crossed parts apart: see untangling.h.
#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::contact {
namespace {

constexpr double kPushTime = 0.05;  // s: crossed parts that nothing else moves pass each other by an edge in this time

}  // namespace

bool SelfContact::beginPushing(const Points& positions) {
  pushes_ = findPushes(list_, positions, masses_);
  return !pushes_.empty();
}

double SelfContact::dampingOf(const Push& push) const {
  double least = masses_[push.vertices[0]];
  for (const Index v : push.vertices) least = std::min(least, masses_[v]);
  return 2.0 * least * params_.rate;
}

double SelfContact::forceOf(const Push& push) const { return dampingOf(push) * list_.medianEdge() / kPushTime; }

void SelfContact::addPushes(const Points& velocities, Points& forces) const {
  for (const Push& push : pushes_) {
    double speed = 0.0;
    for (int v = 0; v < 5; ++v) speed += push.weight[v] * push.direction.dot(velocities[push.vertices[v]]);
    const Vec3 force = (forceOf(push) - dampingOf(push) * speed) * push.direction;
    for (int v = 0; v < 5; ++v) forces[push.vertices[v]] += push.weight[v] * force;
  }
}

double SelfContact::workOfPushes(const Points& before, const Points& after) const {
  double work = 0.0;
  for (const Push& push : pushes_)
    for (int v = 0; v < 5; ++v) {
      const Index i = push.vertices[v];
      work += forceOf(push) * push.weight[v] * push.direction.dot(after[i] - before[i]);
    }
  return work;
}

void SelfContact::addPushStiffness(double step, BlockSparse& stiffness_matrix) const {
  if (!(step > 0.0)) return;
  for (const Push& push : pushes_) {
    const Mat3 block = dampingOf(push) / step * push.direction * push.direction.transpose();
    for (int v = 0; v < 5; ++v)
      for (int w = 0; w <= v; ++w)
        stiffness_matrix.add(push.vertices[v], push.vertices[w], push.weight[v] * push.weight[w] * block);
  }
}

void SelfContact::addPushRowBounds(std::vector<double>& damping) const {
  // The absolute weights sum to two.
  for (const Push& push : pushes_)
    for (int v = 0; v < 5; ++v) damping[push.vertices[v]] += 2.0 * std::abs(push.weight[v]) * dampingOf(push);
}

}  // namespace deformable_surface::contact
