#include "deformable_surface/transfer/sampled_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::transfer {
namespace {

// Fraction of the radius of a cell: lower heights are due to rounding or negligible, and are ignored.
constexpr double kFlat = 1e-4;
// Of the radius of a cell, the most by which a sample changes its distance from the simulation point beside the stretch: at a
// sharp bend the smooth surface leaves the simulation points. Cloth over the corners of boxes: up to a quarter.
constexpr double kSmooth = 0.4;

}  // namespace

SampledPoints::SampledPoints(const Transfer& rows, const Points& simulation, const std::vector<Index>& cell, std::vector<Use> use)
    : k_(rows.numNeighbors()), cell_(cell), use_(std::move(use)), height_(simulation.size(), 0.0) {
  for (Index s = 0; s < rows.numDense(); ++s) {
    const Transfer::PointRow row = rows.rowOf(s);
    share_.push_back((row.rest - simulation[cell[s]]).norm());
    Frame frame{row.rest - row.height * row.normal, row.tangent_x, row.tangent_y, row.slope_x, row.slope_y, row.height};
    for (Index j = 0; j < k_; ++j) {
      const Vec3& x = simulation[row.source[j]];
      source_.push_back(row.source[j]);
      value_.push_back(row.value[j]);
      gradient_.push_back({row.gradient_x[j], row.gradient_y[j]});
      frame.offset -= value_.back() * x;
      frame.tangent_x -= gradient_.back().x * x;
      frame.tangent_y -= gradient_.back().y * x;
    }
    frame_.push_back(frame);
    height_[cell[s]] = std::max(height_[cell[s]], std::abs(row.height));
  }
  findExtents(static_cast<Index>(simulation.size()));
  for (std::size_t s = 0; s < frame_.size(); ++s) {
    if (std::abs(frame_[s].height) > kFlat * extent_[cell[s]]) continue;
    // The offset includes the height.
    const Tangents tangents = findTangents(static_cast<Index>(s), simulation);
    frame_[s].offset += frame_[s].height * tangents.normal.normalized();
    frame_[s].height = 0.0;
  }
  finish(simulation);
}

SampledPoints::SampledPoints(const std::vector<PlaceOnTriangle>& places, const Points& simulation)
    : k_(3), use_(places.size(), kSparePlace), height_(simulation.size(), 0.0) {
  std::vector<std::pair<Index, std::size_t>> order;  // cell, place
  for (std::size_t s = 0; s < places.size(); ++s) order.emplace_back(places[s].nearest(), s);
  std::sort(order.begin(), order.end());
  for (const auto& [cell, s] : order) {
    cell_.push_back(cell);
    source_.insert(source_.end(), places[s].corner.begin(), places[s].corner.end());
    value_.insert(value_.end(), places[s].weight.begin(), places[s].weight.end());
    share_.push_back((places[s].interpolate(simulation) - simulation[cell]).norm());
  }
  findExtents(static_cast<Index>(simulation.size()));
  finish(simulation);
}

// share_: of the distances, m.
void SampledPoints::findExtents(Index num_cells) {
  radius_.assign(num_cells, 0.0);
  extent_.assign(num_cells, 0.0);
  for (Index s = 0; s < size(); ++s) {
    const Index cell = cell_[s];
    extent_[cell] = std::max(extent_[cell], share_[s]);
    largest_extent_ = std::max(largest_extent_, share_[s]);
    if (!isPlace(s)) radius_[cell] = std::max(radius_[cell], share_[s]);
  }
  for (Index s = 0; s < size(); ++s)
    share_[s] = extent_[cell_[s]] > 0.0 ? (share_[s] / extent_[cell_[s]] + kSmooth) / (1.0 + kSmooth) : 1.0;
}

void SampledPoints::finish(const Points& simulation) {
  listCells(static_cast<Index>(simulation.size()));
  for (std::size_t c = 0; c < simulation.size(); ++c) spread_.push_back(findSpread(static_cast<Index>(c), simulation));
}

double SampledPoints::findSpread(Index cell, const Points& simulation) const {
  double squared = 0.0;
  for (const Index* j = sources_.begin(cell); j != sources_.end(cell); ++j)
    squared = std::max(squared, (simulation[*j] - simulation[cell]).squaredNorm());
  return std::sqrt(squared);
}

double SampledPoints::restReach(Index cell) const { return (1.0 + kSmooth) * extent_[cell]; }

double SampledPoints::findReach(Index cell, const Points& simulation_now) const {
  const double reach = restReach(cell);
  if (!(spread_[cell] > 0.0)) return reach;
  return reach * std::max(1.0, findSpread(cell, simulation_now) / spread_[cell]);
}

