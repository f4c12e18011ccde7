// The head of a point file and the counts in it.
#include "point_files_read.h"

#include "deformable_surface/base/value.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

namespace deformable_surface::io {

namespace {

// Headers of real files end within a few kilobytes.
constexpr std::size_t kMaxHeader = std::size_t{1} << 16;

std::vector<std::string> splitWords(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

Head readHead(const std::string& file, const std::string& last_word) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse(file, std::string("cannot be opened: ") + std::strerror(errno));
  std::string head(kMaxHeader, '\0');
  stream.read(&head[0], static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  if (head.empty()) refuse(file, "found no bytes to read; accepted: a point file");
  Head result;
  stream.clear();
  stream.seekg(0, std::ios::end);
  result.file_bytes = static_cast<std::uint64_t>(stream.tellg());

  for (std::size_t begin = 0; begin < head.size();) {
    const std::size_t end = head.find('\n', begin);
    if (end == std::string::npos) break;
    result.lines.push_back(splitWords(head.substr(begin, end - begin)));
    begin = end + 1;
    if (!result.lines.back().empty() && result.lines.back()[0] == last_word) {
      result.header_bytes = begin;
      return result;
    }
  }
  refuse(file, "found no line " + quote(last_word) + " in the first " + std::to_string(kMaxHeader) +
                   " bytes; accepted: a complete header");
}

std::uint64_t toCount(const std::string& file, const std::string& word) {
  const Value value = parseNumber(word);
  if (!value.asInteger() || *value.asInteger() < 0 || *value.asInteger() > std::numeric_limits<std::uint32_t>::max()) {
    refuse(file, "found " + quote(word) + " as a count in the header; accepted: an integer from 0 to 2^32 - 1");
  }
  return static_cast<std::uint64_t>(*value.asInteger());
}

void checkCounts(const std::string& file, std::uint64_t points, std::uint64_t body_bytes, std::uint64_t needed_bytes,
                 Index max_points) {
  if (points == 0) refuse(file, "found no points; accepted: at least one");
  if (points > static_cast<std::uint64_t>(max_points)) {
    refuse(file, "found " + std::to_string(points) + " points; accepted: at most " + std::to_string(max_points));
  }
  if (needed_bytes > body_bytes) {
    refuse(file, "found " + std::to_string(body_bytes) + " bytes behind the header, but " + std::to_string(points) +
                     " points need at least " + std::to_string(needed_bytes) + "; accepted: a complete file");
  }
}

}  // namespace deformable_surface::io
