#include "accuracy_memory.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/read_number.h"
#include "deformable_surface/simulation/scene_params.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <locale>
#include <sstream>
#include <utility>
#include <vector>

#include "state_hash.h"

namespace deformable_surface::simulation {
namespace {

namespace fs = std::filesystem;

const char* const kPrefix = "choice_";                         // of the names of files
const char* const kFirstLine = "deformable_surface choice 3";  // name and version of the format

std::string readVariable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

std::uint64_t hashText(const std::string& text, std::uint64_t h = kHashBegin) {
  for (const unsigned char c : text) h = mixHash(h, c);
  return h;
}

std::string toHexadecimal(std::uint64_t h) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::hex << std::setw(16) << std::setfill('0') << h;
  return text.str();
}

// The program or library that this function is part of, by its path, size and date: another build may choose otherwise.
std::uint64_t identifyBuild() {
  const auto here = reinterpret_cast<std::uintptr_t>(&identifyBuild);
  std::uint64_t h = kHashBegin;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::istringstream words(line);
    std::uintptr_t begin = 0, end = 0;
    char dash = 0;
    words >> std::hex >> begin >> dash >> end;
    if (here < begin || here >= end || line.find('/') == std::string::npos) continue;
    const fs::path file = line.substr(line.find('/'));
    std::error_code error;
    h = hashText(file.string(), h);
    h = mixHash(h, static_cast<std::uint64_t>(fs::file_size(file, error)));
    if (error) return 0;  // replaced while it runs
    h = mixHash(h, static_cast<std::uint64_t>(fs::last_write_time(file, error).time_since_epoch().count()));
    return error ? 0 : h;
  }
  return 0;  // not known
}

// Hexadecimal, so that all bits return.
void writeNumber(std::ostream& out, double value) { out << std::hexfloat << value << ' '; }

bool readNumber(std::istream& in, double& value) {
  std::string text;
  if (!(in >> text)) return false;
  const char* end = nullptr;
  value = deformable_surface::readNumber(text.c_str(), &end);
  return *end == '\0';
}

bool readType(std::istream& in, solve::IntegratorType& type) {
  int number = 0;
  if (!(in >> number) || number < 0 || number > static_cast<int>(solve::IntegratorType::kStatic)) return false;
  type = static_cast<solve::IntegratorType>(number);
  return true;
}

// Errors are ignored: another process may do the same at the same time.
void removeOldest(const fs::path& folder, std::size_t most) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator(); it.increment(error)) {
    if (it->path().filename().string().rfind(kPrefix, 0) != 0) continue;
    std::error_code gone;
    const fs::file_time_type used = fs::last_write_time(it->path(), gone);
    if (!gone) files.emplace_back(used, it->path());
  }
  if (files.size() <= most) return;
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < files.size() - most; ++i) fs::remove(files[i].second, error);
}

void write(std::ostream& out, const AccuracyChoice::Candidate& c) {
  out << c.points << ' ' << static_cast<int>(c.integrator) << ' ' << c.may_buckle << ' ' << c.is_bounded << ' ';
  for (const double value : {c.error, c.step_time, c.membrane_share, c.work}) writeNumber(out, value);
  out << '\n';
}

bool read(std::istream& in, AccuracyChoice::Candidate& c) {
  return in >> c.points && readType(in, c.integrator) && in >> c.may_buckle >> c.is_bounded && readNumber(in, c.error) &&
         readNumber(in, c.step_time) && readNumber(in, c.membrane_share) && readNumber(in, c.work);
}

void write(std::ostream& out, const AccuracyChoice& c) {
  out << kFirstLine << '\n' << c.is_met << ' ' << c.may_buckle << ' ' << c.points << ' ' << static_cast<int>(c.integrator) << ' ';
  for (const double value : {c.membrane_share, c.error, c.work}) writeNumber(out, value);
  out << '\n' << c.softening.size() << ' ';
  for (const double value : c.softening) writeNumber(out, value);
  out << '\n' << c.candidates.size() << '\n';
  for (const AccuracyChoice::Candidate& candidate : c.candidates) write(out, candidate);
  out << c.why_integrator << '\n' << c.sentence << '\n';
}

