// The calls of a program that is one actuator: a failure is logged and becomes its exit code.

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/code.hpp"

namespace musher {

int MachineActuator::Check(const std::string& config_file) {
  if (const auto read = Init(config_file); !read) {
    Log(LogLevel::kError, read.error().message);
    return kConfigurationError;
  }
  const auto fit = CheckCallbacks();
  if (!fit) Log(LogLevel::kError, fit.error().message);
  return fit ? 0 : kConfigurationError;
}

int MachineActuator::Run(const std::string& config_file) {
  if (const int faulty = Check(config_file); faulty != 0) return faulty;
  const auto started = Start();
  if (started) return Wait();
  Log(LogLevel::kError, "not started: " + ErrorText(started.error()));
  return 1;
}

}  // namespace musher
