#include "deformed_surface.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/cloud/normals.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

constexpr double kResampleStretch = 1.5;  // of the rest spacing at which a point is inserted
constexpr Index kBlock = 4096;
// Whether the input's rows are the dense points.
bool isPlain(const std::vector<Index>& point_of_input, std::size_t num_dense) {
  bool is_plain = point_of_input.size() == num_dense;
  for (std::size_t i = 0; is_plain && i < num_dense; ++i) is_plain = point_of_input[i] == static_cast<Index>(i);
  return is_plain;
}

// Of as many points, (n x 3) m.
DEFORMABLE_SURFACE_WIDE void measureDistances(Index n, const double* a, const double* b, float* distances) {
#pragma GCC ivdep
  for (Index i = 0; i < n; ++i) {
    const double x = a[3 * i] - b[3 * i], y = a[3 * i + 1] - b[3 * i + 1], z = a[3 * i + 2] - b[3 * i + 2];
    distances[i] = static_cast<float>(std::sqrt(x * x + (y * y + z * z)));  // in the order of Eigen's norm()
  }
}

const float kNaN = std::numeric_limits<float>::quiet_NaN();

}  // namespace

DeformedSurface::DeformedSurface(const RestSurface& rest, const cloud::PointCloud& input, const SceneParams& params,
                                 std::unique_ptr<CloudFollower> follower)
    : rest_(rest),
      input_(input),
      params_(params),
      first_input_(rest.dense.positions.size(), -1),
      follower_(std::move(follower)),
      is_plain_(rest.off_surface.empty() && isPlain(rest.dense.point_of_input, rest.dense.positions.size())) {
  for (Index i = input.size() - 1; i >= 0; --i)
    if (rest.dense.point_of_input[i] >= 0) first_input_[rest.dense.point_of_input[i]] = i;
}

void DeformedSurface::invalidate() {
  static std::atomic<std::uint64_t> last{0};
  is_made_ = has_normals_ = false;
  revision_ = ++last;
}

void DeformedSurface::reset() {
  invalidate();
  if (follower_) follower_->reset();
  cut_.reset();
  frame_.forget();
  saved_inserted_.reset();
  if (!params_.output.resample) return;
  const cloud::Rings rings = cloud::buildRings(rest_.dense.positions, rest_.dense.normals, rest_.dense_neighbors);
  const Index room = std::max<Index>(0, params_.input.max_points - static_cast<Index>(rest_.dense.positions.size()));
  resampler_ = std::make_unique<transfer::Resampler>(rest_.dense.positions, rest_.dense.normals, rings, kResampleStretch, room);
  inserted_transfer_ = transfer::Transfer();
}

std::shared_ptr<const transfer::Resampler> DeformedSurface::saveInserted() const {
  if (resampler_ && !isSaved()) saved_inserted_ = std::make_shared<const transfer::Resampler>(*resampler_);
  return saved_inserted_;
}

bool DeformedSurface::isSaved() const {
  return resampler_ ? saved_inserted_ && saved_inserted_->revision() == resampler_->revision() : !saved_inserted_;
}

void DeformedSurface::restoreInserted(const std::shared_ptr<const transfer::Resampler>& saved) {
  if (saved == saved_inserted_ && isSaved()) return;
  if (saved) resampler_ = std::make_unique<transfer::Resampler>(*saved);
  saved_inserted_ = saved;
  inserted_transfer_ = transfer::Transfer();
}

void DeformedSurface::resample(const model::State& state) {
  if (!resampler_) return;
  rest_.transfer.apply(state.positions, dense_now_);
  moveInserted(state.positions, false);
  all_now_ = dense_now_;
  all_now_.insert(all_now_.end(), inserted_now_.begin(), inserted_now_.end());
  resampler_->update(all_now_);
}

const Surface& DeformedSurface::make(const model::State& state, bool with_normals) {
  with_normals = with_normals && params_.output.normals;
  if (is_made_ && (has_normals_ || !with_normals)) return surface_;
  has_rested_ = false;
  if (isInTiles()) {
    moveTiles(state.positions, with_normals);
    is_made_ = true;
    has_normals_ = with_normals;
    return surface_;
  }
  if (follower_) {
    follower_->follow(state, dense_now_, with_normals ? &dense_normals_now_ : nullptr);
  } else if (with_normals) {
    currentTransfer().apply(state.positions, dense_now_, dense_normals_now_);
  } else {
    currentTransfer().apply(state.positions, dense_now_);
  }
  const bool is_surface = !follower_ || follower_->isSurface();
  if (with_normals && is_surface && params_.transfer.normals == transfer::NormalMethod::kCovariance) analyseNormals();
  if (resampler_) moveInserted(follower_ ? follower_->firstPositions(state) : state.positions, with_normals);
  expand(with_normals);
  if (resampler_) appendInserted(with_normals);
  if (follower_) follower_->append(state, first_input_, with_normals, surface_);
  is_made_ = true;
  has_normals_ = with_normals;
  return surface_;
}

