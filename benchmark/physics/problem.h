// What a problem of the physics suite is: a thing with a known answer that can be asked of the simulation at any resolution.
// Tests ask the coarse ones, the benchmark all of them.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/mass_spring/mass_spring_params.h"

#include <functional>
#include <string>
#include <vector>

namespace deformable_surface::physics {

/// Where the points of a surface lie. kScanned: the pattern of a real depth scan, dense, which the product then simplifies.
enum class Sampling { kRegular, kJittered, kScanned };

/// How a problem is made discrete.
struct Variant {
  model::Membrane membrane = model::Membrane::kTriangles;
  model::Bending bending = model::Bending::kCurvature;
  Sampling sampling = Sampling::kRegular;
  bool rotated = false;  // the whole problem is turned in space
};

std::string nameMembrane(const Variant& variant);
std::string nameBending(const Variant& variant);
std::string nameSampling(const Variant& variant);

/// Regular and aligned; jittered and rotated; scanned, simplified and rotated.
std::vector<Variant> listSamplings(model::Membrane membrane, model::Bending bending);
/// Triangles on every sampling, springs on the jittered one: where the membrane matters little.
std::vector<Variant> listMost(model::Bending bending);
/// Both membranes, each on every sampling.
std::vector<Variant> listAll(model::Bending bending);

struct Answer {
  Index points = 0;                     // simulation points
  double size = 0.0;                    // the spacing in m, or the time step in s
  double value = 0.0, reference = 0.0;  // in the problem's unit
  double error = 0.0;                   // as a share of the scale that the problem names
  double seconds = 0.0;                 // wall time of set-up and solution
  std::string failure;                  // why there is no value; else empty
};

struct Problem {
  std::string name;
  std::string value;       // what is compared, with its unit
  std::string scale;       // what the error is a share of
  std::string source;      // of the reference
  bool in_time = false;    // refined in time, not in space
  bool is_solid = false;   // it has neither membrane nor bending
  bool other_law = false;  // the reference obeys another law than the model: no refinement makes the error fall
  std::vector<Variant> variants;
  /// Spacings or time steps, coarsest first. The tests take the first ones.
  std::vector<double> sizes;
  std::function<Answer(const Variant&, double size)> run;
};

/// The answer, timed; a solver that does not converge and an input that is refused become its failure.
Answer solve(const Problem& problem, const Variant& variant, double size);

/// The slope of log(error) over log(size) by least squares, and its standard error (NaN below three answers).
struct Order {
  double value = 0.0, spread = 0.0;
};
Order fitOrder(const std::vector<Answer>& answers);

/// The families; each is a file.
std::vector<Problem> listMotions();
std::vector<Problem> listHanging();
std::vector<Problem> listStrips();
std::vector<Problem> listMembranes();
std::vector<Problem> listShells();
std::vector<Problem> listVibrations();
std::vector<Problem> listMeasured();
std::vector<Problem> listSolids();
std::vector<Problem> listContacts();

/// The one of that name; throws std::logic_error if there is none.
Problem findProblem(const std::vector<Problem>& problems, const std::string& name);

}  // namespace deformable_surface::physics
