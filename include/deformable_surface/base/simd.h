// Wider vector instructions where the processor has them, chosen at run time: the project is built for the oldest processor of
// the family, so that its types fit those of the installed libraries. Without fused multiply-add the bits are the same.
#pragma once

#include <cmath>

// The sanitizers cannot run the functions that choose at start-up.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Put before a function with loops over plain arrays: it is compiled twice, and the right version is chosen at run time.
#define DEFORMABLE_SURFACE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define DEFORMABLE_SURFACE_WIDE
#endif

/// Helpers of such functions must be inlined into them. They take vectors by reference: by value, vectors have another binary
/// interface with and without the wider instructions.
#define DEFORMABLE_SURFACE_INLINE inline __attribute__((always_inline))

namespace deformable_surface {

/// Four numbers side by side: four elements that are computed at once, or a point and a fourth number.
using Double4 = double __attribute__((vector_size(4 * sizeof(double))));

namespace internal {
/// The same at any address of numbers.
using Unaligned4 = double __attribute__((vector_size(4 * sizeof(double)), aligned(alignof(double)), may_alias));
}  // namespace internal

DEFORMABLE_SURFACE_INLINE void load(const double* from, Double4& to) {
  to = *reinterpret_cast<const internal::Unaligned4*>(from);
}
DEFORMABLE_SURFACE_INLINE void store(const Double4& from, double* to) { *reinterpret_cast<internal::Unaligned4*>(to) = from; }

/// Elements of two vectors, by their places in both together; g++ before 12 and clang have no builtin in common.
template <int... kPlaces, class Vector>
DEFORMABLE_SURFACE_INLINE void pick(const Vector& a, const Vector& b, Vector& to) {
#ifdef __clang__
  to = __builtin_shufflevector(a, b, kPlaces...);
#else
  using Places = decltype(a < b);  // integers of the same size
  to = __builtin_shuffle(a, b, Places{kPlaces...});
#endif
}

/// Rows become columns.
DEFORMABLE_SURFACE_INLINE void transpose(Double4& a, Double4& b, Double4& c, Double4& d) {
  Double4 ab_even, ab_odd, cd_even, cd_odd;
  pick<0, 4, 2, 6>(a, b, ab_even);
  pick<1, 5, 3, 7>(a, b, ab_odd);
  pick<0, 4, 2, 6>(c, d, cd_even);
  pick<1, 5, 3, 7>(c, d, cd_odd);
  pick<0, 1, 4, 5>(ab_even, cd_even, a);
  pick<0, 1, 4, 5>(ab_odd, cd_odd, b);
  pick<2, 3, 6, 7>(ab_even, cd_even, c);
  pick<2, 3, 6, 7>(ab_odd, cd_odd, d);
}

/// Square roots in place.
DEFORMABLE_SURFACE_INLINE void takeRoots(Double4& x) {
  x = Double4{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}

}  // namespace deformable_surface