// A surface without inserted, added and removed points: its rows depend only on simulation points nearby.
bool DeformedSurface::isInTiles() const {
  return !follower_ && !resampler_ && params_.transfer.normals == transfer::NormalMethod::kGradient;
}

void DeformedSurface::groupRows() {
  const std::vector<Index>& point_of_input = rest_.dense.point_of_input;
  rows_.offsets.assign(currentTransfer().numTiles() + 1, 0);
  const auto tileOf = [](Index d) { return d / transfer::Transfer::kTilePoints; };
  for (Index d : point_of_input)
    if (d >= 0) ++rows_.offsets[tileOf(d) + 1];
  for (std::size_t t = 1; t < rows_.offsets.size(); ++t) rows_.offsets[t] += rows_.offsets[t - 1];
  rows_.items.resize(rows_.offsets.back());
  std::vector<Index> next(rows_.offsets.begin(), rows_.offsets.end() - 1);
  for (Index i = 0; i < input_.size(); ++i)
    if (point_of_input[i] >= 0) rows_.items[next[tileOf(point_of_input[i])]++] = i;
}

// The rows of a tile are filled in as soon as its points are computed. Rows without a point stay NaN.
void DeformedSurface::moveTiles(const Points& positions, bool with_normals) {
  const Index n = input_.size();
  surface_.num_input = n;
  surface_.source.clear();
  if (static_cast<Index>(surface_.positions.size()) != n) {
    surface_.positions.assign(n, Vec3::Constant(kNaN));
    surface_.displacement.assign(n, kNaN);
  }
  if (surface_.normals.size() != (with_normals ? surface_.positions.size() : 0))
    surface_.normals.assign(with_normals ? n : 0, Eigen::Vector3f::Constant(kNaN));
  if (!is_plain_ && rows_.size() == 0) groupRows();
  const transfer::Transfer& transfer = currentTransfer();
  const Index made = transfer.update(positions, frame_, is_plain_ ? surface_.positions : dense_now_,
                                     !with_normals ? nullptr
                                     : is_plain_   ? &surface_.normals
                                                   : &dense_normals_now_,
                                     [this, with_normals](Index begin, Index end) { fillRows(begin, end, with_normals); });
  has_rested_ = made < transfer.numTiles();
}

void DeformedSurface::fillRows(Index begin, Index end, bool with_normals) {
  const Points& rest = rest_.dense.positions;
  if (is_plain_) {
    measureDistances(end - begin, surface_.positions[begin].data(), rest[begin].data(), surface_.displacement.data() + begin);
    return;
  }
  const Index tile = begin / transfer::Transfer::kTilePoints;
  for (const Index* row = rows_.begin(tile); row != rows_.end(tile); ++row) {
    const Index d = rest_.dense.point_of_input[*row];
    surface_.positions[*row] = placeRow(d);
    surface_.displacement[*row] = static_cast<float>((dense_now_[d] - rest[d]).norm());
    if (with_normals) surface_.normals[*row] = dense_normals_now_[d];
  }
}

void DeformedSurface::setErrors(const LocalErrors& errors) {
  const bool is_known = std::isfinite(errors.most);
  if (is_known && !errors.apart.empty())
    currentTransfer().findLargest(errors.apart, dense_apart_);
  else
    dense_apart_.assign(rest_.dense.positions.size(), 0.0f);
  const Index n = input_.size();
  surface_.error.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index d = rest_.dense.point_of_input[i];
      const double here = is_known && d >= 0 ? std::min(dense_apart_[d] + errors.everywhere, errors.most) : errors.most;
      surface_.error[i] = d < 0 ? kNaN : static_cast<float>(here);
    }
  });
}

const transfer::Transfer& DeformedSurface::currentTransfer() const { return cut_ ? cut_->transfer() : rest_.transfer; }

bool DeformedSurface::sever(const tool::BladeSweep& blade, const Points& before, const Points& after) {
  if (first_input_.empty()) return false;  // simulation points alone
  if (!cut_) cut_ = std::make_unique<CutTransfer>(rest_, params_.transfer);
  return cut_->sever(blade, before, after);
}

