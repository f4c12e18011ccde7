// Contact with tools that push or pull by where a point is: solid ones (and knives, which are solid) and attracting ones, as a
// load on the simulation points. Solid tools touch points of the cloud between these, too.
#pragma once

#include "deformable_surface/simulation/contact_points.h"
#include "deformable_surface/solve/external_load.h"
#include "deformable_surface/tool/crossing.h"
#include "deformable_surface/tool/tool.h"

#include <memory>
#include <optional>
#include <utility>

namespace deformable_surface::simulation {

/// Points inside a solid tool are pushed out along its normal by F = m r^2 d, d the depth: a penalty with the potential
/// m r^2 d^2 / 2. Being in proportion to mass, it adds at most r^2 to the square of the highest frequency, wherever it acts; and
/// at rest a point is as deep as its share of the load over m r^2. Points of the cloud between the simulation points
/// (setBetween()) are pushed in the same way, and push those that they follow. A plane, or a ball so large that the surface
/// between simulation points does not get into it, touches these alone. A point that a solid tool passes over within a step, so
/// that its shortest way out would be another than the one it came in by, is pushed back along the latter, with d the depth below
/// the plane there, until it is out or beside the tool.
///
/// A tool that appears where points already are comes to its place from the nearest one in which it touches none, straight and
/// evenly within kArrival. Otherwise r d, some hundred metres a second, would be the speed at which they leave, each to its side.
///
/// An attracting tool draws the points within its reach R on either side to its surface: F = -k s d (1 - (d / R)^2)^2 n at the
/// distance d, s the point's share of the mass of all; potential -k s R^2 (1 - (d / R)^2)^3 / 6.
class ContactLoad : public solve::ExternalLoad {
 public:
  static constexpr double kArrival = 0.1;  // s, or a step where that is longer; as long as a tool takes that is put elsewhere

  explicit ContactLoad(const std::vector<double>& masses) : points_(masses) {}

  /// Which points touch tools.
  const ContactPoints& points() const { return points_; }
  void setBetween(std::shared_ptr<const transfer::SampledPoints> between) {
    points_.setBetween(std::move(between));
    forgetTouches();
  }
  void setSevered(std::vector<char> is_severed) {
    points_.setSevered(std::move(is_severed));
    forgetTouches();
  }

  /// Tools of other modes are left alone. Those that are there by their id keep what they have passed over, and how they arrive
  /// unless they have another shape.
  void setTools(const std::vector<tool::ToolParams>& tools);
  bool isEmpty() const { return bodies_.empty(); }

  /// A point that a tool has passed over, by the way it came in.
  struct Passed {
    Index point;
    tool::Entry entry;
  };
  /// How a tool that appears comes to its place.
  struct Arrival {
    bool is_known = false;            // it acts, or has acted
    Vec3 offset = Vec3::Zero();       // m, from its place to where it comes from; zero: it is there at once
    double begins = 0.0, ends = 0.0;  // s
  };
  /// A tool, its path as it arrives, with the points that it has passed over, ascending. What a snapshot must hold.
  struct Body {
    tool::ToolParams tool;
    std::vector<Passed> passed;
    Arrival arrival;
    std::optional<bool> acts;  // in the whole of the step that was begun; none: before the first
  };
  const std::vector<Body>& all() const { return bodies_; }
  void restore(const std::vector<Body>& bodies) {
    bodies_ = bodies;
    forgetTouches();
  }
  /// Before a step: which tools act in it; which points solid ones will pass over in it if they go on as they do, and which are
  /// free again; and from where tools that appear arrive. held: those that cannot be pushed. Returns whether any of this has
  /// changed anything.
  bool beginStep(double time, double step, const model::State& state, const std::vector<char>& held);
  /// What a user should know of the last beginStep().
  const std::string& news() const { return news_; }
  /// Whether the last beginStep() has found out how a tool arrives.
  bool hasNewArrival() const { return has_new_arrival_; }
  /// The same, of one that begins beside its place.
  bool hasNewDetour() const { return has_new_detour_; }
  /// Tools that have not acted yet arrive as those of the same id do there: a copy with fewer points would find other ways.
  void adoptArrivals(const ContactLoad& other);
  /// After it: which points they did pass over though it was not foreseen. Returns what a user should know of the step.
  std::string endStep(double time, double step, const model::State& state, const std::vector<char>& held,
                      const std::vector<model::WeightedTriangle>& triangles);
  /// Whether tools that appear in the surface arrive, or, for equilibria, are there at once. Default: they arrive.
  void setArriving(bool arrives) { arrives_ = arrives; }
  /// Whether a tool that acts then may hold a point against a force along direction (unit): it is in the way of the point, or
  /// attracts it.
  bool mayHold(const Vec3& point, const Vec3& direction, double time) const;
  /// Forgets what was passed over. The tools are to be set anew.
  void reset();
  /// Simulation points have got other indices: new_index (of those before), -1 = gone.
  void renumber(const std::vector<Index>& new_index);
  /// Becomes the contact of fewer points: new_index (of the simulation points there), -1 = left out.
  void takePart(const ContactLoad& whole, const std::vector<Index>& new_index);

