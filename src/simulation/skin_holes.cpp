#include "skin_holes.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "overlaps.h"
#include "triangles_beneath.h"

namespace deformable_surface::simulation {
namespace {

using contact::Triangle;

constexpr double kFlat = 0.1;           // height over longest edge of a triangle that is taken for a line
constexpr std::size_t kFewBoxes = 512;  // that are gone through one by one

// Finds which boxes are near a given one, while boxes are added.
class GrowingTree {
 public:
  explicit GrowingTree(std::vector<contact::Box> boxes) : tree_(boxes), boxes_(std::move(boxes)), in_tree_(boxes_.size()) {}
  void add(const contact::Box& box) {
    boxes_.push_back(box);
    if (boxes_.size() - in_tree_ < kFewBoxes) return;
    tree_ = contact::BoxTree(boxes_);
    in_tree_ = boxes_.size();
  }
  template <class Visit>
  void visitMeeting(const contact::Box& box, const Visit& visit) const {
    tree_.visitMeeting(box, visit);
    for (std::size_t k = in_tree_; k < boxes_.size(); ++k)
      if (boxes_[k].intersects(box)) visit(static_cast<Index>(k));
  }

 private:
  contact::BoxTree tree_;
  std::vector<contact::Box> boxes_;
  std::size_t in_tree_;
};

class Layer {
 public:
  Layer(const Points& rest, std::vector<Triangle> triangles)
      : rest_(rest), triangles_(std::move(triangles)), tree_(listBoxes(rest, triangles_)), is_used_(rest.size(), 0) {
    for (std::size_t t = 0; t < triangles_.size(); ++t) take(static_cast<Index>(t));
    std::vector<contact::Box> lone;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (is_used_[i] != 0) continue;
      lone.emplace_back(rest[i]);
      lone_.push_back(static_cast<Index>(i));
    }
    lone_tree_ = std::make_unique<contact::BoxTree>(lone);
  }

  bool hasEdge(Index from, Index to) const { return owner_.count({from, to}) > 0; }
  bool isBorder(Index from, Index to) const { return hasEdge(to, from) && !hasEdge(from, to); }  // of a triangle to be added
  /// Ends of the edges from or to v that triangles to be added would have.
  std::vector<Index> listBorder(Index v, bool from) const {
    std::vector<Index> ends;
    const auto known = around_.find(v);
    if (known == around_.end()) return ends;
    for (const Index w : known->second)
      if (from ? isBorder(v, w) : isBorder(w, v)) ends.push_back(w);
    return ends;
  }
  std::vector<std::pair<Index, Index>> listBorder() const {
    std::vector<std::pair<Index, Index>> edges;
    for (const auto& [edge, triangle] : owner_)
      if (!hasEdge(edge.second, edge.first)) edges.emplace_back(edge.second, edge.first);
    return edges;
  }

  bool hasRoomFor(const Triangle& t) const {
    const Vec3 normal = findNormal(rest_, t);
    const double longest = findLongestEdge(rest_, t);
    if (!(normal.norm() > kFlat * longest * longest)) return false;
    for (int k = 0; k < 3; ++k) {
      if (hasEdge(t[k], t[(k + 1) % 3])) return false;
      const auto beside = owner_.find({t[(k + 1) % 3], t[k]});
      if (beside != owner_.end() && !(normal.dot(findNormal(rest_, triangles_[beside->second])) > 0.0)) return false;
    }
    const contact::Box box = findBox(rest_, t);
    bool is_free = true;
    tree_.visitMeeting(box, [&](Index other) { is_free = is_free && !doOverlap(rest_, t, triangles_[other]); });
    lone_tree_->visitMeeting(box, [&](Index k) {
      const Index v = lone_[k];
      is_free = is_free && (is_used_[v] != 0 || hasCorner(t, v) || !liesOn(rest_, v, t));
    });
    return is_free;
  }
  void add(const Triangle& t) {
    triangles_.push_back(t);
    tree_.add(findBox(rest_, t));
    take(static_cast<Index>(triangles_.size()) - 1);
  }

