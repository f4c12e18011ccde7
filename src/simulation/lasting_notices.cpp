#include "lasting_notices.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stretch_watch.h"

namespace deformable_surface::simulation {
namespace {

// s of simulated time. Jams tremble: what is not seen for less than this has not ended.
constexpr double kQuiet = 1.0;
constexpr double kPeriod = 1.0;         // s of simulated time, in which at most kMostLines are told and each cause once
constexpr int kMostLines = 4;           // so many can be read while a scene runs in real time
constexpr std::size_t kMostCauses = 8;  // that are put off with their words; the others are counted as one

}  // namespace

bool LastingNotices::see(Lasting what, double size, bool matters) {
  Span& span = spans_[static_cast<int>(what)];
  if (!span.is_on) span = Span();
  span.is_on = span.is_in_step = true;
  span.largest = std::max(span.largest, size);
  return matters && !std::exchange(span.is_told, true);
}

std::string LastingNotices::endStep(double time, double step, bool is_static, const std::string& told) {
  std::string notice = told;
  for (int k = 0; k < kNumLasting; ++k) {
    Span& span = spans_[k];
    if (!span.is_on) continue;
    ++span.all;
    if (span.is_in_step) {
      if (span.seen == 0) span.begin = time;
      span.end = time + step;
      ++span.seen;
      span.steps = span.all;
      span.is_in_step = false;
    } else if (is_static || time + step - span.end >= kQuiet) {
      if (span.is_told)
        appendNotice(notice, describe(static_cast<Lasting>(k), span) +
                                 (is_static ? "; in this step no longer" : "; none in the last " + formatShort(kQuiet) + " s"));
      span = Span();
    }
  }
  return limit(time + step, notice);
}

std::string LastingNotices::describe(Lasting what, const Span& span) {
  const std::string where = std::to_string(span.seen) + " of " + std::to_string(span.steps) + " steps, from " +
                            formatShort(span.begin) + " to " + formatShort(span.end) + " s";
  switch (what) {
    case Lasting::kStopped:
      return "contact limited the motion of points in " + where + ", at most " + formatShort(span.largest) + " in a step";
    case Lasting::kHalted: return "contact took all motion from the parts that it stopped in " + where;
    case Lasting::kRetried: return "steps failed at first and were repeated: " + where;
    case Lasting::kUnbalanced:
      return "forces were left unbalanced in " + where + ", at most " + formatShort(span.largest) + " of the largest force";
    case Lasting::kUntracked: return "less than half of the points that were tracked before were tracked in " + where;
    case Lasting::kStretched:
      return "the largest stretch was above " + formatShort(100.0 * StretchWatch::kMost) + " % in " + where + ", at most " +
             std::to_string(std::llround(100.0 * span.largest)) + " %";
  }
  return "";
}

// A notice that is one too many, or like one told a short while ago, is put off to the end of the period.
std::string LastingNotices::limit(double time, const std::string& notice) {
  std::string line;
  if (time - period_begin_ >= kPeriod) {
    line = describePutOff();
    period_begin_ = time;
    lines_ = line.empty() ? 0 : 1;
    told_.clear();
    put_off_.clear();
  }
  if (notice.empty()) return line;
  const std::string cause = withoutNumbers(notice);
  const bool is_new = told_.count(cause) == 0;
  if (is_new && (lines_ < kMostLines || !line.empty())) {
    if (line.empty()) ++lines_;
    told_.insert(cause);
    appendNotice(line, notice);
    return line;
  }
  PutOff& put_off = put_off_[put_off_.count(cause) > 0 || put_off_.size() < kMostCauses ? cause : ""];
  put_off.notice = notice;
  ++put_off.count;
  return line;
}

std::string LastingNotices::describePutOff() const {
  std::string line;
  for (const auto& [cause, put_off] : put_off_)
    appendNotice(line,
                 (put_off.count > 1 ? std::to_string(put_off.count) + (cause.empty() ? " others, the last: " : " times: ") : "") +
                     put_off.notice);
  return line.empty() ? "" : "since the last notice: " + line;
}

std::string LastingNotices::endRun() const {
  std::string line = describePutOff();
  for (int k = 0; k < kNumLasting; ++k)
    if (spans_[k].is_on && spans_[k].is_told) appendNotice(line, describe(static_cast<Lasting>(k), spans_[k]));
  return line;
}

}  // namespace deformable_surface::simulation
