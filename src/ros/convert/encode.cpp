// Packs points into PointCloud2 messages: float32, as RViz and PCL read it, without gaps between points and rows.
#include "deformable_surface/ros/convert/encode.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

namespace deformable_surface::node {
namespace {

// Points per block of work: large enough for negligible overhead.
constexpr Index kBlock = 16384;

std::uint32_t sizeOf(const sensor_msgs::PointField& field) {
  return static_cast<std::uint32_t>(cloud::sizeOf(static_cast<cloud::ScalarType>(field.datatype))) * field.count;
}

/// Appends a field; returns the offset after it.
std::uint32_t appendField(const std::string& name, std::uint8_t datatype, std::uint32_t count, std::uint32_t offset,
                          std::vector<sensor_msgs::PointField>& fields) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = datatype;
  field.count = count;
  fields.push_back(field);
  return offset + sizeOf(field);
}

std::uint32_t appendFloats(std::initializer_list<const char*> names, std::uint32_t offset,
                           std::vector<sensor_msgs::PointField>& fields) {
  for (const char* name : names) offset = appendField(name, sensor_msgs::PointField::FLOAT32, 1, offset, fields);
  return offset;
}

bool isComputed(const std::string& name) {
  constexpr const char* kComputed[] = {"x", "y", "z", "normal_x", "normal_y", "normal_z", "displacement"};
  return std::find(std::begin(kComputed), std::end(kComputed), name) != std::end(kComputed);
}

void setShape(std::uint32_t width, std::uint32_t height, std::uint32_t point_step, sensor_msgs::PointCloud2& message) {
  const std::uint64_t num_points = std::uint64_t{width} * height;
  if (num_points * point_step > std::numeric_limits<std::uint32_t>::max())
    throw InputError(std::to_string(num_points) + " points of " + std::to_string(point_step) +
                     " bytes do not fit in a PointCloud2 message, which holds less than 4 GiB");
  message.width = width;
  message.height = height;
  message.is_bigendian = false;
  message.point_step = point_step;
  message.row_step = width * point_step;
  message.data.resize(num_points * point_step);
}

}  // namespace

SurfaceEncoder::SurfaceEncoder(const cloud::PointCloud& input, bool with_normals, bool with_error)
    : width_(input.width), height_(input.height), with_normals_(with_normals), with_error_(with_error) {
  computed_size_ = appendFloats({"x", "y", "z"}, 0, fields_);
  if (with_normals) computed_size_ = appendFloats({"normal_x", "normal_y", "normal_z"}, computed_size_, fields_);
  computed_size_ = appendFloats({"displacement"}, computed_size_, fields_);
  if (with_error) computed_size_ = appendFloats({"error"}, computed_size_, fields_);

  std::vector<const cloud::ExtraField*> extra_fields;
  std::uint32_t offset = computed_size_;
  for (const cloud::ExtraField& field : input.extra_fields) {
    if (isComputed(field.name) || (with_error && field.name == "error")) continue;
    extra_fields.push_back(&field);
    offset = appendField(field.name, static_cast<std::uint8_t>(field.type), field.count, offset, fields_);
  }
  extra_size_ = offset - computed_size_;

  // The extra fields of a point side by side, as in the message.
  extra_bytes_.resize(std::size_t{extra_size_} * input.size());
  std::size_t column = 0;
  for (const cloud::ExtraField* field : extra_fields) {
    const std::size_t size = cloud::sizeOf(field->type) * field->count;
    for (Index i = 0; i < input.size(); ++i)
      std::memcpy(extra_bytes_.data() + i * std::size_t{extra_size_} + column, field->bytes.data() + i * size, size);
    column += size;
  }
}

