// Named snapshots of a surface, in bounded memory.
#pragma once

#include "pending_commands.h"

#include "deformable_surface/simulation/simulation.h"

#include <cstdint>
#include <map>
#include <string>

namespace deformable_surface::node {

// Far more than a planner needs, and a share of the memory of any computer that runs it.
constexpr std::size_t kMaxSnapshots = 256;
constexpr std::size_t kMaxSnapshotBytes = std::size_t{1} << 30;

class SnapshotShelf {
 public:
  struct Entry {
    simulation::Snapshot snapshot;
    PendingCommands::Memory commands;
    std::uint64_t state_hash = 0;
  };

  /// Replaces the one of that name. Throws InputError, and changes nothing, for a name that is not accepted and if there are
  /// too many or too large ones already.
  void put(const std::string& name, Entry entry);
  /// Throws InputError if there is none.
  const Entry& find(const std::string& name) const;
  void remove(const std::string& name);
  void clear() { entries_.clear(); }
  const std::map<std::string, Entry>& all() const { return entries_; }

 private:
  std::map<std::string, Entry> entries_;
};

}  // namespace deformable_surface::node
