// Times are sums of decimal fractions such as the step of 0.01 s, and come out a little early or late.
#pragma once

namespace deformable_surface {

/// Of a step: times that are nearer to each other are the same.
constexpr double kTimeRounding = 1e-6;

}  // namespace deformable_surface
