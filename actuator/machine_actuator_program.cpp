// The calls of a program that is one actuator: a failure is logged and becomes its exit code.

#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/code.hpp"

namespace musher {

bool MachineActuator::MachineActuatorInit(const std::string& config_file,
                                          std::shared_ptr<transport::NodeThread> node) {
  const Result<> result = Init(config_file, std::move(node));
  if (!result) Log(LogLevel::kError, result.error().message);
  return result.ok();
}

bool MachineActuator::ActuatorStart() {
  const Result<> result = Start();
  if (!result) {
    const Error& why = result.error();
    Log(LogLevel::kError,
        "not started: " + CodeText(why.code) + (why.message.empty() ? "" : ", ") + why.message);
  }
  return result.ok();
}

int MachineActuator::Check(const std::string& config_file) {
  if (!MachineActuatorInit(config_file)) return kConfigurationError;
  const auto fit = CheckCallbacks();
  if (!fit) Log(LogLevel::kError, fit.error().message);
  return fit ? 0 : kConfigurationError;
}

int MachineActuator::Run(const std::string& config_file) {
  if (const int faulty = Check(config_file); faulty != 0) return faulty;
  return ActuatorStart() ? Wait() : 1;
}

}  // namespace musher