void SurfaceEncoder::encode(const simulation::Surface& surface, sensor_msgs::PointCloud2& message) const {
  const Index n = static_cast<Index>(surface.positions.size());
  const std::size_t point_step = computed_size_ + extra_size_;
  message.fields = fields_;
  if (n == surface.num_input)
    setShape(width_, height_, point_step, message);
  else
    setShape(n, 1, point_step, message);

  std::uint8_t* const data = message.data.data();
  const double num_holes = parallelSum(n, kBlock, [&](Index begin, Index end) {
    Index holes = 0;
    for (Index i = begin; i < end; ++i) {
      // The part that changes from frame to frame.
      std::uint8_t* point = data + i * point_step;
      float computed[8];
      float* next = computed;
      for (int axis = 0; axis < 3; ++axis) *next++ = static_cast<float>(surface.positions[i][axis]);
      if (with_normals_)
        for (int axis = 0; axis < 3; ++axis) *next++ = surface.normals[i][axis];
      *next++ = surface.displacement[i];
      if (with_error_) *next = surface.error[i];
      std::memcpy(point, computed, computed_size_);
      // The extra fields of the input; an inserted point has those of its source.
      const std::size_t source = i < surface.num_input ? i : surface.source[i - surface.num_input];
      if (extra_size_ > 0) std::memcpy(point + computed_size_, extra_bytes_.data() + source * extra_size_, extra_size_);
      if (!surface.positions[i].allFinite()) ++holes;
    }
    return static_cast<double>(holes);
  });
  message.is_dense = num_holes == 0.0;
}

void encodeSimulationPoints(const SimulationPoints& points, sensor_msgs::PointCloud2& message) {
  const Index m = static_cast<Index>(points.positions.size());
  message.fields.clear();
  const std::uint32_t floats_size =
      appendFloats({"x", "y", "z", "normal_x", "normal_y", "normal_z", "mass", "strain"}, 0, message.fields);
  std::uint32_t point_step = floats_size;
  for (const char* name : {"awake", "pinned"})
    point_step = appendField(name, sensor_msgs::PointField::UINT8, 1, point_step, message.fields);
  const std::uint32_t traits_offset = point_step;
  if (!points.traits.empty()) {
    point_step = appendFloats({"temperature"}, point_step, message.fields);
    point_step = appendField("id", sensor_msgs::PointField::UINT32, 1, point_step, message.fields);
  }
  const std::uint32_t stress_offset = point_step;
  if (!points.stress.empty()) point_step = appendFloats({"stress"}, point_step, message.fields);
  setShape(m, 1, point_step, message);
  for (Index i = 0; i < m; ++i) {
    const Vec3 &p = points.positions[i], &normal = points.normals[i];
    const float floats[] = {float(p.x()),
                            float(p.y()),
                            float(p.z()),
                            float(normal.x()),
                            float(normal.y()),
                            float(normal.z()),
                            float(points.masses[i]),
                            float(points.strain[i])};
    std::uint8_t* point = message.data.data() + std::size_t{point_step} * i;
    std::memcpy(point, floats, floats_size);
    point[floats_size] = points.awake[i] != 0;
    point[floats_size + 1] = points.pinned[i] != 0;
    if (!points.stress.empty()) {
      const float stress = float(points.stress[i]);
      std::memcpy(point + stress_offset, &stress, sizeof stress);
    }
    if (points.traits.empty()) continue;
    const float temperature = float(points.traits[i].temperature);
    const auto id = static_cast<std::uint32_t>(points.traits[i].id);
    std::memcpy(point + traits_offset, &temperature, sizeof temperature);
    std::memcpy(point + traits_offset + sizeof temperature, &id, sizeof id);
  }
  message.is_dense = true;
}

void encodeSimulationPoints(const simulation::Simulation& simulation, sensor_msgs::PointCloud2& message) {
  Points normals;
  simulation.computeSimulationNormals(normals);
  std::vector<double> strain, stress;
  computePointStrain(simulation.model(), simulation.state(), strain);
  if (const model::Stresses* stresses = simulation.model().stresses()) stresses->computePointStress(simulation.state(), stress);
  std::vector<char> awake;
  for (Index i = 0; i < simulation.state().size(); ++i) awake.push_back(simulation.isAwake(i) && !simulation.pinned()[i]);
  encodeSimulationPoints({simulation.state().positions, normals, simulation.model().masses(), strain, awake, simulation.pinned(),
                          simulation.state().traits, stress},
                         message);
}

}  // namespace deformable_surface::node
