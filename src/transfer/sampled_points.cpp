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

SampledPoints::SampledPoints(const Transfer& rows, const Points& simulation, const std::vector<Index>& cell,
                             std::vector<char> is_spare)
    : k_(rows.numNeighbors()),
      cell_(cell),
      is_spare_(std::move(is_spare)),
      radius_(simulation.size(), 0.0),
      height_(simulation.size(), 0.0) {
  for (Index s = 0; s < rows.numDense(); ++s) {
    const Transfer::PointRow row = rows.rowOf(s);
    share_.push_back((row.rest - simulation[cell[s]]).norm());
    Frame frame{row.rest - row.height * row.normal, row.tangent_x, row.tangent_y, row.slope_x, row.slope_y, row.height};
    for (Index j = 0; j < k_; ++j) {
      const Entry entry{row.source[j], row.value[j], row.gradient_x[j], row.gradient_y[j]};
      rows_.push_back(entry);
      frame.offset -= entry.value * simulation[entry.point];
      frame.tangent_x -= entry.gradient_x * simulation[entry.point];
      frame.tangent_y -= entry.gradient_y * simulation[entry.point];
    }
    frame_.push_back(frame);
    radius_[cell[s]] = std::max(radius_[cell[s]], (row.rest - simulation[cell[s]]).norm());
    height_[cell[s]] = std::max(height_[cell[s]], std::abs(row.height));
  }
  for (std::size_t s = 0; s < frame_.size(); ++s) {
    share_[s] = radius_[cell[s]] > 0.0 ? (share_[s] / radius_[cell[s]] + kSmooth) / (1.0 + kSmooth) : 1.0;
    if (std::abs(frame_[s].height) > kFlat * radius_[cell[s]]) continue;
    // The offset includes the height.
    const Tangents tangents = findTangents(static_cast<Index>(s), simulation);
    frame_[s].offset += frame_[s].height * tangents.normal.normalized();
    frame_[s].height = 0.0;
  }
  listCells(static_cast<Index>(simulation.size()));
  for (std::size_t c = 0; c < simulation.size(); ++c) spread_.push_back(findSpread(static_cast<Index>(c), simulation));
}

double SampledPoints::findSpread(Index cell, const Points& simulation) const {
  double squared = 0.0;
  for (const Index* j = sources_.begin(cell); j != sources_.end(cell); ++j)
    squared = std::max(squared, (simulation[*j] - simulation[cell]).squaredNorm());
  return std::sqrt(squared);
}

double SampledPoints::findReach(Index cell, const Points& simulation_now) const {
  const double reach = (1.0 + kSmooth) * radius_[cell];
  if (!(spread_[cell] > 0.0)) return reach;
  return reach * std::max(1.0, findSpread(cell, simulation_now) / spread_[cell]);
}

void SampledPoints::listCells(Index num_cells) {
  begin_.assign(num_cells + 1, 0);
  for (const Index c : cell_) ++begin_[c + 1];
  for (Index c = 0; c < num_cells; ++c) begin_[c + 1] += begin_[c];
  sources_ = Lists();
  for (Index c = 0; c < num_cells; ++c) {
    const std::size_t first = sources_.items.size();
    for (Index e = begin(c) * k_; e < end(c) * k_; ++e) sources_.items.push_back(rows_[e].point);
    std::sort(sources_.items.begin() + first, sources_.items.end());
    sources_.items.erase(std::unique(sources_.items.begin() + first, sources_.items.end()), sources_.items.end());
    sources_.offsets.push_back(static_cast<Index>(sources_.items.size()));
  }
}

SampledPoints::Tangents SampledPoints::findTangents(Index s, const Points& simulation_now) const {
  const Frame& frame = frame_[s];
  Tangents t{frame.tangent_x, frame.tangent_y, {}};
  for (Index e = s * k_; e < (s + 1) * k_; ++e) {
    t.x += rows_[e].gradient_x * simulation_now[rows_[e].point];
    t.y += rows_[e].gradient_y * simulation_now[rows_[e].point];
  }
  t.normal = t.x.cross(t.y) + frame.slope_x * t.x + frame.slope_y * t.y;
  return t;
}

Vec3 SampledPoints::place(Index s, const Points& simulation_now) const {
  Vec3 place = frame_[s].offset;
  for (Index e = s * k_; e < (s + 1) * k_; ++e) place += rows_[e].value * simulation_now[rows_[e].point];
  if (frame_[s].height == 0.0) return place;
  return place + frame_[s].height * findTangents(s, simulation_now).normal.normalized();
}

Vec3 SampledPoints::findVelocity(Index s, const Points& velocities) const {
  Vec3 velocity = Vec3::Zero();
  for (Index e = s * k_; e < (s + 1) * k_; ++e) velocity += rows_[e].value * velocities[rows_[e].point];
  return velocity;
}

// With N the normal before it is normalised: F . d(h n) = h / |N| f . dN, f the part of F across n, and
// dN = dT_x x T_y + T_x x dT_y + s_x dT_x + s_y dT_y.
void SampledPoints::scatter(Index s, const Points& simulation_now, const Vec3& force, Points& forces) const {
  const Frame& frame = frame_[s];
  Vec3 by_x = Vec3::Zero(), by_y = Vec3::Zero();
  if (frame.height != 0.0) {
    const Tangents t = findTangents(s, simulation_now);
    const double length = t.normal.norm();
    const Vec3 n = t.normal / length, f = frame.height / length * (force - force.dot(n) * n);
    by_x = t.y.cross(f) + frame.slope_x * f;
    by_y = f.cross(t.x) + frame.slope_y * f;
  }
  for (Index e = s * k_; e < (s + 1) * k_; ++e) {
    const Entry& entry = rows_[e];
    forces[entry.point] += entry.value * force + entry.gradient_x * by_x + entry.gradient_y * by_y;
  }
}

SampledPoints SampledPoints::takePart(const std::vector<Index>& new_index, Index new_size, std::vector<Index>& old) const {
  SampledPoints part;
  part.k_ = k_;
  part.radius_.assign(new_size, 0.0);
  part.height_.assign(new_size, 0.0);
  part.spread_.assign(new_size, 0.0);
  // By the new cells, whose order may differ.
  std::vector<std::pair<Index, Index>> kept;  // cell, sample before
  for (Index s = 0; s < size(); ++s) {
    bool is_left = new_index[cell_[s]] >= 0;
    for (Index e = s * k_; e < (s + 1) * k_; ++e) is_left = is_left && new_index[rows_[e].point] >= 0;
    if (is_left) kept.emplace_back(new_index[cell_[s]], s);
  }
  std::sort(kept.begin(), kept.end());
  old.clear();
  for (const auto& [cell, s] : kept) {
    old.push_back(s);
    part.cell_.push_back(cell);
    part.share_.push_back(share_[s]);
    if (!is_spare_.empty()) part.is_spare_.push_back(is_spare_[s]);
    part.frame_.push_back(frame_[s]);
    part.radius_[cell] = radius_[cell_[s]];
    part.height_[cell] = height_[cell_[s]];
    part.spread_[cell] = spread_[cell_[s]];
    for (Index e = s * k_; e < (s + 1) * k_; ++e) {
      part.rows_.push_back(rows_[e]);
      part.rows_.back().point = new_index[rows_[e].point];
    }
  }
  part.listCells(new_size);
  return part;
}

}  // namespace deformable_surface::transfer
