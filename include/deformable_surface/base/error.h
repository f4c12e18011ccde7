// The two kinds of failure: a caller's mistake, which is an exception that names it, and ours, which is an assertion.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace deformable_surface {

/// Input that cannot be used: one sentence per problem, each naming what was found and what is accepted. Characters of the input
/// that a terminal would obey are shown as in toPrintable().
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::string problem) : InputError(std::vector<std::string>{std::move(problem)}) {}
  explicit InputError(std::vector<std::string> problems)
      : std::runtime_error(joinLines(problems)), problems_(std::move(problems)) {}

  const std::vector<std::string>& problems() const { return problems_; }

 private:
  static std::string joinLines(std::vector<std::string>& lines);  // which become printable

  std::vector<std::string> problems_;
};

}  // namespace deformable_surface
