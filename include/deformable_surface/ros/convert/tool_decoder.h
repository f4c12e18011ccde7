// Decodes the bytes of a ToolArray. The lengths in a message are checked
// before anything is allocated, which roscpp's own decoder does not do.
#pragma once

#include "deformable_surface/Tool.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// More than scenes use: every tool is tested against every point in every sub-step.
constexpr std::uint32_t kMaxTools = 100;

struct DecodedTools {
  std::vector<Tool> tools;
  std::string problem;  // why there are none; empty: all is well

  bool ok() const { return problem.empty(); }
};

/// Memory is proportional to the bytes. Refuses more than kMaxTools and messages shorter than they claim.
DecodedTools decodeTools(const std::uint8_t* bytes, std::size_t size);

}  // namespace deformable_surface::node
