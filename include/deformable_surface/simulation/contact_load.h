// Contact with tools whose force depends on a point's position: solid tools, knives (which are solid) and attracting tools, as a
// load on the simulation points. Solid tools also touch points of the cloud between simulation points.
#pragma once

#include "deformable_surface/contact/pad.h"
#include "deformable_surface/geometry/point_boxes.h"
#include "deformable_surface/simulation/contact_points.h"
#include "deformable_surface/solve/external_load.h"
#include "deformable_surface/tool/crossing.h"
#include "deformable_surface/tool/tool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

namespace deformable_surface::simulation {

/// Points inside a solid tool are pushed out along its normal by F = m r^2 d, d the depth: a penalty with the potential m r^2 d^2
/// / 2. As it is proportional to mass, it adds at most r^2 to the square of the highest frequency. At rest, the depth of a point
/// would be its share of the load over m r^2. Points of the cloud between the simulation points (setBetween()) are pushed in the
/// same way, and pass the force on to the simulation points that they follow. A plane, or a ball so large that it cannot enter
/// the surface between simulation points, touches only simulation points. So does a box far from its edges: nearer, the other
/// points of a cell touch with a share that grows from 0 to 1, and the potential with it.
///
/// A solid tool may pass over a point within a step, so that the point's shortest way out is no longer the way it came in. Such a
/// point is pushed back along the latter, with d the depth below the plane there, until it is outside or beside the tool. The
/// plane first withdraws so far that the force does not grow, and comes back (Withdrawal).
///
/// Points between that are deeper than the other touching points of their cell are chosen before each step, one in a cell, to
/// have springs of their own: as stiff as the stable step allows for one point (ContactPoints::ownMassOf()). Corners, edges and
/// small tools press on such points. Spare points touch only once they are chosen. The tool's surface first withdraws from a
/// chosen point, so that its force does not jump, and comes back (Withdrawal). The choice ends when the point is outside.
///
/// Places on triangles (SampledPoints::isPlace()) are chosen if they will be deeper at the end of the step, where the surface is
/// stretched or the tool is small. They have the spring of their cell's simulation point, and the tool's surface does not come
/// back to them by itself. Otherwise sheets that slide over edges would gain energy.
///
/// In equilibria the depth is not left: it would make the tool softer than it is. Where points press on a solid tool, its surface
/// grows by s towards them until they lie on the tool itself, and F = m r^2 (d + s) (setGrowing()). In motion nothing grows:
/// points that carry s along, as those of a rolling ball do, would drive the motion. Points that cannot be pushed, and those that
/// a tool has passed over, have none.
///
/// A tool that appears where points already are moves to its place from the nearest one in which it touches none, straight and at
/// constant speed within kArrival. Otherwise the points would leave at the speed r d, some hundred metres a second, in different
/// directions.
///
/// A pad (setCompliance()) makes springs as soft as itself: see contact::findPadStiffness(). The area of a cell is shared by the
/// points that may touch in it. There, spare points touch only if no other point of their cell does, and none is stiffer than its
/// share. In equilibria the tool's surface then grows to where the depth is that of the pad.
///
/// An attracting tool pulls the points within its reach R on either side to its surface: F = -k s d (1 - (d / R)^2)^2 n at the
/// distance d, s the point's share of the total mass; potential -k s R^2 (1 - (d / R)^2)^3 / 6.
class ContactLoad : public solve::ExternalLoad {
 public:
  static constexpr double kArrival = 0.1;  // s, or a step if that is longer; equal to the time in which a tool is moved elsewhere

  explicit ContactLoad(const std::vector<double>& masses) : points_(masses) {}

  /// The points that can touch tools.
  const ContactPoints& points() const { return points_; }
  void setBetween(std::shared_ptr<const transfer::SampledPoints> between) {
    points_.setBetween(std::move(between));
    forgetTouches();
  }
  void followMasses() {
    points_.followMasses();
    forgetTouches();
  }
  void setSevered(std::vector<char> is_severed) {
    points_.setSevered(std::move(is_severed));
    forgetTouches();
  }