 private:
  void take(Index index) {
    const Triangle& t = triangles_[index];
    for (int k = 0; k < 3; ++k) {
      const Index from = t[k], to = t[(k + 1) % 3];
      owner_.emplace(std::make_pair(from, to), index);
      around_[from].insert(to);
      around_[to].insert(from);
      is_used_[from] = 1;
    }
  }

  const Points& rest_;
  std::vector<Triangle> triangles_;
  GrowingTree tree_;
  std::map<std::pair<Index, Index>, Index> owner_;  // of each edge, in the direction in which its triangle traverses it
  std::map<Index, std::set<Index>> around_;
  std::vector<char> is_used_;
  std::vector<Index> lone_;  // points that had no triangle
  std::unique_ptr<contact::BoxTree> lone_tree_;
};

class Filler {
 public:
  Filler(const Points& rest, const std::vector<Triangle>& layer, const std::vector<Triangle>& surface)
      : rest_(rest), layer_(rest, layer), ground_(rest, surface) {}

  void addOfSurface(std::vector<Triangle> surface) {
    std::vector<std::pair<double, Triangle>> by_length;
    for (const Triangle& t : surface) by_length.emplace_back(findLongestEdge(rest_, t), t);
    std::sort(by_length.begin(), by_length.end());
    for (const auto& [longest, t] : by_length)
      if (layer_.hasRoomFor(t)) add({t, {t}});
  }

  // Between two neighbouring edges of a hole, those with the shortest third edge first.
  void addBetweenEdges() {
    for (const auto& [from, to] : layer_.listBorder()) listFollowing(from, to);
    while (!corners_.empty()) {
      const Triangle t = std::get<1>(*corners_.begin());
      corners_.erase(corners_.begin());
      if (!layer_.isBorder(t[0], t[1]) || !layer_.isBorder(t[1], t[2]) || !layer_.hasRoomFor(t)) continue;
      Filling filling{t, {}};
      if (!liesOnGround(filling)) continue;
      add(filling);
      if (!layer_.isBorder(t[0], t[2])) continue;
      listFollowing(t[0], t[2]);
      for (const Index before : layer_.listBorder(t[0], false)) list(before, t[0], t[2]);
    }
  }

  std::vector<Filling> takeFillings() { return std::move(fillings_); }

 private:
  // Where an edge of the new triangle is a border, nothing need lie beneath its middle.
  bool liesOnGround(Filling& filling) const {
    const Triangle& t = filling.triangle;
    Triangle beneath;
    for (const Vec3& place : listPlaces(rest_, t)) {
      if (!ground_.find(t, place, beneath)) return false;
      filling.beneath.push_back(beneath);
    }
    for (int k = 0; k < 3; ++k)
      if (ground_.find(t, 0.5 * (rest_[t[k]] + rest_[t[(k + 1) % 3]]), beneath)) filling.beneath.push_back(beneath);
    return true;
  }
  void listFollowing(Index from, Index to) {
    for (const Index next : layer_.listBorder(to, true)) list(from, to, next);
  }
  void list(Index from, Index by, Index to) {
    if (from != to) corners_.emplace((rest_[to] - rest_[from]).norm(), Triangle{from, by, to});
  }
  void add(const Filling& filling) {
    layer_.add(filling.triangle);
    fillings_.push_back(filling);
  }

  const Points& rest_;
  Layer layer_;
  TrianglesBeneath ground_;                         // the surface, on which a new triangle has to lie
  std::set<std::tuple<double, Triangle>> corners_;  // by the length of the third edge
  std::vector<Filling> fillings_;
};

}  // namespace

std::vector<Filling> fillHoles(const Points& rest, const std::vector<Triangle>& layer, const std::vector<Triangle>& surface) {
  Filler filler(rest, layer, surface);
  filler.addOfSurface(surface);
  filler.addBetweenEdges();
  return filler.takeFillings();
}

}  // namespace deformable_surface::simulation
