#include "deformable_surface/solve/integrator.h"

#include "explicit_integrators.h"
#include "implicit_integrators.h"
#include "oriented_integrators.h"

namespace deformable_surface::solve {

std::unique_ptr<Integrator> makeIntegrator(IntegratorType type, const IntegratorParams& params, bool oriented) {
  if (oriented) {
    if (type == IntegratorType::kStatic) return std::make_unique<FireRelaxation>(params);
    return std::make_unique<OrientedVerlet>();
  }
  switch (type) {
    case IntegratorType::kExplicitEuler: return std::make_unique<ExplicitEuler>();
    case IntegratorType::kSymplecticEuler: return std::make_unique<SymplecticEuler>();
    case IntegratorType::kImplicit: return std::make_unique<ImplicitSecondOrder>(params);
    case IntegratorType::kStatic: return std::make_unique<StaticSolver>(params);
    case IntegratorType::kAuto:
    case IntegratorType::kVerlet: break;
  }
  return std::make_unique<VelocityVerlet>();
}

}  // namespace deformable_surface::solve
