#include "musher/cyberdog/machine.hpp"

#include <iostream>
#include <utility>

#include "musher/cyberdog/extension.hpp"

namespace musher::cyberdog {

bool MachineActuator::MachineActuatorInit(const std::string& config_file,
                                          std::shared_ptr<transport::NodeThread> node) {
  const Result<> result = Init(config_file, std::move(node));
  if (!result) Log(LogLevel::kError, result.error().message);
  return result.ok();
}

bool MachineActuator::ActuatorStart() {
  const Result<> result = Start();
  if (!result) Log(LogLevel::kError, "not started: " + ErrorText(result.error()));
  return result.ok();
}

MachineController::MachineController() : musher::MachineController({Extension()}) {}

bool MachineController::MachineControllerInit(const std::string& config_file,
                                              std::shared_ptr<transport::NodeThread> node) {
  const Result<> result = Init(config_file, std::move(node));
  if (!result) std::cerr << result.error().message << std::endl;
  return result.ok();
}

bool MachineController::WaitActuatorsSetUp() {
  return AwaitSetUp().ok();
}

void MachineController::GetStateMap(std::map<std::string, std::string>& state_map) const {
  state_map.clear();
  for (const auto& [actuator, state] : States()) state_map.emplace(actuator, state);
}

bool MachineController::GetState(const std::string& target_actuator, std::string& state) const {
  const auto found = StateOf(target_actuator);
  if (found) state = *found;
  return found.has_value();
}

bool MachineController::SetState(const std::string& target_actuator,
                                 const std::string& target_state) {
  return Switch(target_actuator, State(target_state)).done();
}

bool MachineController::SetState(const std::string& target_state) {
  return Switch(State(target_state)).done();
}

}  // namespace musher::cyberdog
