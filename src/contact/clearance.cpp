#include "deformable_surface/contact/clearance.h"

#include "deformable_surface/contact/crossings.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::contact {
namespace {

// Of the median edge: less tolerance would be used up within a sub-step; within a few, in parts, which cost more.
constexpr double kLeastTolerance = 0.002, kLeastInParts = 0.005;
constexpr int kSpares = 4;  // motions held at once where no snapshots are: by the step, its beginning, its part

// A tolerance that holds for each coordinate.
double ofCoordinate(double tolerance) { return tolerance / std::sqrt(3.0); }

}  // namespace

Clearance::Clearance(Points rest, const std::vector<Triangle>& triangles, double distance, const Patches* patches)
    : rest_(std::move(rest)),
      triangles_(triangles),
      distance_(distance),
      patches_(patches),
      whole_(findOutlines(rest_, triangles_), distance) {
  if (!whole_.isEmpty()) makeSpares();
}

void Clearance::makeSpares() {
  for (int k = 0; k < kSpares; ++k) {
    spares_.push_back(std::make_shared<ClearMotion>());
    spares_.back()->from.reserve(rest_.size());
    spares_.back()->way.reserve(rest_.size());
  }
}

void Clearance::lookInstead(const Patches& patches, double slack, bool is_body) {
  look_.emplace(rest_, triangles_, listEdges(static_cast<Index>(rest_.size()), triangles_), patches, distance_ + slack, is_body);
  slack_ = slack;
  looks_ = true;
  if (spares_.empty()) makeSpares();
}

void Clearance::setLooks(bool looks) {
  looks_ = looks;
  forget();
}

// Where all is far, it is so until the points have moved against each other by the slack.
bool Clearance::look(const Points& positions) {
  if (look_->isAnyNear(positions)) return false;
  const std::shared_ptr<ClearMotion> motion = takeSpare();
  motion->rest(positions);
  motion->tolerance = motion->apart_tolerance = 0.5 * ofCoordinate(slack_);
  proven_ = motion;
  return true;
}

// Allocates only while more motions are held elsewhere than ever before, as in snapshots.
std::shared_ptr<ClearMotion> Clearance::takeSpare() {
  for (const std::shared_ptr<ClearMotion>& spare : spares_)
    if (spare.use_count() == 1) {
      std::atomic_thread_fence(std::memory_order_acquire);  // the last other holder may have been on another thread
      return spare;
    }
  return spares_.emplace_back(std::make_shared<ClearMotion>());
}

bool Clearance::prove(const Points& positions, const Points& velocities, double time) {
  forget();
  if (looks_) return look(positions);
  if (whole_.isEmpty()) return false;
  const std::shared_ptr<ClearMotion> motion = takeSpare();
  motion->predict(positions, velocities, time);
  const Chart::Room room = whole_.findRoom(positions, motion->way, scratch_);
  if (!(room.uncrossed > kLeastTolerance * whole_.edge())) return false;
  motion->tolerance = ofCoordinate(room.uncrossed);
  motion->apart_tolerance = room.apart > kLeastTolerance * whole_.edge() ? ofCoordinate(room.apart) : -1.0;
  proven_ = motion;
  // Undefined numbers, which comparisons pass over, are never near.
  if (!motion->isNear(positions, motion->tolerance)) forget();
  return proven_ != nullptr;
}

bool Clearance::proveParts(const Points& positions, const Points& velocities, double time) {
  forgetParts();
  if (!patches_) return false;
  if (!atlas_) atlas_.emplace(rest_, triangles_, *patches_, distance_);
  ClearMotion& motion = parts_.motion;
  motion.predict(positions, velocities, time);
  parts_.apart.clear(patches_->size());
  double apart = std::numeric_limits<double>::infinity();
  has_failed_.resize(atlas_->size(), 0);
  for (Index k = 0; k < atlas_->size();) {
    if (has_failed_[k] != 0) {
      ++k;
      continue;
    }
    const Chart& chart = atlas_->chart(k);
    const double room = chart.isEmpty() ? -1.0 : chart.findRoom(positions, motion.way, scratch_).apart;
    const bool is_apart = room > kLeastInParts * chart.edge();
    if (is_apart) {
      parts_.apart.add(atlas_->patchesIn(k), k);
      apart = std::min(apart, room);
    }
    has_failed_[k] = !is_apart;
    k = is_apart ? atlas_->behind(k) : k + 1;
  }
  parts_.apart.end();
  if (parts_.apart.isEmpty() || !motion.isNear(positions, ofCoordinate(apart))) return false;
  motion.apart_tolerance = ofCoordinate(apart);
  return true;
}

const Cover* Clearance::partsApart(const Points& positions) const {
  const ClearMotion& motion = parts_.motion;
  return motion.apart_tolerance > 0.0 && motion.isNear(positions, motion.apart_tolerance) ? &parts_.apart : nullptr;
}

}  // namespace deformable_surface::contact