void DeformedSurface::followLinks(const std::vector<std::pair<Index, Index>>& whole) {
  if (first_input_.empty()) return;
  if (!cut_) cut_ = std::make_unique<CutTransfer>(rest_, params_.transfer);
  is_following_ = true;
  cut_->followLinks(whole);
  is_following_ = false;
  whole_ = whole;
  frame_.forget();
  invalidate();
}

void DeformedSurface::restoreCut(const std::shared_ptr<const CutTransfer::Memory>& saved,
                                 const std::vector<std::pair<Index, Index>>& whole) {
  const bool is_same = cut_ ? saved == cut_->memory() && whole == whole_ : !saved;
  if (is_same && !is_following_) return;
  is_following_ = false;
  cut_.reset();
  frame_.forget();
  if (!saved) return;
  cut_ = std::make_unique<CutTransfer>(rest_, params_.transfer);
  cut_->setMemory(saved, whole);
  whole_ = whole;
}

// Normals by covariance analysis of the deformed points, as published, on the side of the transferred ones.
void DeformedSurface::analyseNormals() {
  const Points analysed = cloud::estimateNormals(dense_now_, rest_.dense_neighbors);
  for (std::size_t i = 0; i < analysed.size(); ++i) {
    const Eigen::Vector3f normal = analysed[i].cast<float>();
    dense_normals_now_[i] = normal.dot(dense_normals_now_[i]) < 0.0f ? Eigen::Vector3f(-normal) : normal;
  }
}

// For inserted points, along the surface: an inserted point lies in the cell of the first of the two points between which it
// was inserted.
Lists DeformedSurface::findFollowed() const {
  std::vector<Index> owner = rest_.cells.owner;
  for (const auto& [a, b] : resampler_->parents()) owner.push_back(owner[a]);
  owner.erase(owner.begin(), owner.begin() + rest_.dense.positions.size());
  return cloud::findChosenNear(rest_.cells, owner, resampler_->insertedRest(), params_.transfer.k);
}

void DeformedSurface::moveInserted(const Points& positions, bool with_normals) {
  inserted_now_.clear();
  inserted_normals_now_.clear();
  if (resampler_->insertedRest().empty()) return;
  if (inserted_transfer_.numDense() != static_cast<Index>(resampler_->insertedRest().size())) {
    const bool is_euclidean = params_.neighbors.areEuclidean();
    const Lists followed = is_euclidean ? Lists{} : findFollowed();
    inserted_transfer_ =
        transfer::Transfer(resampler_->insertedRest(), resampler_->insertedNormals(), rest_.points,
                           std::vector<char>(rest_.points.size(), 1), params_.transfer, is_euclidean ? nullptr : &followed);
  }
  if (with_normals) {
    inserted_transfer_.apply(positions, inserted_now_, inserted_normals_now_);
  } else {
    inserted_transfer_.apply(positions, inserted_now_);
  }
}

// From distinct points to the rows of the input.
void DeformedSurface::expand(bool with_normals) {
  const Index n = input_.size();
  surface_.num_input = n;
  surface_.positions.resize(n);
  surface_.displacement.resize(n);
  surface_.normals.resize(with_normals ? n : 0);
  surface_.source.clear();
  static const std::vector<char> none;
  const std::vector<char>& is_gone = follower_ ? follower_->gone() : none;
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index d = rest_.dense.point_of_input[i];
      if (d < 0 || (!is_gone.empty() && is_gone[d])) {
        surface_.positions[i].setConstant(kNaN);
        surface_.displacement[i] = kNaN;
        if (with_normals) surface_.normals[i].setConstant(kNaN);
        continue;
      }
      surface_.positions[i] = placeRow(d);
      surface_.displacement[i] = static_cast<float>((dense_now_[d] - rest_.dense.positions[d]).norm());
      if (with_normals) surface_.normals[i] = dense_normals_now_[d];
    }
  });
}

void DeformedSurface::appendInserted(bool with_normals) {
  const Index num_dense = static_cast<Index>(rest_.dense.positions.size());
  for (std::size_t p = 0; p < inserted_now_.size(); ++p) {
    surface_.positions.push_back(inserted_now_[p]);
    surface_.displacement.push_back(static_cast<float>((inserted_now_[p] - resampler_->insertedRest()[p]).norm()));
    if (with_normals) surface_.normals.push_back(inserted_normals_now_[p]);
    const Index parent = resampler_->parents()[p].first;
    surface_.source.push_back(parent < num_dense ? first_input_[parent] : surface_.source[parent - num_dense]);
  }
}

}  // namespace deformable_surface::simulation
