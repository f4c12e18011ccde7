#include "deformable_surface/linear/fill_reducing_order.h"

#include "deformable_surface/base/interrupt.h"

#include <Eigen/OrderingMethods>

#include <chrono>
#include <future>
#include <memory>
#include <thread>

namespace deformable_surface {
namespace {

constexpr Index kMany = 2000;  // rows: fewer take some ten milliseconds at most
constexpr std::chrono::milliseconds kLook(10);

std::vector<Index> order(const Eigen::SparseMatrix<double>& lower) {
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), permutation);
  return {permutation.indices().data(), permutation.indices().data() + permutation.size()};
}

}  // namespace

// Eigen's ordering cannot be interrupted. After an interrupt nobody waits for it: it ends in its own thread.
std::vector<Index> findFillReducingOrder(Eigen::SparseMatrix<double> lower) {
  const std::atomic<bool>* const interrupt = currentInterrupt();
  if (!interrupt || lower.rows() < kMany) return order(lower);
  using Task = std::packaged_task<std::vector<Index>()>;
  const auto task = std::make_shared<Task>([matrix = std::move(lower)] { return order(matrix); });
  std::future<std::vector<Index>> result = task->get_future();
  std::thread([task] { (*task)(); }).detach();
  do {
    if (*interrupt) throw Interrupted();
  } while (result.wait_for(kLook) != std::future_status::ready);
  return result.get();
}

}  // namespace deformable_surface
