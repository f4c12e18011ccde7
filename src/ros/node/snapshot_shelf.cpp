#include "snapshot_shelf.h"

#include "names.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <utility>

namespace deformable_surface::node {

void SnapshotShelf::put(const std::string& name, Entry entry) {
  if (!isBareName(name)) throw InputError("name: found " + quote(name.substr(0, kLongestName)) + "; accepted: " + kBareNames);
  std::size_t count = 1, bytes = entry.snapshot.bytes();
  for (const auto& [other, kept] : entries_) {
    if (other == name) continue;
    ++count;
    bytes += kept.snapshot.bytes();
  }
  if (count > kMaxSnapshots)
    throw InputError("found " + std::to_string(kMaxSnapshots) + " snapshots already; accepted: no more, remove one first");
  if (bytes > kMaxSnapshotBytes)
    throw InputError("found snapshots of " + std::to_string(bytes) + " bytes with this one; accepted: up to " +
                     std::to_string(kMaxSnapshotBytes) + ", remove one first");
  entries_[name] = std::move(entry);
}

const SnapshotShelf::Entry& SnapshotShelf::find(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found != entries_.end()) return found->second;
  std::string names;
  for (const auto& [other, entry] : entries_) names += (names.empty() ? "" : ", ") + other;
  throw InputError("name: found " + quote(name.substr(0, kLongestName)) + "; accepted: " +
                   (names.empty() ? "a name that ~snapshot was given for this surface, of which there are none" : names));
}

void SnapshotShelf::remove(const std::string& name) {
  find(name);
  entries_.erase(name);
}

}  // namespace deformable_surface::node
