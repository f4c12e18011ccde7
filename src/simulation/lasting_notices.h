// How often a user is told of one thing. What lasts, as a jam does, is told when it begins and when it has ended, and a scene
// with much to tell has a few lines in a second all the same. All notices of steps pass through here.
#pragma once

#include "deformable_surface/base/types.h"

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace deformable_surface::simulation {

/// What can be so in many steps in a row.
enum class Lasting {
  kStopped,     // contact limited the motion of points
  kHalted,      // contact took all motion from the parts that it stopped
  kRetried,     // steps were not sound at first, and were taken again
  kUnbalanced,  // the solver ended with forces unbalanced
  kUntracked,   // the tracked cloud shows few of the points that it has shown before
  kStretched    // the surface or body is stretched beyond its material law
};
constexpr int kNumLasting = 6;

class LastingNotices {
 public:
  /// The step is one in which this is so. size: how much of it (points, a share of forces, a stretch), of which the largest is
  /// told in the end; 0: it has no size. matters: to the user. What never did is not told. Returns whether it begins to be told,
  /// which the caller then puts into words.
  bool see(Lasting what, double size = 0.0, bool matters = true);
  /// Ends a step from time to time + step, s: told is what there is to say of it so far. Returns what is to be said, with what
  /// has ended because it was not seen for a while (is_static: in this step).
  std::string endStep(double time, double step, bool is_static, const std::string& told);
  /// What a run that ends now must still say: of what was not seen to end, and what was put off.
  std::string endRun() const;
  void clear() { *this = LastingNotices(); }

 private:
  struct Span {
    bool is_on = false, is_in_step = false, is_told = false;
    double begin = 0.0, end = 0.0;     // s, of the first and the last step in which it was so
    std::uint64_t seen = 0;            // such steps
    std::uint64_t steps = 0, all = 0;  // steps from the first to the last one, and to now
    double largest = 0.0;              // size
  };
  struct PutOff {
    std::string notice;  // the last one
    int count = 0;
  };

  static std::string describe(Lasting what, const Span& span);
  std::string limit(double time, const std::string& notice);
  std::string describePutOff() const;

  std::array<Span, kNumLasting> spans_;
  std::set<std::string> told_;             // causes, in the period that runs
  std::map<std::string, PutOff> put_off_;  // by cause
  int lines_ = 0;                          // told in the period that runs
  double period_begin_ = 0.0;              // s
};

}  // namespace deformable_surface::simulation
