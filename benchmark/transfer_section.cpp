// Part 3: transfer with normals as a share of the memory bandwidth, both measured in this run, with the error of a rigid
// rotation, which must be reproduced exactly.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/transfer/transfer.h"
#include "machine_limits.h"
#include "sections.h"
#include "wavy_sheet.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

constexpr Index kSimulationPoints = 2000;
// A written line counts twice, as in the triad.
double movedBytes(const transfer::Transfer& transfer) {
  return static_cast<double>(transfer.bytesPerPoint() + 2 * sizeof(Vec3) + 2 * sizeof(Eigen::Vector3f));
}

}  // namespace

void runTransferSection(const Options& options, Report& report) {
  report.begin("transfer", "3. Transfer with normals against the memory's bandwidth (triad on as many bytes, same run)",
               {"points", "threads", "wall_ms", "spread_%", "cpu_ms", "cores", "million_points_per_s", "bytes_per_point",
                "GB_per_s", "triad_GB_per_s", "ratio", "rotation_error_m", "normal_error_deg", "runs", "hash"});
  const cloud::PointCloud coarse = makeWavySheet(kSimulationPoints, PointOrder::kScan);
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  Points turned;
  for (const Vec3& p : coarse.positions) turned.push_back(rotation * p);

  for (Index n : {100000, 1000000}) {
    setNumThreads(0);
    const cloud::PointCloud dense = makeWavySheet(n, PointOrder::kScan);
    Points normals;
    for (const Vec3& p : dense.positions) normals.push_back(findWavyNormal(p));
    const transfer::Transfer transfer(dense.positions, normals, coarse.positions, std::vector<char>(coarse.positions.size(), 1),
                                      {});
    for (int threads : {1, 2}) {
      setNumThreads(threads);
      Points now;
      std::vector<Eigen::Vector3f> normals_now;
      const Timing timing = measure([&] { transfer.apply(turned, now, normals_now); }, options.budget, 5);
      double error = 0.0, normal_error = 0.0;
      for (std::size_t i = 0; i < now.size(); ++i) {
        error = std::max(error, (now[i] - rotation * dense.positions[i]).norm());
        normal_error = std::max(normal_error, (normals_now[i].cast<double>() - rotation * normals[i]).norm());
      }
      const double bandwidth = movedBytes(transfer) * dense.size() / (threads == 1 ? timing.cpu : timing.least);  // as the triad
      const double triad = measureTriad(movedBytes(transfer) * dense.size(), options.budget);
      report.add({std::to_string(dense.size()), std::to_string(threads), showMilliseconds(timing.wall),
                  showPercent(timing.spread), showMilliseconds(timing.cpu), show(timing.cpu / timing.wall),
                  show(1e-6 * dense.size() / timing.wall), show(movedBytes(transfer)), show(1e-9 * bandwidth), show(1e-9 * triad),
                  show(bandwidth / triad), show(error), show(normal_error * 180.0 / std::acos(-1.0)),
                  std::to_string(timing.repetitions), showHash(hashValues(now))});
    }
  }
  report.end();
  report.note("bytes: operator, rest positions, results; written lines count twice, in the transfer and in the triad alike");
  report.note("target: ratio of at least 0.5 at a million points");
}

}  // namespace deformable_surface::benchmark
