#pragma once
// The calls of CyberDog's machine library, for modules and programs that were written for it: they
// change the header and the namespace, and keep their code and their state config.
//
//   class Legs : public musher::cyberdog::MachineActuator { ... };
//   Legs legs("legs");
//   legs.RegisterStateCallback("Active", [] { return 0; });  // for each state
//   if (!legs.MachineActuatorInit("robot.toml") || !legs.ActuatorStart()) return 1;
//   return legs.Wait();
//
// New code uses musher::MachineActuator and musher::MachineController, whose calls return the
// error instead of logging it.
//
// Threads: as in the base classes.

#include <concepts>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"

namespace musher::cyberdog {

// A name that is not known to the compiler: a literal is one of the base's states by itself.
template <typename T>
concept ComputedName = std::same_as<T, std::string> || std::same_as<T, const char*>;

class MachineActuator : public musher::MachineActuator {
 public:
  using musher::MachineActuator::MachineActuator;

  // Init(); false after an error, which is logged.
  bool MachineActuatorInit(const std::string& config_file = "",
                           std::shared_ptr<transport::NodeThread> node = nullptr);

  using musher::MachineActuator::RegisterStateCallback;
  // The same with the name of a state that is computed; CyberDog's states are texts.
  template <ComputedName Name, typename Callback>
  void RegisterStateCallback(const Name& state, Callback callback) {
    RegisterStateCallback(State(state), std::move(callback));
  }

  // Start(); false after an error, which is logged.
  bool ActuatorStart();
};

// Has CyberDog's protocol and manager (extension.hpp).
class MachineController : public musher::MachineController {
 public:
  MachineController();

  // Init(); false after an error, which is printed to stderr.
  bool MachineControllerInit(const std::string& config_file = "",
                             std::shared_ptr<transport::NodeThread> node = nullptr);
  // AwaitSetUp(); false if an actuator fails or exceeds its SetUp time.
  bool WaitActuatorsSetUp();

  // States().
  void GetStateMap(std::map<std::string, std::string>& state_map) const;
  // StateOf(); false for an unknown actuator, `state` is then unchanged.
  bool GetState(const std::string& target_actuator, std::string& state) const;
  // Switch(); true only for the outcome done, not for done-degraded.
  bool SetState(const std::string& target_actuator, const std::string& target_state);
  bool SetState(const std::string& target_state);
};

}  // namespace musher::cyberdog