  /// Tools of other modes are ignored. A tool with a known id keeps its passed points. It also keeps its arrival, unless its
  /// shape has changed.
  void setTools(const std::vector<tool::ToolParams>& tools);
  bool isEmpty() const { return bodies_.empty(); }

  /// By how much a tool's surface has withdrawn from a point. A jump back would store energy in the spring. The surface comes
  /// back with a point that moves outward, which takes no work, and by as much as the tool moves. Else it comes back so slowly
  /// that a point that comes again and again gains little: the work is the point's load times the way.
  struct Withdrawal {
    static constexpr double kEase = 0.5;          // s, in which it falls to 1 / e
    double way = 0.0, begins = 0.0, speed = 0.0;  // m, s; m/s, of the tool
    double ease = kEase;                          // s; infinite: the tool's surface does not come back by itself

    double at(double time) const {
      return way > 0.0 ? std::max(0.0, way * std::exp((begins - time) / ease) - (time - begins) * speed) : 0.0;
    }
    /// How fast it falls, m/s.
    double rateAt(double time) const { return at(time) > 0.0 ? way / ease * std::exp((begins - time) / ease) + speed : 0.0; }
    /// The same from a time on, with a point at a depth (m) that it follows, and the speed of the tool there (m/s).
    Withdrawal goOn(double time, double depth, double tool_speed) const {
      const double now = at(time);
      if (!(depth < now) && tool_speed == speed) return *this;
      return {std::clamp(depth, 0.0, now), time, tool_speed, ease};
    }
  };
  /// A point that a tool has passed over, with its entry.
  struct Passed {
    Index point;
    tool::Entry entry;
    Withdrawal withdrawal{};
  };
  /// Of a tool in a step.
  struct Moment {
    double share;  // of the step, before it
    tool::Pose pose;
  };
  /// How a tool that appears reaches its place.
  struct Arrival {
    bool is_known = false;            // it acts, or has acted
    Vec3 offset = Vec3::Zero();       // m, from its place to the start of the arrival; zero: no arrival
    double begins = 0.0, ends = 0.0;  // s
  };
  /// A point towards which the tool's surface has grown, or one with a spring of its own.
  struct Pressed {
    Index point;
    double growth;  // m, >= 0
    Withdrawal withdrawal{};

    double growthAt(double time) const { return growth - withdrawal.at(time); }
  };
  /// How often each of a tool's axis points has gone through an open surface and has not come back; against the normals negative.
  struct Through {
    std::array<int, 3> crossings{};
    double since = 0.0;  // s