  /// r, 1/s. Set once the stable step at rest is known.
  void setRate(double rate) {
    rate_ = rate;
    forgetTouches();
  }
  double rate() const { return rate_; }

  void addForces(double time, const model::State& state, Points& forces) const override;
  double potential(double time, const model::State& state) const override;
  bool isConservative() const override { return true; }
  double storedEnergy(double time, const model::State& state) const override;
  /// What tools in motion do: the potential's gain at the points before and at those after, whichever is more.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;

  /// A point that a tool acts on.
  struct Touch {
    Index point;      // its number
    Vec3 position;    // m
    double distance;  // m, from the tool's surface; negative inside
    Vec3 normal;      // outward
    Vec3 force;       // N, on the point, along the normal
  };
  /// Of the body in that place, for every point that it acts on, ascending; until the next call with another time or other
  /// positions. Found once for all who ask.
  const std::vector<Touch>& findTouches(std::size_t body, double time, const Points& positions) const;

  /// s of wall time that contact and friction have taken since the last call, but for energies and stiffness.
  double takeSeconds() const { return std::exchange(seconds_, 0.0); }
  void addSeconds(double seconds) const { seconds_ += seconds; }

 private:
  void listTouchesBetween(const tool::ToolParams& tool, const tool::Pose& pose, const Points& positions,
                          std::vector<Touch>& touches) const;
  void findArrival(double time, double step, const model::State& state, const std::vector<char>& held, Body& body);
  double potentialOf(std::size_t body, double time, const Points& positions) const;
  // Their memory is kept.
  void forgetTouches() {
    for (Touches& touches : touches_) touches.are_known = false;
  }
  void listTouches(const Body& body, double time, const Points& positions, std::vector<Touch>& touches) const;
  double totalMass() const;

  ContactPoints points_;
  std::vector<Body> bodies_;  // solid, cut and attract
  double rate_ = 0.0;
  bool arrives_ = true, has_new_arrival_ = false, has_new_detour_ = false;
  std::string news_;
  mutable double seconds_ = 0.0;
  Points before_;  // m, of the last beginStep()
  // Scratch of listTouches().
  struct NearCell {
    Index cell;
    double distance, reach;  // m, of its simulation point from the tool, and of its points from that
  };
  mutable std::vector<NearCell> near_;
  // What findTouches() has found.
  struct Touches {
    bool are_known = false;
    std::vector<Touch> list;
  };
  mutable double touched_time_ = 0.0;     // s, at which
  mutable Points touched_at_;             // m, and where
  mutable std::vector<Touches> touches_;  // by body; empty: nothing yet
  std::vector<Passed> scratch_;
  std::vector<std::string> told_;  // ids of tools whose passing between points was told
};

}  // namespace deformable_surface::simulation
