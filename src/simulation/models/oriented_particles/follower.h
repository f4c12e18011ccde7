// How the cloud follows particles that are added and removed. Private to this model.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <memory>

#include "../../cloud_follower.h"

namespace deformable_surface::simulation {

class ParticleFollower : public CloudFollower {
 public:
  /// All are kept by reference. model: of the states that are followed.
  ParticleFollower(const RestSurface& rest, const transfer::TransferParams& transfer, const model::OrientedParticles& model);

  void reset() override;
  void follow(const model::State& state, Points& dense, std::vector<Eigen::Vector3f>* normals) override;
  bool isSurface() const override { return true; }
  const Points& firstPositions(const model::State&) const override { return first_positions_; }
  const std::vector<char>& gone() const override { return is_gone_; }
  void append(const model::State& state, const std::vector<Index>& first_input, bool with_normals,
              Surface& surface) const override;

 private:
  void followPopulation(const model::State& state);
  void followCuts();

  const RestSurface& rest_;
  const transfer::TransferParams& transfer_;
  const model::OrientedParticles& model_;
  const bool is_direct_;  // every dense point is a particle: none has to follow others
  // The initial particles that are left, and what moves with them.
  std::vector<Index> ids_;                                     // of the state that the rest below belongs to
  std::vector<Index> point_of_id_;                             // its point now; -1: gone
  std::vector<char> is_gone_;                                  // (dense) its particle is gone
  std::unique_ptr<transfer::Transfer> survivors_;              // the transfer without the removed ones; null: all are present
  std::shared_ptr<const model::ParticleCuts::Pairs> severed_;  // that the transfer below belongs to
  std::unique_ptr<transfer::Transfer> beside_cuts_;            // the transfer within the sides of cuts; null: there are no cuts
  Points first_positions_;                                     // (m x 3) of the particles of the beginning
};

}  // namespace deformable_surface::simulation