bool read(std::istream& in, AccuracyChoice& c) {
  std::string line;
  std::size_t count = 0;
  if (!std::getline(in, line) || line != kFirstLine) return false;
  if (!(in >> c.is_met >> c.may_buckle >> c.points) || !readType(in, c.integrator)) return false;
  for (double* value : {&c.membrane_share, &c.error, &c.work})
    if (!readNumber(in, *value)) return false;
  if (!(in >> count)) return false;
  for (std::size_t i = 0; i < count; ++i) {
    double value = 0.0;
    if (!readNumber(in, value)) return false;
    c.softening.push_back(value);
  }
  if (!(in >> count)) return false;
  for (std::size_t i = 0; i < count; ++i) {
    AccuracyChoice::Candidate candidate;
    if (!read(in, candidate)) return false;
    c.candidates.push_back(candidate);
  }
  in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  return std::getline(in, c.why_integrator) && std::getline(in, c.sentence);
}

}  // namespace

std::string findCacheFolder() {
  if (std::getenv("DEFORMABLE_SURFACE_CACHE")) return readVariable("DEFORMABLE_SURFACE_CACHE");
  const std::string cache = readVariable("XDG_CACHE_HOME"), home = readVariable("HOME");
  if (!cache.empty()) return cache + "/deformable_surface";
  return home.empty() ? "" : home + "/.cache/deformable_surface";
}

ChoiceMemory::ChoiceMemory(const SceneParams& params, const RestSurface& full) {
  const std::string folder = findCacheFolder();
  const std::uint64_t build = identifyBuild();
  if (!params.accuracy.remember || folder.empty() || build == 0) return;
  SceneParams scene = params;
  scene.cloud = CloudParams();
  scene.threads = 0;
  scene.save_directory.clear();
  scene.accuracy.patience = AccuracyParams().patience;
  scene.expect.clear();
  std::uint64_t h = hashText(toYaml(printParams(scene)), build);
  h = hashPoints(full.dense.normals, hashPoints(full.dense.positions, h));
  path_ = folder + "/" + kPrefix + toHexadecimal(h);
}

// The file is the choice, and in its last line a hash of what is before it: a file that was cut short or changed is not read.
bool ChoiceMemory::recall(AccuracyChoice& choice) const {
  if (path_.empty()) return false;
  std::ostringstream all;
  all << std::ifstream(path_).rdbuf();
  const std::string text = all.str();
  constexpr std::size_t kHashLine = 17;
  if (text.size() < kHashLine) return false;
  const std::string body = text.substr(0, text.size() - kHashLine);
  std::istringstream file(body);
  file.imbue(std::locale::classic());
  AccuracyChoice kept;
  if (text.substr(body.size()) != toHexadecimal(hashText(body)) + "\n" || !read(file, kept)) return false;
  // What is used stays; a folder that cannot be written to is read all the same.
  std::error_code error;
  fs::last_write_time(path_, fs::file_time_type::clock::now(), error);
  kept.is_asked = choice.is_asked;
  choice = std::move(kept);
  return true;
}

// First under a name of its own, so that nobody reads half of it.
bool ChoiceMemory::keep(const AccuracyChoice& choice) const {
  std::error_code error;
  fs::create_directories(fs::path(path_).parent_path(), error);
  std::ostringstream body;
  body.imbue(std::locale::classic());
  write(body, choice);
  std::string beside = path_ + ".XXXXXX";
  const int made = ::mkstemp(beside.data());
  if (made < 0) return false;
  ::close(made);
  std::ofstream file(beside);
  file << body.str() << toHexadecimal(hashText(body.str())) << '\n';
  file.close();
  if (file) fs::rename(beside, path_, error);
  if (file && !error) {
    removeOldest(fs::path(path_).parent_path(), kMostKeptChoices);
    return true;
  }
  fs::remove(beside, error);
  return false;
}

}  // namespace deformable_surface::simulation
