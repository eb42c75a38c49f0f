#include "musher/modules/meilin/servers/server_actuator.hpp"

#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/application/refusal.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/transport/clock.hpp"

namespace musher::meilin::servers {

ServerActuator::ServerActuator(const std::string& actuator_name, ServerConfig config,
                               MakeServer make)
    : MachineActuator(actuator_name), config_(std::move(config)), make_(std::move(make)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

ServerActuator::~ServerActuator() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    signal_watch_.reset();
    server_.reset();
    others_.reset();
    clock_.reset();
  });
}

void ServerActuator::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (server_) server_->Permit(permitted, why);
}

void ServerActuator::OnEmergencyStop() {
  Permit(false, "an emergency stop holds it");
}

Result<> ServerActuator::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  Result<> entered;
  RunOnLoop([&] { entered = Enter(state); });
  return entered;
}

Result<> ServerActuator::Enter(const State& state) {
  if (state != kActive) {
    Permit(false, "it is in " + state);
    return Ok();
  }
  if (EmergencyStopped()) {
    return RefusedWith<ApplicationRefusal::kStoppedMeanwhile>(
        MakeCode(cyberdog::module_code::kApp, KeyCode::kStateInvalid));
  }
  Permit(true, "");
  return Ok();
}

Result<> ServerActuator::SetUp() {
  node_ = node();
  if (!node_) return Ok();  // a fault-injection test: there is no hardware
  Result<> made;
  RunOnLoop([&] {
    if (!server_) made = Open();
  });
  return made;
}

Result<> ServerActuator::Open() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node(), [this] {
    if (server_) server_->OnTimeJump(clock_->JumpText());
  });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  const std::string& name_space = machine_config().name_space;
  if (machine_config().keys.empty()) {
    auto others = transport::OtherMachines::Make(node_->node(), name_space);
    if (!others) return others.error();
    others_ = std::move(others).value();
  }
  const Dependencies dependencies{
      node_->node(), *clock_, name_space,
      [this](LogLevel level, const std::string& line) { Log(level, line); }, others_.get()};
  auto server = make_ ? make_(dependencies) : Make(dependencies, config_);
  if (!server) return server.error();
  server_ = std::move(server).value();
  signal_watch_ = signals_.Watch(node_->loop(), [this] { server_.reset(); });
  return Ok();
}

Result<> ServerActuator::SelfCheck() {
  if (!node_) return Ok();
  return program::AwaitOnLoop(
      *node_, config_.self_check_time,
      [this]() -> Result<> {
        const std::string missing = server_ ? server_->Missing() : "the process ends";
        if (missing.empty()) return Ok();
        return Error{MakeCode(cyberdog::module_code::kApp, KeyCode::kSelfCheckFailed), missing};
      },
      [this] { return StopRequested(); });
}

}  // namespace musher::meilin::servers
