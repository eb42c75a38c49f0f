#include "musher/modules/skills/plan/dispatcher_actuator.hpp"

#include <utility>

#include "musher/application/refusal.hpp"

namespace musher::skills {

DispatcherActuator::DispatcherActuator(const std::string& actuator_name, DispatcherConfig config)
    : MachineActuator(actuator_name), config_(std::move(config)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

void DispatcherActuator::OnEmergencyStop() {
  if (const auto server = server_.lock()) server->Permit(false, "an emergency stop holds it");
}

void DispatcherActuator::OnEnd() {
  if (const auto server = server_.lock()) server->Permit(false, "its process ends");
}

Result<> DispatcherActuator::SetUp() {
  return OpenEndpoints([this](transport::Endpoints& endpoints) {
    const auto server = std::make_shared<PlanServer>(
        endpoints.node(), name(), machine_config().name_space, config_,
        [this](LogLevel level, const std::string& line) { Log(level, line); },
        machine_config().state_dir + "/" + name() + "_goals.toml");
    server->Open(endpoints);
    endpoints.Keep(server);
    server_ = server;
    if (signals_ == nullptr) return;
    endpoints.Keep(std::shared_ptr<transport::LoopHandle>(
        signals_->Watch(endpoints.node().loop(), [this] { OnEnd(); })));
  });
}

Result<> DispatcherActuator::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  Result<> entered;
  RunOnLoop([&] {
    const auto server = server_.lock();
    if (state == kActive && EmergencyStopped()) {
      entered = Refused<ApplicationRefusal::kStoppedMeanwhile>();
    } else if (server) {
      server->Permit(state == kActive, "it is in " + state);
    }
  });
  return entered;
}

}  // namespace musher::skills
