#include "unconstrained_parts.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/simulation/contact_load.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>

#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kMostSizes = 5;  // that a sentence lists

// "12, 5 and 3", the largest first; "12, 5, 3, 2, 2 and fewer" if there are more.
std::string listSizes(std::vector<Index> sizes) {
  std::sort(sizes.begin(), sizes.end(), std::greater<Index>());
  const Index listed = std::min(kMostSizes, static_cast<Index>(sizes.size()));
  const bool has_more = listed < static_cast<Index>(sizes.size());
  std::string text;
  for (Index k = 0; k < listed; ++k) {
    if (k > 0) text += k + 1 == listed && !has_more ? " and " : ", ";
    text += std::to_string(sizes[k]);
  }
  return text + (has_more ? " and fewer" : "");
}

// Number of dense points that belong to marked simulation points.
Index countDense(const RestSurface& s, const std::vector<char>& marked) {
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> near;
  Index found = 0;
  for (std::size_t i = 0; i < s.dense.positions.size(); ++i) {
    Index owner = s.cells.owner.empty() ? -1 : s.cells.owner[i];
    if (owner < 0) {
      tree.nearest(s.dense.positions[i], 1, near);
      owner = near.front().index;
    }
    found += marked[owner];
  }
  return found;
}

// For a surface without a model yet: parts by the edges that will be its springs.
Parts findSimulatedParts(const SceneParams& params, const RestSurface& s) {
  const Index n = static_cast<Index>(s.points.size());
  if (!s.model) return findParts(n, linksOf(s.rings.ring));
  if (s.model->partition() && std::isfinite(s.model->partition()->maxPartMotion()))
    return findParts(n, findModel(params.model).linkPartners(*s.model, s.points));
  return findParts(n, stretchLinksOf(*s.model));
}

// points: the name of the marked points.
void requireHeld(const SceneParams& params, const std::vector<char>& held, const char* points) {
  if (std::find(held.begin(), held.end(), 1) != held.end()) return;
  throw InputError(std::string("input.unconstrained_parts: found ") +
                   (params.input.unconstrained_parts == UnconstrainedParts::kDrop ? "drop" : "freeze") +
                   ", but no pin, anchor or tool holds any of the " + formatCount(static_cast<Index>(held.size()), points) +
                   " at the beginning; accepted: keep, or something that holds one of them");
}

struct HeldParts {
  std::vector<char> marked;    // points (n, 1) in parts that are held
  std::vector<Index> by_tool;  // parts that each tool of the scene holds without gripping them, where no pin, anchor or hand does
};

HeldParts findHeldParts(const SceneParams& params, const Parts& parts, const Points& points) {
  const Index n = static_cast<Index>(points.size());
  std::vector<char> is_held(parts.count(), 0);
  for (const PinParams& pin : params.pins)
    for (Index i = 0; i < n; ++i)
      if (pin.region.contains(points[i])) is_held[parts.label[i]] = 1;
  const cloud::KdTree tree(points);
  std::vector<cloud::Neighbor> near;
  for (const AnchorParams& anchor : params.anchors) {
    tree.nearest(anchor.point, 1, near);
    is_held[parts.label[near.front().index]] = 1;
  }
  for (const tool::ToolParams& tool : params.tools) {
    if (tool.mode != tool::Mode::kMove || !tool::isActive(tool, 0.0)) continue;
    const tool::Pose pose = tool::interpolate(tool.path, 0.0);
    for (Index i = 0; i < n; ++i)
      if (tool::findSignedDistance(tool.shape, pose, points[i], 0.0).distance <= 0.0) is_held[parts.label[i]] = 1;
  }
  HeldParts held;
  held.by_tool.assign(params.tools.size(), 0);
  const std::vector<double> masses;  // which are not asked for
  const Vec3 down = params.gravity.isZero(0.0) ? Vec3::Zero() : params.gravity.normalized();
  for (std::size_t t = 0; t < params.tools.size(); ++t) {
    if (params.tools[t].mode == tool::Mode::kCut) continue;  // a knife holds nothing
    ContactLoad contact(masses);
    contact.setTools({params.tools[t]});
    for (Index i = 0; i < n && !contact.isEmpty(); ++i) {
      if (is_held[parts.label[i]] || !contact.mayHold(points[i], down, 0.0)) continue;
      is_held[parts.label[i]] = 1;
      ++held.by_tool[t];
    }
  }
  for (const Index label : parts.label) held.marked.push_back(is_held[label]);
  return held;
}

