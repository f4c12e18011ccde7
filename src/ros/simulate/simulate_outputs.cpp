#include "simulate_outputs.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/ros/convert/contacts.h"
#include "deformable_surface/ros/convert/tool_wrenches.h"

#include <ros/time.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <regex>

namespace deformable_surface::node {
namespace {

[[noreturn]] void refuseFile(const std::string& file) {
  throw InputError(file + ": cannot be written; accepted: a file in a folder that can be written, with room on the disk");
}

// A field of a CSV file (RFC 4180).
std::string quoteCsv(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string nameStatistics() {
  std::string header;
  simulation::visitFields({}, [&](const std::string& name, const auto&) { header += (header.empty() ? "" : ",") + name; });
  return header;
}

}  // namespace

std::string formatExactly(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

bool Pace::isDue(double time) {
  if (time + tolerance_ < static_cast<double>(count_) / rate_) return false;
  // Outputs that fall into one step are merged.
  while (static_cast<double>(count_) / rate_ <= time + tolerance_) ++count_;
  return true;
}

CsvFile::CsvFile(const std::string& file, const std::string& header) : name_(file), file_(file), stream_(file_.temporary()) {
  add(header);
}

void CsvFile::add(const std::string& line) {
  stream_ << line << '\n' << std::flush;
  check();
}

void CsvFile::finish() {
  stream_.close();
  check();
  file_.keep();
}

void CsvFile::check() const {
  if (!stream_) refuseFile(name_);
}

StatisticsFile::StatisticsFile(const std::string& file) : file_(file, nameStatistics()) {}

void StatisticsFile::add(const simulation::Statistics& statistics) {
  std::string row;
  simulation::visitFields(statistics, [&](const std::string&, const auto& value) {
    using Field = std::decay_t<decltype(value)>;
    if (!row.empty()) row += ',';
    if constexpr (std::is_same<Field, double>::value) {
      row += formatExactly(value);
    } else if constexpr (std::is_integral<Field>::value) {
      row += std::to_string(value);
    } else {
      for (std::size_t i = 0; i < value.size(); ++i) row += (i > 0 ? " " : "") + value[i];
    }
  });
  file_.add(row);
}

WrenchesFile::WrenchesFile(const std::string& file)
    : file_(file, "simulation_time,step,id,force_x,force_y,force_z,torque_x,torque_y,torque_z") {}

void WrenchesFile::add(const simulation::Simulation& simulation) {
  const std::string step = formatExactly(simulation.time()) + ',' + std::to_string(simulation.stepCount()) + ',';
  const auto addAll = [&](const auto& reactions) {
    for (const auto& reaction : reactions) {
      std::string row = step + quoteCsv(reaction.id);
      for (const Vec3& vector : {reaction.force, reaction.torque})
        for (const double value : {vector.x(), vector.y(), vector.z()}) row += ',' + formatExactly(value);
      file_.add(row);
    }
  };
  addAll(simulation.toolReactions());
  addAll(simulation.pinReactions());
}

bool isFrameName(const std::string& name) {
  static const std::regex kFrameName("frame_[0-9]{6,10}\\.ply");
  return std::regex_match(name, kFrameName);
}

FrameFiles::FrameFiles(const std::string& directory, double rate, double time_step)
    : directory_(directory), pace_(rate, time_step) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!std::filesystem::is_directory(directory, error)) {
    throw InputError(directory + ": no folder, and none can be made; accepted: a folder for --frames");
  }
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    if (isFrameName(entry.path().filename().string())) {
      throw InputError("--frames: found frames of an earlier run in " + quote(directory) +
                       "; accepted: another folder, or this one without files frame_NUMBER.ply");
    }
  }
}

void FrameFiles::add(double time, simulation::Simulation& simulation) {
  if (!pace_.isDue(time)) return;
  char name[32];
  std::snprintf(name, sizeof name, "frame_%06d.ply", count_++);
  const simulation::Surface& surface = simulation.surface(true);
  io::writePointFile((std::filesystem::path(directory_) / name).string(), makeOutputCloud(surface, simulation.input()),
                     surface.displacement);
}

OutputBag::OutputBag(const std::string& file, double rate, double time_step)
    : name_(file), file_(file), bag_(new rosbag::Bag), pace_(rate, time_step) {
  try {
    bag_->open(file_.temporary(), rosbag::bagmode::Write);
  } catch (const rosbag::BagException&) {
    refuseFile(file);
  }
}

void OutputBag::CloseOrLeave::operator()(rosbag::Bag* bag) const noexcept {
  try {
    bag->close();
    delete bag;
  } catch (const rosbag::BagException&) {}
}

void OutputBag::begin(const std::string& frame_id, const CloudId& cloud, const simulation::Simulation& simulation) {
  frame_id_ = frame_id;
  cloud_ = cloud;
  encoder_ =
      std::make_unique<SurfaceEncoder>(simulation.input(), simulation.params().output.normals, simulation.params().output.error);
  markers_ = std::make_unique<SimulationMarkers>(simulation, frame_id);
}

void OutputBag::add(double time, std::int64_t stamp, const std::set<std::string>& silent, simulation::Simulation& simulation) {
  if (!pace_.isDue(time)) return;
  std_msgs::Header header;
  header.frame_id = frame_id_;
  header.stamp.fromNSec(static_cast<std::uint64_t>(stamp));
  const ros::Time recorded = std::max(header.stamp, ros::TIME_MIN);  // a bag knows no time zero
  const auto write = [&](const char* name, const auto& message) {
    try {
      bag_->write(std::string("/deformable_surface/") + name, recorded, message);
    } catch (const rosbag::BagException&) {
      refuseFile(name_);
    }
  };

  sensor_msgs::PointCloud2 cloud;
  encoder_->encode(simulation.surface(true), cloud);
  cloud.header = header;
  write("deformed", cloud);

  encodeSimulationPoints(simulation, cloud);
  cloud.header = header;
  write("simulation_points", cloud);

  write("contacts", makeContacts(header, simulation.tools(), simulation.contacts(), simulation.selfTouches()));
  write("tool_wrenches", makeToolWrenches(header, simulation.toolReactions(), simulation.pinReactions(), silent));

  visualization_msgs::MarkerArray markers;
  markers_->make(header, simulation, markers);
  write("markers", markers);

  Statistics message;
  encodeStatistics(simulation.statistics(), cloud_, message);
  message.header = header;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double* wall_time :
       {&message.time_input, &message.time_forces, &message.time_solve, &message.time_contact, &message.time_estimate,
        &message.time_transfer, &message.time_normals, &message.time_publish, &message.time_total, &message.real_time_factor}) {
    *wall_time = nan;
  }
  write("statistics", message);
}

void OutputBag::finish() {
  try {
    bag_->close();
  } catch (const rosbag::BagException&) {
    (void)bag_.release();  // to close it a second time would close its file twice
    refuseFile(name_);
  }
  file_.keep();
}

}  // namespace deformable_surface::node
