// Whether a moving surface stays clear of itself, as far as that is cheap to prove.
#pragma once

#include "deformable_surface/contact/atlas.h"
#include "deformable_surface/contact/clear_motion.h"
#include "deformable_surface/contact/cover.h"
#include "deformable_surface/contact/quick_look.h"

#include <memory>
#include <optional>
#include <vector>

namespace deformable_surface::contact {

/// The points' motion is predicted. A proof holds as long as all remain within a tolerance of it, for one step or for many. This
/// is cheap to check. Where the whole surface has no proof (see Chart), parts of it may have one.
class Clearance {
 public:
  /// For primitives that are to stay farther apart than distance (m). rest: (n) m. patches: of the same surface, kept by
  /// reference; null: no parts.
  Clearance(Points rest, const std::vector<Triangle>& triangles, double distance, const Patches* patches = nullptr);

  double distance() const { return distance_; }  // m

  /// From now on a quick look takes the place of the proof of the whole, for surfaces that have none: see QuickLook. patches: as
  /// in the constructor; slack: m, motion of any two points against each other until it is taken again; is_body: see there.
  void lookInstead(const Patches& patches, double slack, bool is_body);
  /// Whether it does, after lookInstead(). Forgets what is proven.
  void setLooks(bool looks);
  bool looks() const { return looks_; }
  /// See QuickLook; after lookInstead().
  const Vec3& placeSeen() const { return look_->placeSeen(); }
  /// Whether the whole may have a proof: false for closed surfaces.
  bool hasOutline() const { return !whole_.isEmpty(); }
  /// Tries the proof for points that keep their velocities (n) for a time; m and s, or any other unit of time. A look in its
  /// place knows nothing of velocities.
  bool prove(const Points& positions, const Points& velocities, double time);
  void forget() { proven_.reset(); }
  /// Whether all primitives are farther apart than the distance throughout the motion of the last prove().
  bool isApart() const { return proven_ && proven_->apart_tolerance > 0.0; }
  /// The same at these positions.
  bool isApartAt(const Points& positions) const { return isApart() && proven_->isNear(positions, proven_->apart_tolerance); }
  /// The same from these positions on, for points that keep their velocities for a time.
  bool staysApart(const Points& positions, const Points& velocities, double time) const {
    return isApart() && proven_->isNear(positions, velocities, time, proven_->apart_tolerance);
  }
  /// Whether nothing crosses anything on straight paths from `before` to `after`. knows_before: it was so on paths to `before`.
  bool staysUncrossed(const Points& before, const Points& after, bool knows_before = false) const {
    return proven_ && (knows_before || proven_->isNear(before, proven_->tolerance)) && proven_->isNear(after, proven_->tolerance);
  }
  /// What is proven; null: nothing. It remains true, whatever has happened since.
  std::shared_ptr<const ClearMotion> proven() const { return proven_; }
  void setProven(std::shared_ptr<const ClearMotion> proven) { proven_ = std::move(proven); }

  /// Tries to prove for parts of the surface that they stay farther apart than the distance, apart from the proof of the whole.
  /// Returns whether anything is proven.
  bool proveParts(const Points& positions, const Points& velocities, double time);
  void forgetParts() { parts_.motion.apart_tolerance = -1.0; }
  /// Tries all parts again: those without a proof are left out since the last call, and parts of them tried.
  void tryAllParts() { has_failed_.clear(); }
  /// What is farther apart than the distance; null: nothing is proven.
  const Cover* partsApart(const Points& positions) const;

 private:
  std::shared_ptr<ClearMotion> takeSpare();
  void makeSpares();
  bool look(const Points& positions);

  const Points rest_;
  const std::vector<Triangle> triangles_;
  const double distance_;
  const Patches* const patches_;
  const Chart whole_;
  Chart::Scratch scratch_;
  std::optional<QuickLook> look_;
  bool looks_ = false;
  double slack_ = 0.0;  // m, of the look
  std::shared_ptr<const ClearMotion> proven_;
  std::vector<std::shared_ptr<ClearMotion>> spares_;  // all made here: those that nobody else holds are used again

  struct {
    ClearMotion motion;
    Cover apart;
  } parts_;
  std::vector<char> has_failed_;  // by chart
  std::optional<Atlas> atlas_;    // made when it is first needed
};

}  // namespace deformable_surface::contact