    bool isAny() const { return crossings != std::array<int, 3>{}; }
  };
  /// A tool, its path with the arrival, and the points that it has passed over and the pressed ones, ascending.
  /// Must be in a snapshot.
  struct Body {
    tool::ToolParams tool;
    std::vector<Passed> passed;
    Arrival arrival;
    std::optional<bool> acts;  // during the whole of the begun step; none: before the first
    std::vector<Pressed> pressed{};
    Through through{};
  };
  const std::vector<Body>& all() const { return bodies_; }
  /// Copies all(), with room for every point: a later copy to the same place allocates nothing, however many points are passed
  /// over.
  void copyAll(std::vector<Body>& bodies) const {
    bodies = bodies_;
    reserve(bodies);
  }
  void restore(const std::vector<Body>& bodies) {
    bodies_ = bodies;
    reserve(bodies_);
    gone_through_.clear();
    forgetTouches();
  }
  /// Before a step: determines which tools act in it, which points solid tools will pass over at present velocities, which passed
  /// points are free again, and from where appearing tools arrive. held: points that cannot be pushed. Returns whether any of
  /// this has changed anything.
  bool beginStep(double time, double step, const model::State& state, const std::vector<char>& held);
  /// Notice of the last beginStep() for the user.
  const std::string& notice() const { return notice_; }
  /// Whether the last beginStep() has determined an arrival.
  bool hasNewArrival() const { return has_new_arrival_; }
  /// Whether one of these arrivals begins beside the tool's place.
  bool hasNewDetour() const { return has_new_detour_; }
  /// Tools that have not acted yet take the arrivals of those with the same id in other: a copy with fewer points would find
  /// different ones.
  void adoptArrivals(const ContactLoad& other);
  struct Skin {
    const std::vector<model::WeightedTriangle>& triangles;  // of the surface, or around a body
    bool is_body;
    double spacing;  // m, of the points at rest
  };
  /// After a step: adds the points that were passed over although beginStep() did not predict it. Those of a tool that has gone
  /// through the surface are let go. Returns a notice for the user.
  std::string endStep(double time, double step, const model::State& state, const std::vector<char>& held, const Skin& skin);
  /// The id of a tool that has gone through the surface between the points in the last step; empty: none.
  const std::string& goneThrough() const { return gone_through_; }
  /// Whether tools that appear in the surface arrive. If not, as for equilibria, they are in place at once. Default: they arrive.
  void setArriving(bool arrives) { arrives_ = arrives; }
  /// Whether a tool that acts at that time may hold a point against a force along direction (unit): it blocks the point, or
  /// attracts it.
  bool mayHold(const Vec3& point, const Vec3& direction, double time) const;
  /// Forgets the passed points. The tools must be set again.
  void reset();
  /// The indices of simulation points have changed: new_index (of the former points), -1 = removed.
  void renumber(const std::vector<Index>& new_index);
  /// Whether settle() is used: else what has grown is forgotten in the next beginStep(). most: m, limit of the growth.
  void setGrowing(bool grows, double most) {
    grows_ = grows;
    most_growth_ = most;
  }
  /// For equilibria: grows by all of the depth at once. Returns whether a depth was more than a hundredth of the largest growth,
  /// so that the equilibrium must be searched again.
  bool settle(double time, const model::State& state, const std::vector<char>& held);
  /// Becomes the contact of a part of the points: new_index (of the simulation points of the whole), -1 = left out.
  void takePart(const ContactLoad& whole, const std::vector<Index>& new_index);

  /// r, 1/s. Set once the stable step at rest is known.
  void setRate(double rate) {
    rate_ = rate;
    forgetTouches();
  }
  double rate() const { return rate_; }
  /// Factor on r^2 of the penalty of simulation points. Default: 1.
  void setStiffening(double factor) {
    stiffening_ = factor;
    forgetTouches();
  }
  /// m/Pa, of a pad between the points and all tools that push; 0: none.
  void setCompliance(double compliance, ContactPoints::Areas areas) {
    compliance_ = compliance;
    points_.setAreas(std::move(areas));
    forgetTouches();
  }
  /// m/Pa, of the contact of all points of a cell together without a pad: the largest of all cells.
  double ownCompliance() const;

  void addForces(double time, const model::State& state, Points& forces) const override;
  double potential(double time, const model::State& state) const override;
  bool isConservative() const override { return true; }
  double drivingPower(double time, double step, const model::State& state) const override;
  double storedEnergy(double time, const model::State& state) const override;
  /// Work of moving tools: the gain of the potential at the points before or at those after, whichever is larger.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  /// For simulation points that are near (listNear()); for other points only in contact.
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;
  /// visit(i) for the simulation points that carry a touch of a damped tool, or may do so, themselves or for points of their
  /// cells, before bounds are asked for again. Not all, because damping by tools that are far would shorten the stable step.
  template <typename Visit>
  void forEachNearDamped(double time, const model::State& state, const Visit& visit) const {
    if (!hasDamped()) return;
    const double fastest = findFastest(state);
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (!isDamped(bodies_[b].tool)) continue;
      listNear(b, time, ahead(), fastest, state);
      for (const Index i : near_points_) visit(i);
    }
  }
  /// Whether points may touch a damped tool within a time (s) at their present velocities.
  bool mayBeDamped(double time, double within, const model::State& state) const;
  /// Passed points that have come out over an edge are no longer pushed back. Otherwise a point that returned there would be as
  /// deep as it has gone outside.
  void remember(double time, double step, model::State& state) const override;

