#include "heap_counter.h"

#include <malloc.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <fstream>

namespace {

std::atomic<bool> counting{false};
std::atomic<std::int64_t> num_allocations{0}, live_bytes{0}, peak_bytes{0};

void* countBlock(void* block) {
  if (block == nullptr || !counting.load(std::memory_order_relaxed)) return block;
  num_allocations.fetch_add(1, std::memory_order_relaxed);
  const std::int64_t size = static_cast<std::int64_t>(malloc_usable_size(block));
  const std::int64_t live = live_bytes.fetch_add(size, std::memory_order_relaxed) + size;
  std::int64_t peak = peak_bytes.load(std::memory_order_relaxed);
  while (live > peak && !peak_bytes.compare_exchange_weak(peak, live, std::memory_order_relaxed)) {}
  return block;
}

void discountBlock(void* block) {
  if (block == nullptr || !counting.load(std::memory_order_relaxed)) return;
  live_bytes.fetch_sub(static_cast<std::int64_t>(malloc_usable_size(block)), std::memory_order_relaxed);
}

}  // namespace

// The allocator's entry points, under the second names that the GNU C library gives them. operator new ends here as well.
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) noexcept { return countBlock(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) noexcept { return countBlock(__libc_calloc(count, size)); }
void* memalign(std::size_t alignment, std::size_t size) noexcept { return countBlock(__libc_memalign(alignment, size)); }
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept { return countBlock(__libc_memalign(alignment, size)); }

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  void* const found = __libc_memalign(alignment, size);
  if (found == nullptr) return ENOMEM;
  *block = countBlock(found);
  return 0;
}

void* realloc(void* block, std::size_t size) noexcept {
  discountBlock(block);
  return countBlock(__libc_realloc(block, size));
}

void free(void* block) noexcept {
  discountBlock(block);
  __libc_free(block);
}

}  // extern "C"

namespace deformable_surface::benchmark {

HeapCounter::HeapCounter() {
  num_allocations = 0;
  live_bytes = 0;
  peak_bytes = 0;
  counting = true;
}

void HeapCounter::stop() { counting = false; }
std::int64_t HeapCounter::allocations() const { return num_allocations; }
std::int64_t HeapCounter::liveBytes() const { return live_bytes; }
std::int64_t HeapCounter::peakBytes() const { return peak_bytes; }
void HeapCounter::resetPeak() { peak_bytes = live_bytes.load(); }

std::int64_t residentBytes() {
  malloc_trim(0);
  std::int64_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

}  // namespace deformable_surface::benchmark
