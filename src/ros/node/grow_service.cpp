#include "grow_service.h"

#include "deformable_surface/FitSurface.h"
#include "deformable_surface/GrowSurface.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/scene_old_names.h"

#include <chrono>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

namespace deformable_surface::node {
namespace {

// Between two tries where too many calls wait already.
constexpr std::chrono::milliseconds kBusyPause(10);

// Values of zero keep the defaults.
template <class Request>
model::GrowthParams readGrowth(const Request& request, model::GrowthParams growth) {
  const auto take = [](double given, double& value) {
    if (given != 0.0) value = given;
  };
  take(request.min_gap, growth.min_gap);
  take(request.max_gap, growth.max_gap);
  take(request.min_angle, growth.min_angle);
  take(request.max_angle, growth.max_angle);
  const auto takeCount = [](const char* name, std::uint32_t given, Index& value) {
    if (given > static_cast<std::uint32_t>(std::numeric_limits<Index>::max()))
      throw InputError(std::string(name) + ": found " + std::to_string(given) + "; accepted: fewer");
    if (given != 0) value = static_cast<Index>(given);
  };
  takeCount("edge_rows", request.edge_rows, growth.edge_rows);
  takeCount("max_particles", request.max_particles, growth.max_particles);
  return growth;
}

}  // namespace

GrowService::GrowService(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, WarningLog& warnings)
    : inbox_(inbox), stepper_(stepper), warnings_(warnings), first_thread_(queue_), second_thread_(queue_) {
  node.setCallbackQueue(&queue_);
  server_ = advertise<GrowSurfaceRequest, GrowSurfaceResponse>(node, "grow_surface", "");
  old_server_ = advertise<FitSurfaceRequest, FitSurfaceResponse>(node, "fit", io::describeNewName("~fit", "~grow_surface"));
  first_thread_.start();
  second_thread_.start();
}

GrowService::~GrowService() {
  first_thread_.stop();
  second_thread_.stop();
}

template <class Request, class Response>
ros::ServiceServer GrowService::advertise(ros::NodeHandle& node, const std::string& name, const std::string& notice) {
  const auto answer = [this, notice](Request& request, Response& response) {
    if (!notice.empty()) warnings_.report(Warning::kNotice, notice);
    try {
      grow(request, response);
    } catch (const std::exception& error) {
      response.success = false;
      response.message = toOneLine(error.what());
      warnings_.report(Warning::kCallRefused, "call refused: " + response.message);
    }
    return true;
  };
  return node.advertiseService<Request, Response>(name, boost::function<bool(Request&, Response&)>(answer));
}

void GrowService::performInTheEnd(const std::function<void()>& work) {
  bool is_done = false;
  while (!is_done && !inbox_.isClosed()) {
    try {
      inbox_.perform([&] {
        is_done = true;
        work();
      });
    } catch (const InputError&) {
      if (is_done) throw;
      std::this_thread::sleep_for(kBusyPause);
    }
  }
}

template <class Request, class Response>
void GrowService::grow(const Request& request, Response& response) {
  std::unique_ptr<simulation::Simulation> copy;
  model::GrowthParams growth;
  int num_threads = 0;
  Hold::Id hold{};
  inbox_.perform([&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    stepper_.requireFree();
    growth = readGrowth(request, stepper_.simulation()->params().oriented_particles.growth);
    num_threads = static_cast<int>(stepper_.params().threads);
    copy = std::make_unique<simulation::Simulation>(stepper_.simulation()->fork());
    hold = stepper_.hold();
  });
  try {
    const InterruptScope scope(*inbox_.closing());
    setNumThreads(num_threads);
    response.message = copy->growSurface(growth);
  } catch (...) {
    performInTheEnd([&] { stepper_.letGo(hold); });
    throw;
  }
  performInTheEnd([&] {
    stepper_.replaceHeld(hold, std::move(copy));
    response.particles = static_cast<std::uint32_t>(stepper_.simulation()->state().size());
  });
  stepper_.waitForResult();
  response.success = true;
}

}  // namespace deformable_surface::node
