#include "deformable_surface/linear/fill_reducing_order.h"

#include "deformable_surface/base/interrupt.h"

#include <Eigen/OrderingMethods>

#include <chrono>
#include <future>
#include <list>
#include <mutex>
#include <thread>
#include <utility>

namespace deformable_surface {
namespace {

constexpr Index kMany = 2000;  // rows: fewer take some ten milliseconds at most
constexpr std::chrono::milliseconds kLook(10), kNoWait(0);
constexpr std::size_t kMostLeft = 2;  // orderings that nobody waits for, each with a thread and a copy of the matrix

std::vector<Index> order(const Eigen::SparseMatrix<double>& lower) {
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), permutation);
  return {permutation.indices().data(), permutation.indices().data() + permutation.size()};
}

using Result = std::future<std::vector<Index>>;

// Orderings that go on after an interrupt, in their own threads. Nobody waits for them but the end of the program, or of the
// plugin that this library was loaded with: their code must not go before them.
class LeftOrderings {
 public:
  // std::async()'s futures wait when they are destroyed.
  void add(Result result) {
    const std::lock_guard<std::mutex> lock(mutex_);
    results_.push_back(std::move(result));
  }
  // Those that have ended are forgotten.
  std::size_t count() {
    const std::lock_guard<std::mutex> lock(mutex_);
    results_.remove_if([](const Result& result) { return result.wait_for(kNoWait) == std::future_status::ready; });
    return results_.size();
  }

 private:
  std::mutex mutex_;
  std::list<Result> results_;
};

}  // namespace

// Eigen's ordering cannot be interrupted. After an interrupt nobody waits for it: it ends in its own thread.
std::vector<Index> findFillReducingOrder(Eigen::SparseMatrix<double> lower) {
  if (!currentInterrupt() || lower.rows() < kMany) return order(lower);
  static LeftOrderings left;
  endIfInterrupted();
  while (left.count() >= kMostLeft) {
    std::this_thread::sleep_for(kLook);
    endIfInterrupted();
  }
  Result result = std::async(std::launch::async, [matrix = std::move(lower)] { return order(matrix); });
  try {
    while (result.wait_for(kLook) != std::future_status::ready) endIfInterrupted();
  } catch (const Interrupted&) {
    left.add(std::move(result));
    throw;
  }
  return result.get();
}

}  // namespace deformable_surface
