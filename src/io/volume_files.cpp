#include "deformable_surface/io/volume_files.h"

#include "deformable_surface/base/value.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "point_files_common.h"

namespace deformable_surface::io {
namespace {

constexpr std::size_t kMaxLine = 10000, kMaxLines = 1000;  // real headers have some dozens of short lines

/// The header: what stands behind the first " = " of each line, up to the line ElementDataFile.
class Header {
 public:
  Header(std::istream& in, const std::string& file) : file_(file) {
    std::string line;
    for (std::size_t count = 0; count < kMaxLines && entries_.count("ElementDataFile") == 0; ++count) {
      line.clear();
      for (char c; line.size() < kMaxLine && in.get(c) && c != '\n';) line += c;
      const std::size_t equals = line.find('=');
      if (equals == std::string::npos || line.size() == kMaxLine) break;
      entries_[trim(line.substr(0, equals))] = trim(line.substr(equals + 1));
    }
    if (entries_.count("ElementDataFile") == 0)
      refuse(file_, "found no line 'ElementDataFile = LOCAL' at the end of a header; accepted: a MetaImage file");
  }

  /// The entry of the first of these names that there is.
  std::string find(const std::vector<const char*>& names, const std::string& otherwise) const {
    for (const char* name : names)
      if (const auto entry = entries_.find(name); entry != entries_.end()) return entry->second;
    return otherwise;
  }
  void require(const std::vector<const char*>& names, const std::string& accepted, const std::string& hint) const {
    const std::string found = find(names, accepted);
    if (found != accepted) refuse(file_, std::string(names[0]) + ": found " + quote(found) + "; accepted: " + accepted + hint);
  }
  std::vector<double> numbers(const std::vector<const char*>& names, const std::string& otherwise, std::size_t count) const {
    const std::string text = find(names, otherwise);
    std::istringstream words(text);
    std::vector<double> found;
    for (std::string word; words >> word;) {
      const Value value = parseNumber(word);
      const double number = value.asReal() ? *value.asReal() : value.asInteger() ? static_cast<double>(*value.asInteger()) : NAN;
      if (std::isfinite(number)) found.push_back(number);
    }
    if (found.size() != count)
      refuse(file_, std::string(names[0]) + ": found " + quote(text) + "; accepted: " + std::to_string(count) + " numbers");
    return found;
  }

 private:
  static std::string trim(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
  }

  const std::string& file_;
  std::map<std::string, std::string> entries_;
};

template <class T>
std::vector<float> toFloats(const std::vector<char>& bytes) {
  std::vector<float> values(bytes.size() / sizeof(T));
  for (std::size_t i = 0; i < values.size(); ++i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    values[i] = static_cast<float>(value);
  }
  return values;
}

struct ElementType {
  const char* name;
  std::size_t size;
  std::vector<float> (*read)(const std::vector<char>&);
};
const ElementType kTypes[] = {{"MET_UCHAR", 1, toFloats<std::uint8_t>},   {"MET_CHAR", 1, toFloats<std::int8_t>},
                              {"MET_USHORT", 2, toFloats<std::uint16_t>}, {"MET_SHORT", 2, toFloats<std::int16_t>},
                              {"MET_UINT", 4, toFloats<std::uint32_t>},   {"MET_INT", 4, toFloats<std::int32_t>},
                              {"MET_FLOAT", 4, toFloats<float>},          {"MET_DOUBLE", 8, toFloats<double>}};

}  // namespace

geometry::Volume readVolumeFile(const std::string& file, double scale, const FindPackage& find_package) {
  const std::string path = findPointFile(file, find_package);
  if (toLowerExtension(path) != ".mha") refuse(file, "found the extension " + quote(toLowerExtension(path)) + "; accepted: .mha");
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) refuse(file, "found no file that can be read; accepted: a MetaImage file");
  const Header header(in, file);
  header.require({"NDims"}, "3", "");
  header.require({"ElementDataFile"}, "LOCAL", ", with the samples in the same file");
  header.require({"CompressedData"}, "False", " (SimpleITK: WriteImage with useCompression=False)");
  header.require({"BinaryData"}, "True", "");
  header.require({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}, "False", "");
  header.require({"ElementNumberOfChannels"}, "1", "");
  const std::string type_name = header.find({"ElementType"}, "");
  const ElementType* type = nullptr;
  std::string accepted;
  for (const ElementType& known : kTypes) {
    if (type_name == known.name) type = &known;
    accepted += (accepted.empty() ? "" : ", ") + std::string(known.name);
  }
  if (!type) refuse(file, "ElementType: found " + quote(type_name) + "; accepted: " + accepted);

  const std::vector<double> counts = header.numbers({"DimSize"}, "", 3);
  std::array<Index, 3> size;
  double samples = 1.0;
  for (int k = 0; k < 3; ++k) {
    samples *= counts[k];
    if (!(counts[k] >= 2.0 && counts[k] == std::floor(counts[k]) && samples <= static_cast<double>(bytes)))
      refuse(file, "DimSize: found " + quote(header.find({"DimSize"}, "")) +
                       "; accepted: three whole numbers, each two or more, with no more samples than the file has bytes");
    size[k] = static_cast<Index>(counts[k]);
  }
  const std::uint64_t body = bytes - static_cast<std::uint64_t>(in.tellg());
  const std::uint64_t needed = static_cast<std::uint64_t>(samples) * type->size;
  if (body != needed)
    refuse(file, "found " + std::to_string(body) + " bytes behind the header; accepted: " + std::to_string(needed) +
                     ", as DimSize and ElementType state");
  std::vector<char> data(needed);
  if (!in.read(data.data(), static_cast<std::streamsize>(needed))) refuse(file, "found samples that cannot be read");

  const std::vector<double> spacing = header.numbers({"ElementSpacing", "ElementSize"}, "1 1 1", 3);
  const std::vector<double> offset = header.numbers({"Offset", "Position", "Origin"}, "0 0 0", 3);
  const std::vector<double> directions = header.numbers({"TransformMatrix", "Rotation", "Orientation"}, "1 0 0 0 1 0 0 0 1", 9);
  Mat3 axes;  // the directions are written one axis after the other
  for (int k = 0; k < 3; ++k)
    axes.col(k) = scale * spacing[k] * Vec3(directions[3 * k], directions[3 * k + 1], directions[3 * k + 2]);
  try {
    return {size, scale * Vec3(offset[0], offset[1], offset[2]), axes, type->read(data)};
  } catch (const InputError& problem) {
    refuse(file, problem.what());
  }
}

void readGuide(model::GuideParams& guide, const FindPackage& find_package) {
  if (guide.volume.empty()) return;
  guide.grid = std::make_shared<const geometry::Volume>(readVolumeFile(guide.volume, guide.scale, find_package));
  if (!(guide.iso_value > guide.grid->least() && guide.iso_value < guide.grid->largest()))
    throw InputError("oriented_particles.guide.iso_value: found " + formatReal(guide.iso_value) + "; accepted: above " +
                     formatReal(guide.grid->least()) + " and below " + formatReal(guide.grid->largest()) + ", the values in " +
                     quote(guide.volume));
}

}  // namespace deformable_surface::io