// A floor holds what lies above it: such parts are not among those that are dropped or frozen.
void noteHeldByTools(const SceneParams& params, const Parts& parts, const HeldParts& held, RestSurface& s) {
  if (parts.count() < 2) return;
  for (std::size_t t = 0; t < params.tools.size(); ++t)
    if (held.by_tool[t] > 0)
      s.notes.push_back(std::string("input.unconstrained_parts ") +
                        (params.input.unconstrained_parts == UnconstrainedParts::kDrop ? "drop" : "freeze") + ": " +
                        formatCount(held.by_tool[t], "of ") + formatCount(parts.count(), "parts count as held by tool ") +
                        quote(params.tools[t].id) + ", which they touch, fall onto or are in reach of");
}

}  // namespace

std::vector<char> markHeldParts(const SceneParams& params, const Parts& parts, const Points& points) {
  return findHeldParts(params, parts, points).marked;
}

void dropUnconstrained(const SceneParams& params, const Parts& parts, RestSurface& s) {
  const HeldParts held = findHeldParts(params, parts, s.dense.positions);
  requireHeld(params, held.marked, "points of the cloud");
  noteHeldByTools(params, parts, held, s);
  leaveOut("input.unconstrained_parts drop", parts, held.marked, s);
}

void freezeUnconstrained(const SceneParams& params, RestSurface& s) {
  const Parts parts = findSimulatedParts(params, s);
  const HeldParts held = findHeldParts(params, parts, s.points);
  requireHeld(params, held.marked, "simulation points");
  noteHeldByTools(params, parts, held, s);
  for (std::size_t i = 0; i < held.marked.size(); ++i)
    if (!held.marked[i]) s.pinned[i] = s.pinned_turns[i] = kInPin;
}

void noteUnconstrained(const SceneParams& params, RestSurface& s) {
  const Parts parts = findSimulatedParts(params, s);
  const std::vector<char> held = markHeldParts(params, parts, s.points);
  std::vector<char> is_loose, is_held(parts.count(), 0);
  for (std::size_t i = 0; i < held.size(); ++i) {
    is_loose.push_back(!held[i]);
    is_held[parts.label[i]] = held[i];
  }
  std::vector<Index> sizes;
  for (Index p = 0; p < parts.count(); ++p)
    if (!is_held[p]) sizes.push_back(parts.size[p]);
  const Index loose = static_cast<Index>(sizes.size());
  if (loose == 0) return;
  // Samples are no parts of a surface yet: one that is grown through them joins them.
  const bool will_grow = findModel(params.model).traits().is_oriented && params.oriented_particles.grow_surface;
  if (will_grow) sizes.clear();
  if (will_grow && loose < parts.count()) return;
  if (loose == parts.count()) {
    const std::string all = loose == 1 || will_grow
                                ? ""
                                : ", " + formatCount(loose, "parts of ") + listSizes(std::move(sizes)) + " simulation points";
    s.notes.push_back("no pin, anchor or tool holds what is simulated" + all + ": it moves freely");
    return;
  }
  const std::string which = "no pin, anchor or tool holds " + formatCount(loose, "of ") +
                            formatCount(parts.count(), "parts of what is simulated, with ") + listSizes(std::move(sizes)) +
                            " simulation points (" + formatCount(countDense(s, is_loose), "points of the cloud): ");
  if (params.input.unconstrained_parts == UnconstrainedParts::kFreeze)
    s.notes.push_back(which + "input.unconstrained_parts freeze keeps them where they are");
  else
    s.warnings.push_back(
        which +
        "they move freely; input.unconstrained_parts freezes or drops such parts, input.largest_parts leaves small ones out");
}

void noteStaticContact(const SceneParams& params, RestSurface& s) {
  if (params.integrator.type != solve::IntegratorType::kStatic || !params.contact.self.valueOr(false)) return;
  const Parts parts = findSimulatedParts(params, s);
  if (parts.count() < 2) return;
  SceneParams fixed = params;  // without what only touches
  const auto touches = [](const tool::ToolParams& tool) { return tool.mode != tool::Mode::kMove; };
  fixed.tools.erase(std::remove_if(fixed.tools.begin(), fixed.tools.end(), touches), fixed.tools.end());
  const std::vector<char> held = markHeldParts(fixed, parts, s.points);
  std::vector<char> is_free(parts.count(), 0);
  for (std::size_t i = 0; i < held.size(); ++i) is_free[parts.label[i]] = !held[i];
  const Index free = static_cast<Index>(std::count(is_free.begin(), is_free.end(), char{1}));
  if (free == 0) return;
  s.notes.push_back("no pin, anchor or gripping tool holds " + formatCount(free, "of ") +
                    formatCount(parts.count(),
                                "parts, which can only rest on others or on tools: equilibria have no friction, so that "
                                "these parts may slide without end, and a search can take hundreds of slow iterations; "
                                "integrator.type auto with material.damping lets them come to rest"));
}

}  // namespace deformable_surface::simulation
