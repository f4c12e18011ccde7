// The full surface of a state: every input point where it is now, with its normal, and those that came since. A file of its own,
// because nothing of it is needed for a step: it is made when somebody looks.
#pragma once

#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/simulation/simulation.h"
#include "deformable_surface/transfer/resample.h"

#include <memory>

#include "cloud_follower.h"
#include "cut_transfer.h"

namespace deformable_surface::simulation {

class DeformedSurface : public CutFollower {
 public:
  /// All are kept by reference and stay what they are. follower: of the model; null: the transfer of the rest surface.
  DeformedSurface(const RestSurface& rest, const cloud::PointCloud& input, const SceneParams& params,
                  std::unique_ptr<CloudFollower> follower);

  /// At rest again: inserted points go.
  void reset();
  /// Where points are inserted, in every step, so that what is inserted does not depend on who looks; it costs a transfer per
  /// step.
  void resample(const model::State& state);
  /// The inserted points, for a snapshot; null if none are ever inserted.
  std::shared_ptr<const transfer::Resampler> saveInserted() const;
  void restoreInserted(const std::shared_ptr<const transfer::Resampler>& saved);

  bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after) override;
  void followLinks(const std::vector<std::pair<Index, Index>>& whole) override;
  /// What was severed, for a snapshot; null: nothing.
  std::shared_ptr<const CutTransfer::Memory> saveCut() const { return cut_ ? cut_->memory() : nullptr; }
  void restoreCut(const std::shared_ptr<const CutTransfer::Memory>& saved, const std::vector<std::pair<Index, Index>>& whole);

  /// The state is another than that of the last make().
  void invalidate();
  /// Another number whenever the state may be another, also than that of any other surface.
  std::uint64_t revision() const { return revision_; }
  bool isMade() const { return is_made_; }
  bool hasNormals() const { return has_normals_; }
  /// Whether the last make() left parts of it as they were, because nothing that they follow had moved.
  bool hasRested() const { return has_rested_; }
  /// The surface of the state, if it has not been made yet. with_normals: computed if params.output.normals, too.
  const Surface& make(const model::State& state, bool with_normals);

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
  // Where the input's point is now that is this dense one.
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
  std::vector<std::pair<Index, Index>> whole_;  // the links that it was told of last
  bool is_following_ = false;                   // it is being told of others, or was interrupted there

  // Of a surface that is made in tiles: of each its rows of the input, ascending. Without holes and coincident points (is_plain_)
  // these are the points themselves, and there is no list.
  const bool is_plain_;
  Lists rows_;
  transfer::Transfer::Frame frame_;
  bool has_rested_ = false;

  Points dense_now_;
  std::vector<Eigen::Vector3f> dense_normals_now_;
  Surface surface_;
  bool is_made_ = false, has_normals_ = false;
  std::uint64_t revision_ = 0;
};

}  // namespace deformable_surface::simulation
