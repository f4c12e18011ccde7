#include "report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace deformable_surface::benchmark {
namespace {

std::string format(const char* how, double value) {
  char text[64];
  std::snprintf(text, sizeof text, how, value);
  return text;
}

}  // namespace

void Report::begin(const std::string& file, const std::string& title, std::vector<std::string> columns) {
  file_ = file;
  std::printf("\n%s\n", title.c_str());
  rows_.assign(1, std::move(columns));
}

void Report::add(std::vector<std::string> cells) {
  if (cells.size() != rows_.front().size()) throw std::logic_error("table " + file_ + ": a row does not fit its columns");
  rows_.push_back(std::move(cells));
}

void Report::end() {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  std::ofstream csv(folder_ + "/" + file_ + ".csv");
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      std::printf(c == 0 ? "  %-*s" : "  %*s", static_cast<int>(widths[c]), row[c].c_str());
      csv << (c == 0 ? "" : ",") << (row[c].find(',') == std::string::npos ? row[c] : '"' + row[c] + '"');
    }
    std::printf("\n");
    csv << '\n';
  }
  std::fflush(stdout);
  csv.close();
  if (!csv) throw std::runtime_error("cannot write " + folder_ + "/" + file_ + ".csv");
}

void Report::note(const std::string& line) { std::printf("  %s\n", line.c_str()); }

std::string show(double value) { return format("%.3g", value); }
std::string showPercent(double share) { return format("%.1f", 100.0 * share); }
std::string showMilliseconds(double seconds) { return format("%.4g", 1e3 * seconds); }

std::string showHash(std::uint64_t hash) {
  char text[32];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace deformable_surface::benchmark