void SampledPoints::listCells(Index num_cells) {
  begin_.assign(num_cells + 1, 0);
  for (const Index c : cell_) ++begin_[c + 1];
  for (Index c = 0; c < num_cells; ++c) begin_[c + 1] += begin_[c];
  begin_spare_.assign(begin_.begin() + 1, begin_.end());
  for (Index s = size() - 1; s >= 0; --s)
    if (isSpare(s)) begin_spare_[cell_[s]] = s;
  sources_ = Lists();
  for (Index c = 0; c < num_cells; ++c) {
    const std::size_t first = sources_.items.size();
    for (Index e = begin(c) * k_; e < end(c) * k_; ++e) sources_.items.push_back(source_[e]);
    std::sort(sources_.items.begin() + first, sources_.items.end());
    sources_.items.erase(std::unique(sources_.items.begin() + first, sources_.items.end()), sources_.items.end());
    sources_.offsets.push_back(static_cast<Index>(sources_.items.size()));
  }
}

SampledPoints::Tangents SampledPoints::findTangents(Index s, const Points& simulation_now) const {
  const Frame& frame = frame_[s];
  Tangents t{frame.tangent_x, frame.tangent_y, {}};
  for (Index e = s * k_; e < (s + 1) * k_; ++e) {
    t.x += gradient_[e].x * simulation_now[source_[e]];
    t.y += gradient_[e].y * simulation_now[source_[e]];
  }
  t.normal = t.x.cross(t.y) + frame.slope_x * t.x + frame.slope_y * t.y;
  return t;
}

Vec3 SampledPoints::place(Index s, const Points& simulation_now) const {
  Vec3 place = frame_.empty() ? Vec3::Zero() : frame_[s].offset;
  for (Index e = s * k_; e < (s + 1) * k_; ++e) place += value_[e] * simulation_now[source_[e]];
  if (frame_.empty() || frame_[s].height == 0.0) return place;
  return place + frame_[s].height * findTangents(s, simulation_now).normal.normalized();
}

Vec3 SampledPoints::findVelocity(Index s, const Points& velocities) const {
  Vec3 velocity = Vec3::Zero();
  for (Index e = s * k_; e < (s + 1) * k_; ++e) velocity += value_[e] * velocities[source_[e]];
  return velocity;
}

// With N the normal before it is normalised: F . d(h n) = h / |N| f . dN, f the part of F across n, and
// dN = dT_x x T_y + T_x x dT_y + s_x dT_x + s_y dT_y.
void SampledPoints::scatter(Index s, const Points& simulation_now, const Vec3& force, Points& forces) const {
  if (frame_.empty() || frame_[s].height == 0.0) {
    for (Index e = s * k_; e < (s + 1) * k_; ++e) forces[source_[e]] += value_[e] * force;
    return;
  }
  const Frame& frame = frame_[s];
  const Tangents t = findTangents(s, simulation_now);
  const double length = t.normal.norm();
  const Vec3 n = t.normal / length, f = frame.height / length * (force - force.dot(n) * n);
  const Vec3 by_x = t.y.cross(f) + frame.slope_x * f, by_y = f.cross(t.x) + frame.slope_y * f;
  for (Index e = s * k_; e < (s + 1) * k_; ++e)
    forces[source_[e]] += value_[e] * force + (gradient_[e].x * by_x + gradient_[e].y * by_y);
}

SampledPoints SampledPoints::takePart(const std::vector<Index>& new_index, Index new_size, std::vector<Index>& old) const {
  SampledPoints part;
  part.k_ = k_;
  part.largest_extent_ = largest_extent_;
  part.radius_.assign(new_size, 0.0);
  part.extent_.assign(new_size, 0.0);
  part.height_.assign(new_size, 0.0);
  part.spread_.assign(new_size, 0.0);
  // By the new cells, whose order may differ.
  std::vector<std::pair<Index, Index>> kept;  // cell, sample before
  for (Index s = 0; s < size(); ++s) {
    bool is_left = new_index[cell_[s]] >= 0;
    for (Index e = s * k_; e < (s + 1) * k_; ++e) is_left = is_left && new_index[source_[e]] >= 0;
    if (is_left) kept.emplace_back(new_index[cell_[s]], s);
  }
  std::sort(kept.begin(), kept.end());
  old.clear();
  for (const auto& [cell, s] : kept) {
    old.push_back(s);
    part.cell_.push_back(cell);
    part.share_.push_back(share_[s]);
    if (!use_.empty()) part.use_.push_back(use_[s]);
    if (!frame_.empty()) part.frame_.push_back(frame_[s]);
    part.radius_[cell] = radius_[cell_[s]];
    part.extent_[cell] = extent_[cell_[s]];
    part.height_[cell] = height_[cell_[s]];
    part.spread_[cell] = spread_[cell_[s]];
    for (Index e = s * k_; e < (s + 1) * k_; ++e) {
      part.source_.push_back(new_index[source_[e]]);
      part.value_.push_back(value_[e]);
      if (!gradient_.empty()) part.gradient_.push_back(gradient_[e]);
    }
  }
  part.listCells(new_size);
  return part;
}

}  // namespace deformable_surface::transfer
