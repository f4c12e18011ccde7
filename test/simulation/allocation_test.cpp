// A step allocates nothing after the first, also while the surface changes so much that the stable step is measured again; nor does
// the surface after it was asked for once.
#include "clouds.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> num_allocations{0};
}

void* operator new(std::size_t size) {
  ++num_allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace deformable_surface::test {
namespace {

TEST(Allocation, NoStepAllocatesAfterTheFirst) {
  for (solve::IntegratorType type : {solve::IntegratorType::kAuto, solve::IntegratorType::kVerlet, solve::IntegratorType::kSymplecticEuler}) {
    simulation::SceneParams p = hangingSheet();
    p.integrator.type = type;
    p.pressure = 1.0;
    p.viscous_drag = 0.5;
    p.material.spring_damping = 1e-4;
    p.forces.push_back({"pull", Vec3(1.0, 0.0, 0.0), Vec3(30.0, 0.0, 0.0), 0.5, 0.0, 1e300});
    simulation::Simulation s(p, sheetCloud());
    run(s, 1);
    s.surface(true);
    const long before = num_allocations;
    bool sound = true;
    for (int k = 0; k < 60; ++k) {
      sound = sound && s.step().ok;
      s.surface(true);
    }
    const long after = num_allocations;
    EXPECT_TRUE(sound);
    // The scene has stretched far enough for several new measurements of the stable step.
    EXPECT_GT(s.statistics().max_stretch, 0.2);
    EXPECT_EQ(after - before, 0) << static_cast<int>(type);
  }
}

}  // namespace
}  // namespace deformable_surface::test
