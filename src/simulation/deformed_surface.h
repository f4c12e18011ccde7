// The full surface of a state: every input point at its present place, with its normal, and the points added since. Steps do not
// need it: it is made on demand.
#pragma once

#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/simulation/simulation.h"
#include "deformable_surface/transfer/resample.h"

#include <memory>

#include "cloud_follower.h"
#include "cut_transfer.h"
#include "local_errors.h"

namespace deformable_surface::simulation {

class DeformedSurface : public CutFollower {
 public:
  /// All are kept by reference and do not change. follower: of the model; null: the transfer of the rest surface.
  DeformedSurface(const RestSurface& rest, const cloud::PointCloud& input, const SceneParams& params,
                  std::unique_ptr<CloudFollower> follower);

  /// Back at rest: inserted points are removed.
  void reset();
  /// If points are inserted: to be called in every step, so that the insertion does not depend on who reads the surface. It costs
  /// a transfer per step.
  void resample(const model::State& state);
  /// The inserted points, for a snapshot; null if none are ever inserted.
  std::shared_ptr<const transfer::Resampler> saveInserted() const;
  void restoreInserted(const std::shared_ptr<const transfer::Resampler>& saved);

  bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after) override;
  void followLinks(const std::vector<std::pair<Index, Index>>& whole) override;
  /// What was separated by cuts, for a snapshot; null: nothing.
  std::shared_ptr<const CutTransfer::Memory> saveCut() const { return cut_ ? cut_->memory() : nullptr; }
  void restoreCut(const std::shared_ptr<const CutTransfer::Memory>& saved, const std::vector<std::pair<Index, Index>>& whole);

  /// The state has changed since the last make().
  void invalidate();
  /// Changes whenever the state may have changed; unique among all surfaces.
  std::uint64_t revision() const { return revision_; }
  bool isMade() const { return is_made_; }
  bool hasNormals() const { return has_normals_; }
  /// Whether the last make() kept parts of it because nothing that they follow had moved.
  bool hasRested() const { return has_rested_; }
  /// The surface of the state, computed once per state. with_normals: computed if params.output.normals, too.
  const Surface& make(const model::State& state, bool with_normals);
  /// Of the surface that was made.
  void setErrors(const LocalErrors& errors);

 private:
  const transfer::Transfer& currentTransfer() const;
  void analyseNormals();
  Lists findFollowed() const;
  void moveInserted(const Points& positions, bool with_normals);
  bool isSaved() const;
  bool isInTiles() const;
  void moveTiles(const Points& positions, bool with_normals);
  void groupRows();
  void fillRows(Index begin, Index end, bool with_normals);
  void expand(bool with_normals);
  // The present place of the input's point of this dense point.
  Vec3 placeRow(Index d) const { return rest_.off_surface.empty() ? dense_now_[d] : Vec3(dense_now_[d] + rest_.off_surface[d]); }
  void appendInserted(bool with_normals);

  const RestSurface& rest_;
  const cloud::PointCloud& input_;
  const SceneParams& params_;
  std::vector<Index> first_input_;  // (dense) the first input point that each is
  const std::unique_ptr<CloudFollower> follower_;

  // Points inserted where the surface is stretched.
  std::unique_ptr<transfer::Resampler> resampler_;
  mutable std::shared_ptr<const transfer::Resampler> saved_inserted_;  // the last that was saved or restored
  transfer::Transfer inserted_transfer_;
  Points inserted_now_, all_now_;
  std::vector<Eigen::Vector3f> inserted_normals_now_;

  std::unique_ptr<CutTransfer> cut_;            // null: nothing is cut
  std::vector<std::pair<Index, Index>> whole_;  // the links of the last followLinks()
  bool is_following_ = false;                   // followLinks() is running, or was interrupted

  // For a surface that is made in tiles: the rows of the input of each tile, ascending. Without holes and coincident points
  // (is_plain_) these are the points themselves, and there is no list.
  const bool is_plain_;
  Lists rows_;
  transfer::Transfer::Frame frame_;
  bool has_rested_ = false;

  Points dense_now_;
  std::vector<Eigen::Vector3f> dense_normals_now_;
  std::vector<float> dense_apart_;  // (n) m, the largest among the simulation points that each follows
  Surface surface_;
  bool is_made_ = false, has_normals_ = false;
  std::uint64_t revision_ = 0;
};

}  // namespace deformable_surface::simulation
