// The transfer of a surface that is cut: dense points follow simulation points of their own side alone. Apart from the transfer
// itself, which knows neither links nor knives, and from the deformed surface, which needs it rarely.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/tool/blade.h"

#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

class CutTransfer {
 public:
  using Link = std::pair<Index, Index>;

  /// Begins as the transfer of the rest surface, which is kept by reference.
  CutTransfer(const RestSurface& rest, const transfer::TransferParams& params);

  /// A knife went through while the simulation points (m x 3) moved from before to after. A dense point that it parted from one
  /// of those that the point follows at rest will not follow it again. Returns whether there is any.
  bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after);

  /// The links (m) that are whole now. A dense point goes with its home, the nearest simulation point that it was not severed
  /// from, and follows what can be reached from there over a few whole links: as many as at rest, as far as there are. Rows of
  /// the operator where nothing is cut stay as they are.
  void followLinks(const std::vector<Link>& whole);

  const transfer::Transfer& transfer() const { return transfer_; }

  /// What a snapshot must hold: bit j of a dense point, it is severed from the j-th simulation point that it follows at rest.
  using Memory = std::vector<std::uint64_t>;
  /// The same one until sever() finds something more.
  std::shared_ptr<const Memory> memory() const;
  void setMemory(const std::shared_ptr<const Memory>& severed, const std::vector<Link>& whole);

 private:
  const RestSurface& rest_;
  const transfer::TransferParams params_;
  transfer::Transfer transfer_;
  Memory severed_;                                // (dense)
  mutable std::shared_ptr<const Memory> memory_;  // the same; null: not asked for yet
  std::vector<char> is_refit_;                    // (dense) its row is another than at rest
  // Scratch.
  Points dense_before_, dense_after_;
  Memory parted_;  // (dense) by the last knife
};

}  // namespace deformable_surface::simulation
