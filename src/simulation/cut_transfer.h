// The transfer of a cut surface: dense points follow only simulation points on their own side. The general transfer
// knows neither links nor knives.
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

  /// Starts from the transfer of the rest surface, which is kept by reference.
  CutTransfer(const RestSurface& rest, const transfer::TransferParams& params);

  /// A knife passed while the simulation points (m x 3) moved from before to after. A dense point never again follows a point, of
  /// those that it follows at rest, from which the knife separated it. Returns whether any was separated.
  bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after);

  /// Sets the whole links (m). The home of a dense point is the nearest simulation point that it was not separated from.
  /// It follows the points that can be reached from there over a few whole links: as many as at rest, if there are as many. Rows
  /// of the operator where nothing is cut stay as they are.
  void followLinks(const std::vector<Link>& whole);

  const transfer::Transfer& transfer() const { return transfer_; }

  /// What a snapshot must hold: bit j of a dense point: it is separated from the j-th simulation point that it follows at rest.
  using Memory = std::vector<std::uint64_t>;
  /// The same pointer until sever() separates more.
  std::shared_ptr<const Memory> memory() const;
  void setMemory(const std::shared_ptr<const Memory>& severed, const std::vector<Link>& whole);

 private:
  const RestSurface& rest_;
  const transfer::TransferParams params_;
  transfer::Transfer transfer_;
  Memory severed_;                                // (dense)
  mutable std::shared_ptr<const Memory> memory_;  // the same; null: not asked for yet
  std::vector<char> is_refit_;                    // (dense) its row differs from the one at rest
  // Scratch.
  Points dense_before_, dense_after_;
  Memory parted_;  // (dense) by the last knife
};

}  // namespace deformable_surface::simulation
