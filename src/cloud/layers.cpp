// Normals by a vote of the points around, which tells stacked layers from the planes across them.
#include "deformable_surface/cloud/layers.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "fit_plane.h"

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 256;       // points per task
constexpr Index kAround = 8;        // neighbours that are asked whether they lie above
constexpr Index kSpacing = 4;       // neighbours, of which the last is a spacing away
constexpr double kShortest = 0.9;   // of that: nearer points lie above each other on rough surfaces, too
constexpr double kAlike = 0.8;      // cosine from which on normals agree, the more the larger it is
constexpr double kOnPlane = 0.4;    // of the spacing
constexpr std::size_t kFewest = 4;  // points around one that span a plane with it
constexpr double kLine = 0.05;      // ratio of their larger variances below which they lie on a line
constexpr double kSecond = 0.4;     // of the votes for the first
constexpr double kCertain = 0.95;   // cosine: where all around are so near to a point's normal it stays
constexpr int kRounds = 8;

void checkSizes(const char* function, const Points& positions, const Points& normals, const Lists& neighbors) {
  if (positions.size() == normals.size() && static_cast<Index>(positions.size()) == neighbors.size()) return;
  throw InputError(std::string(function) + ": found " + std::to_string(positions.size()) + " positions, " +
                   std::to_string(normals.size()) + " normals and " + std::to_string(neighbors.size()) +
                   " neighbour lists; accepted: equally many");
}

double findSpacing(const Points& positions, const Lists& neighbors, Index i) {
  const Index count = std::min(neighbors.count(i), kSpacing);
  return count == 0 ? 0.0 : (positions[neighbors.begin(i)[count - 1]] - positions[i]).norm();
}

bool isCertain(const Lists& neighbors, const Points& normals, Index i) {
  const auto agrees = [&](Index j) { return std::abs(normals[j].dot(normals[i])) > kCertain; };
  return std::all_of(neighbors.begin(i), neighbors.end(i), agrees);
}

// The votes of those around a point for the normals of each of them.
class Vote {
 public:
  Vote(const Lists& neighbors, const Points& normals, Index i) : normals_(normals), around_(1, i) {
    around_.insert(around_.end(), neighbors.begin(i), neighbors.end(i));
    for (const Index j : around_) votes_.push_back(count(normals[j]));
  }
  const Vec3& first() const {
    return normals_[around_[findMost([](const Vec3&) { return true; })]];
  }
  /// The first if no other has many votes.
  const Vec3& second() const {
    const Vec3& best = first();
    const auto isOther = [&](const Vec3& normal) { return std::abs(normal.dot(best)) < kAlike; };
    const std::size_t found = findMost(isOther);
    return isOther(normals_[around_[found]]) && votes_[found] > kSecond * count(best) ? normals_[around_[found]] : best;
  }

 private:
  double count(const Vec3& normal) const {
    double sum = 0.0;
    for (const Index j : around_) sum += std::max(0.0, std::abs(normal.dot(normals_[j])) - kAlike);
    return sum;
  }
  template <class IsWanted>
  std::size_t findMost(const IsWanted& isWanted) const {
    std::size_t found = 0;
    for (std::size_t k = 1; k < around_.size(); ++k) {
      if (!isWanted(normals_[around_[k]])) continue;
      if (votes_[k] > votes_[found] || !isWanted(normals_[around_[found]])) found = k;
    }
    return found;
  }

  const Points& normals_;
  std::vector<Index> around_;  // the point itself first
  std::vector<double> votes_;
};

// on_plane: scratch.
Vec3 fitOnPlane(const Points& positions, const Lists& neighbors, Index i, const Vec3& normal, std::vector<Index>& on_plane) {
  const double most = kOnPlane * findSpacing(positions, neighbors, i);
  on_plane.clear();
  for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j)
    if (std::abs((positions[*j] - positions[i]).dot(normal)) <= most) on_plane.push_back(*j);
  if (on_plane.size() < kFewest) return normal;
  const Plane plane = fitPlane(positions, i, on_plane.data(), on_plane.data() + on_plane.size());
  return plane.width > kLine ? plane.normal : normal;
}

}  // namespace

Index countLinkedUp(const Points& positions, const Points& normals, const Lists& neighbors) {
  checkSizes("countLinkedUp", positions, normals, neighbors);
  std::atomic<Index> count{0};
  parallelFor(neighbors.size(), kBlock, [&](Index begin, Index end) {
    Index found = 0;
    for (Index i = begin; i < end; ++i) {
      const double shortest = kShortest * findSpacing(positions, neighbors, i);
      const Index* last = neighbors.begin(i) + std::min(neighbors.count(i), kAround);
      found += std::any_of(neighbors.begin(i), last, [&](Index j) {
        const Vec3 link = positions[j] - positions[i];
        return link.squaredNorm() >= shortest * shortest && leadsUp(link, normals[i], normals[j]);
      });
    }
    count += found;
  });
  return count;
}

LostPairs countLost(const Points& positions, const Points& normals, const Lists& before, const Lists& after) {
  checkSizes("countLost", positions, normals, before);
  checkSizes("countLost", positions, normals, after);
  LostPairs lost;
  for (Index i = 0; i < before.size(); ++i) {
    const Index* last = before.begin(i) + std::min(before.count(i), kAround);
    for (const Index* j = before.begin(i); j != last; ++j) {
      if (std::find(after.begin(i), after.end(i), *j) != after.end(i)) continue;
      ++(leadsUp(positions[*j] - positions[i], normals[i], normals[*j]) ? lost.up : lost.along);
    }
  }
  return lost;
}

AgreedNormals agreeOnNormals(const Points& positions, const Lists& neighbors, Points normals) {
  checkSizes("agreeOnNormals", positions, normals, neighbors);
  AgreedNormals agreed{std::move(normals), Points(positions.size())};
  Points& next = agreed.at_creases;
  for (int round = 0; round < kRounds; ++round) {
    parallelFor(neighbors.size(), kBlock, [&](Index begin, Index end) {
      std::vector<Index> on_plane;
      for (Index i = begin; i < end; ++i) {
        next[i] = agreed.normals[i];
        if (isCertain(neighbors, agreed.normals, i)) continue;
        next[i] = fitOnPlane(positions, neighbors, i, Vote(neighbors, agreed.normals, i).first(), on_plane);
      }
    });
    std::swap(agreed.normals, next);
  }
  parallelFor(neighbors.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      agreed.at_creases[i] = agreed.normals[i];
      if (isCertain(neighbors, agreed.normals, i)) continue;
      const Vote vote(neighbors, agreed.normals, i);
      const Vec3& second = vote.second();
      if (&second != &vote.first()) agreed.at_creases[i] = second;
    }
  });
  return agreed;
}

}  // namespace deformable_surface::cloud
