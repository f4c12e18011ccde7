// The exponential of the anisotropic weighting. Forces and the bounds of their stiffness share it.
#pragma once

#include "deformable_surface/base/simd.h"

namespace deformable_surface::model {

constexpr double kHalfLog2E = 0.5 * 1.4426950408889634;  // e^(x / 2) = 2^(this times x)

// 2^x and 2^y for x, y <= 0, with a relative error of 1.1e-12: four of each at once and, unlike the library's, with the same bits
// on every processor. Both together, since they share their constants. The polynomial of the fractional part of x interpolates
// 2^rest at Chebyshev points; the integer part goes to the exponent's bits. Too small exponents give kLeast.
// Forces are the gradient of the energy up to the slope of that error, about 1e-11; tests allow ten
// thousand times.
DEFORMABLE_SURFACE_INLINE void raiseTwo(Double4& x, Double4& y) {
  using Bits = long long __attribute__((vector_size(4 * sizeof(long long))));
  constexpr double kLeast = -1000.0, kRounder = 6755399441055744.0;  // 1.5 * 2^52: a sum with it ends in the nearest whole number
  constexpr double kEven[] = {0x1.63d136366db24p-20, 0x1.4308ac85aa947p-13, 0x1.3b2ab7181b755p-7, 0x1.ebfbdff823cedp-3, 1.0};
  constexpr double kOdd[] = {0x1.00dc4a532fb8ep-16, 0x1.5d8745a728441p-10, 0x1.c6b08dd6fd234p-5, 0x1.62e42fef84cf0p-1};
  const Double4 least = x - x + kLeast;
  x = x > least ? x : least;
  y = y > least ? y : least;
  const Double4 x_shifted = x + kRounder, y_shifted = y + kRounder;
  x -= x_shifted - kRounder;
  y -= y_shifted - kRounder;
  const Double4 x_square = x * x, y_square = y * y, zero = x - x;
  Double4 x_even = zero + kEven[0], y_even = x_even, x_odd = zero + kOdd[0], y_odd = x_odd;  // short chains instead of long ones
  for (int c = 1; c < 5; ++c) {
    x_even = x_even * x_square + kEven[c];
    y_even = y_even * y_square + kEven[c];
    if (c == 4) break;
    x_odd = x_odd * x_square + kOdd[c];
    y_odd = y_odd * y_square + kOdd[c];
  }
  const Double4 x_sum = x_even + x * x_odd, y_sum = y_even + y * y_odd;
  x = (Double4)((Bits)x_sum + ((Bits)x_shifted << 52));
  y = (Double4)((Bits)y_sum + ((Bits)y_shifted << 52));
}

DEFORMABLE_SURFACE_INLINE void raiseTwo(double& x, double& y) {
  Double4 four_x{x, x, x, x}, four_y{y, y, y, y};
  raiseTwo(four_x, four_y);
  x = four_x[0];
  y = four_y[0];
}

}  // namespace deformable_surface::model