  /// A point that a tool acts on.
  struct Touch {
    Index point;       // number of the point
    Vec3 position;     // m
    double distance;   // m, from the tool's surface; negative inside
    Vec3 normal;       // outward
    Vec3 force;        // N, on the point, along the normal; near edges of boxes a little aside (findEdgeShare())
    double pressed;    // m, of the contact spring: depth and growth; 0 for tools that attract
    double stiffness;  // N/m, of the contact spring, or of attraction where it is stiffest
    double softness;   // of the contact spring, 0 to 1: its stiffness over that without a pad
    double returning;  // m/s, of the tool's surface towards the point, beside the tool's motion: see Withdrawal
  };
  /// The touches of each body, for every point that it acts on, ascending. Valid until the next call with another time or other
  /// positions. Computed once for all callers.
  const std::vector<std::vector<Touch>>& findTouches(double time, const model::State& state) const;

  /// Whether contact with this tool is damped. Springs stiffer than those of surfaces always are: points that leave a tool and
  /// return within few sub-steps would gain energy.
  bool isDamped(const tool::ToolParams& tool) const {
    return tool::hasFriction(tool) || (stiffening_ > 1.0 && tool::isPushing(tool));
  }
  bool hasDamped() const {
    return std::any_of(bodies_.begin(), bodies_.end(), [this](const Body& body) { return isDamped(body.tool); });
  }
  bool hasFriction() const {
    return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return tool::hasFriction(body.tool); });
  }
  /// visit(begin(tool), touch) for the touches of all tools with friction; begin is called once per tool that touches.
  template <typename Begin, typename Visit>
  void forEachRubbingTouch(double time, const model::State& state, const Begin& begin, const Visit& visit) const {
    forEachTouch(tool::hasFriction, time, state, begin, visit);
  }
  /// The same for all tools that are damped.
  template <typename Begin, typename Visit>
  void forEachDampedTouch(double time, const model::State& state, const Begin& begin, const Visit& visit) const {
    forEachTouch([this](const tool::ToolParams& tool) { return isDamped(tool); }, time, state, begin, visit);
  }

  /// Wall time (s) of contact and friction since the last call, without energies and stiffness.
  double takeSeconds() const { return std::exchange(seconds_, 0.0); }
  void addSeconds(double seconds) const { seconds_ += seconds; }

 private:
  static constexpr double kAhead = 30.0;  // time over 1 / rate, in which a portion of sub-steps passes (solve/time_march.cpp)
  void reserve(std::vector<Body>& bodies) const {
    for (Body& body : bodies) {
      body.passed.reserve(points_.numSimulated());
      body.pressed.reserve(points_.size());
    }
  }
  template <typename IsMeant, typename Begin, typename Visit>
  void forEachTouch(const IsMeant& isMeant, double time, const model::State& state, const Begin& begin,
                    const Visit& visit) const {
    const std::vector<std::vector<Touch>>& touches = findTouches(time, state);
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (touches[b].empty() || !isMeant(bodies_[b].tool)) continue;
      const auto body = begin(bodies_[b].tool);
      for (const Touch& touch : touches[b]) visit(body, touch);
    }
  }
  void listTouchesBetween(const Body& body, double time, const tool::Pose& pose, const Points& positions, double largest_growth,
                          std::vector<Touch>& touches) const;
  struct Choice {
    bool cloud, places;  // points of the cloud, places on triangles
  };
  void chooseAlone(const Body& body, double time, const Points& positions, const std::vector<char>& held,
                   const std::vector<Touch>& touches, Choice choice);
  bool updateAlone(double time, double step, const model::State& state, const std::vector<char>& held, std::size_t b);
  void predict(double step, const model::State& state);
  /// visit(i, its item of passed or null) for the points of the last beginStep() that a ball may hold, and the passed ones.
  template <class Visit>
  void visitNear(const Vec3& centre, double radius, const std::vector<Passed>& passed, const Visit& visit) const;
  /// Whether a point that came into a body by one face runs on below another that pushes the surface there. place: m, in the
  /// tool's frame; boxes: of the positions.
  bool runsBelow(std::size_t b, double time, const model::State& state, const geometry::PointBoxes& boxes,
                 const tool::Entry& entry, const Vec3& place);
  /// Whether points between share the area of a cell with its simulation point.
  bool isShared(const geometry::Solid& shape, Index cell) const;
  /// N/m, of the pad that a point presses on.
  double padOf(Index point, bool is_shared) const {
    return compliance_ > 0.0 ? contact::findPadStiffness(points_.areaOf(point, is_shared), compliance_)
                             : std::numeric_limits<double>::infinity();
  }
  /// N/m, of the pad at a point that presses on it: far from the edges of a flat face simulation points have the whole area.
  double padAt(const tool::ToolParams& tool, const tool::Pose& pose, Index point, const Points& positions) const;
  /// Whether the pad is softer than contact at a point that shares its cell.
  bool isPadded(Index point) const { return padOf(point, true) < rate_ * rate_ * points_.massOf(point); }
  double grow(double time, const model::State& state, const std::vector<char>& held, std::size_t b);
  void findArrival(double time, double step, const model::State& state, const std::vector<char>& held, Body& body);
  void forgetTouches() { are_touches_known_ = false; }
  /// Brings boxes_at_ up to date. Returns whether the positions are others than in the last call.
  bool boxPoints(const Points& positions) const;
  /// boxes: of the positions. to_choose: near_ also has the cells of which all points between are spare.
  void listTouches(std::size_t b, double time, const model::State& state, const geometry::PointBoxes& boxes, bool to_choose,
                   std::vector<Touch>& touches) const;
  double ahead() const { return rate_ > 0.0 ? kAhead / rate_ : 0.0; }
  /// m/s, of all points.
  static double findFastest(const model::State& state);
  /// Writes the simulation points that carry a touch of a tool, or may do so within a time (s), into near_points_, ascending.
  /// fastest: findFastest().
  void listNear(std::size_t body, double time, double within, double fastest, const model::State& state) const;
  double totalMass() const;

  ContactPoints points_;
  std::vector<Body> bodies_;  // solid, cut and attract
  double rate_ = 0.0, stiffening_ = 1.0, compliance_ = 0.0, most_growth_ = 0.0;
  bool grows_ = false, arrives_ = true, has_new_arrival_ = false, has_new_detour_ = false, has_let_go_ = false;
  std::string notice_;
  mutable double seconds_ = 0.0;
  Points before_;       // m, of the last beginStep()
  model::State ahead_;  // where its points would be at the end of the step at present velocities; no more of the state is set
  geometry::PointBoxes boxes_before_, boxes_ahead_;
  // Scratch of listTouches().
  struct NearCell {
    Index cell;
    double distance, reach;  // m, of its simulation point from the tool, and of its points from the simulation point
  };
  mutable std::vector<NearCell> near_;
  mutable std::vector<double> touched_;     // (m) of listNear(): above zero for points that carry a touch now
  mutable std::vector<Index> near_points_;  // of listNear()
  // Result of findTouches().
  mutable bool are_touches_known_ = false;
  mutable double touched_time_ = 0.0;      // s
  mutable Points touched_at_;              // m
  mutable geometry::PointBoxes boxes_at_;  // around touched_at_
  mutable std::vector<std::vector<Touch>> touches_;
  std::vector<Passed> scratch_;
  std::vector<Moment> moments_;  // scratch
  // Scratch of runsBelow(): where the tool pushes points, in its frame.
  bool are_faces_known_ = false;
  std::vector<tool::Entry> faces_;
  std::vector<Touch> pressing_;         // scratch
  std::vector<Pressed> grown_, spare_;  // scratch; spare_: newly chosen, with their depth in place of growth
  struct Deepest {
    Index point = -1;
    bool has_pressed = false;
    double depth = 0.0, next = 0.0;  // m, of the deepest touching point of a cell and of the next
  };
  std::vector<Deepest> deepest_;       // (m) scratch
  std::vector<std::string> reported_;  // ids of tools whose passing between points was reported
  std::string gone_through_;
};

}  // namespace deformable_surface::simulation
