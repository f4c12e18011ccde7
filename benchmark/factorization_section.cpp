// Part 7: the linear systems of implicit and static steps. The package's own factorisation and Eigen's, on the same matrices in
// the same run, with the residual of each.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/linear/block_cholesky.h"
#include "deformable_surface/simulation/simulation.h"
#include "sections.h"

#include <Eigen/SparseCholesky>

namespace deformable_surface::benchmark {
namespace {

using Shape = simulation::CloudParams::Shape;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kStep = 0.01;  // s

// The matrix of the first Newton iteration of an implicit step from rest: masses over the squared step, and stiffness.
BlockSparse makeMatrix(Shape shape, Index points) {
  simulation::SceneParams scene;
  scene.material.young_modulus = 2e5;
  scene.material.thickness = 0.002;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  simulation::CloudParams params;
  params.shape = shape;
  params.points = points;
  const simulation::Simulation surface(scene, io::makeShape(params));
  const Index n = surface.state().size();
  BlockSparse matrix;
  matrix.begin(n);
  surface.model().stiffnessMatrix()->addStiffness(surface.state(), 0.0, model::Hessian::kPositive, matrix);
  for (Index i = 0; i < n; ++i) matrix.add(i, i, surface.model().masses()[i] / (kStep * kStep) * Mat3::Identity());
  matrix.finish();
  return matrix;
}

// The lower triangle, as Eigen's factorisation takes it.
Sparse makeScalar(const BlockSparse& matrix) {
  const Lists& pattern = matrix.pattern();
  std::vector<Eigen::Triplet<double>> triplets;
  for (Index column = 0; column < pattern.size(); ++column)
    for (Index k = pattern.offsets[column]; k < pattern.offsets[column + 1]; ++k)
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          if (3 * pattern.items[k] + r >= 3 * column + c)
            triplets.emplace_back(3 * pattern.items[k] + r, 3 * column + c, matrix.values()[k](r, c));
  Sparse lower(3 * pattern.size(), 3 * pattern.size());
  lower.setFromTriplets(triplets.begin(), triplets.end());
  return lower;
}

}  // namespace

void runFactorizationSection(const Options& options, Report& report) {
  report.begin("factorization", "7. Linear systems of implicit steps, cpu ms, one thread",
               {"surface", "points", "blocks_per_row", "numbers_in_factor", "analyze", "factorize", "eigen_factorize", "ratio",
                "solve", "eigen_solve", "residual", "eigen_residual", "hash"});
  setNumThreads(1);
  struct Row {
    const char* name;
    Shape shape;
    Index points;
  };
  std::vector<Row> rows{{"sheet", Shape::kSheet, 324},
                        {"sphere", Shape::kSphere, 327},
                        {"sheet", Shape::kSheet, 784},
                        {"sphere", Shape::kSphere, 800}};
  if (options.large) {
    rows.push_back({"sheet", Shape::kSheet, 3025});
    rows.push_back({"sphere", Shape::kSphere, 3000});
  }
  for (const Row& row : rows) {
    const BlockSparse matrix = makeMatrix(row.shape, row.points);
    const Index n = matrix.pattern().size();
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(3 * n, -1.0, 1.0);

    BlockCholesky ours;
    bool ok = true;
    Eigen::VectorXd x, x_eigen, product;
    const Timing analyze = measure([&] { ours.analyze(matrix.pattern()); }, options.budget);
    const Timing factorize = measure([&] { ok = ours.factorize(matrix.values()) && ok; }, options.budget);
    const Timing solve = measure([&] { ours.solveInPlace(x = b); }, options.budget);

    const Sparse lower = makeScalar(matrix);
    Eigen::SimplicialLDLT<Sparse> eigen;
    eigen.analyzePattern(lower);
    const Timing eigen_factorize = measure([&] { eigen.factorize(lower); }, options.budget);
    const Timing eigen_solve = measure([&] { x_eigen = eigen.solve(b); }, options.budget);

    const auto findResidual = [&](const Eigen::VectorXd& solution) {
      matrix.multiply(solution, product);
      return (product - b).norm() / b.norm();
    };
    report.add({row.name, std::to_string(n), show(2.0 * matrix.pattern().items.size() / n - 1.0),
                std::to_string(ours.factorSize()), showMilliseconds(analyze.cpu), showMilliseconds(factorize.cpu),
                showMilliseconds(eigen_factorize.cpu), show(eigen_factorize.cpu / factorize.cpu), showMilliseconds(solve.cpu),
                showMilliseconds(eigen_solve.cpu), ok ? show(findResidual(x)) : "NOT DEFINITE", show(findResidual(x_eigen)),
                showHash(hashBytes(x.data(), x.size() * sizeof(double)))});
  }
  report.end();
  report.note("eigen: SimplicialLDLT of the same matrix with the same kind of ordering; residual: |A x - b| / |b|");
}

}  // namespace deformable_surface::benchmark
