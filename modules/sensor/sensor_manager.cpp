#include "musher/modules/sensor/sensor_manager.hpp"

#include <utility>

#include "musher/actuator/program/await.hpp"

namespace musher::sensor {

SensorManager::SensorManager(const std::string& actuator_name, ManagerConfig config)
    : MachineActuator(actuator_name), config_(std::move(config)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

SensorManager::~SensorManager() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    sensors_.reset();
    endpoints_.reset();
    clock_.reset();
  });
}

Result<> SensorManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  if (state == kActive) return Activate();
  return Enter(state);
}

Result<> SensorManager::SetUp() {
  node_ = node();
  Result<> made;
  node_->RunOnLoop([&] {
    if (!sensors_) made = MakeSensors();
  });
  return made;
}

Result<> SensorManager::MakeSensors() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node(), [this] {
    if (sensors_) sensors_->OnTimeJumped();
  });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  const std::string& name_space = machine_config().name_space;
  endpoints_ = std::make_unique<transport::Endpoints>(node_->node(), name_space);
  const auto report = endpoints_->PublishFunction<msg::NodeError>("node_errors");
  if (!endpoints_->opened()) return endpoints_->opened();
  const Dependencies dependencies = {node_->node(),
                                     *clock_,
                                     name_space,
                                     [this] { return clock_->Stamp(); },
                                     [this](const std::string& line) { Log(line); },
                                     [this, report](std::int32_t code) {
                                       report({name(), code});
                                     }};
  ManagerConfig config = config_;
  if (!config.ros_distro) config.ros_distro = transport::ChosenDistro(machine_config().ros_distro);
  auto sensors = Sensors::Make(dependencies, config);
  if (!sensors) return sensors.error();
  sensors_ = std::move(sensors).value();
  return Ok();
}

Result<> SensorManager::Enter(std::string_view state) {
  Result<> entered;
  node_->RunOnLoop([&] { entered = sensors_->Enter(state); });
  return entered;
}

// Sensors that sleep are woken for the check.
Result<> SensorManager::SelfCheck() {
  SelfCheckVerdict verdict;
  verdict.result = Enter(kSelfCheck);
  if (verdict.result) {
    static_cast<void>(Await(config_.self_check_time, [&]() -> Result<> {
      verdict = EvaluateSelfCheck(sensors_->Check(), config_.critical);
      return verdict.well() || !verdict.result ? verdict.result : Result<>(verdict.degraded);
    }));
  }
  static_cast<void>(Enter(CurrentState()));
  if (verdict.degraded.code != kCodeOk) {
    ReportDegraded(verdict.degraded);
    Log({verdict.degraded.code, "self-check, degraded: " + verdict.degraded.message});
  }
  return verdict.result;
}

Result<> SensorManager::Activate() {
  Result<> result = Enter(kActive);
  if (result) result = Await(config_.start_time, [this] { return sensors_->CheckStarted(); });
  if (!result) static_cast<void>(Enter(CurrentState()));
  return result;
}

Result<> SensorManager::Await(Duration time, const std::function<Result<>()>& check) {
  return program::AwaitOnLoop(*node_, time, check, [this] { return StopRequested(); });
}

}  // namespace musher::sensor
