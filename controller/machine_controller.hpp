#pragma once
// The controller as a member of your own program, instead of the `musher` program: your code
// decides when the machine switches to which state.
//
//   musher::MachineController controller;
//   if (!controller.MachineControllerInit("robot.toml")) return 1;
//   if (!controller.WaitActuatorsSetUp()) return 1;
//   if (!controller.SetState("SelfCheck") || !controller.SetState("Active")) return 1;
//
// It starts the processes of actuators that have a `command`, keeps a journal and answers the CLI,
// like `musher up`. Every call also has a form that returns the outcome of each actuator with code,
// message and duration.
//
// Threads: calls from any thread; each blocks until it has its result. The work runs on a loop
// thread of its own (or of the given node). Must not be called from that loop.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/switch_result.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher {

struct ControllerExtension;

class MachineController {
 public:
  MachineController();
  // With protocols and services of other libraries: MachineController({cyberdog::Extension()}).
  explicit MachineController(std::vector<ControllerExtension> extensions);
  // Leaves actuators and their processes running; SetState("TearDown") stops them.
  ~MachineController();
  MachineController(const MachineController&) = delete;
  MachineController& operator=(const MachineController&) = delete;

  // Reads and validates the config (empty: $MUSHER_CONFIG), takes the machine over and starts
  // processes. Fails, with the reason on stderr, if the config is invalid or a running controller
  // leads the machine. The file is not needed after that. `node` null: creates its own.
  bool MachineControllerInit(const std::string& config_file = "",
                             std::shared_ptr<transport::NodeThread> node = nullptr);
  Result<> Init(const std::string& config_file = "",
                std::shared_ptr<transport::NodeThread> node = nullptr);

  // Waits until all actuators are set up; false if one fails or exceeds its SetUp time.
  bool WaitActuatorsSetUp();
  Result<> AwaitSetUp();

  // The last known states, without a call.
  void GetStateMap(std::map<std::string, std::string>& state_map) const;
  // False for an unknown actuator; `state` is then unchanged.
  bool GetState(const std::string& target_actuator, std::string& state) const;
  // The machine's own state.
  State GetMachineState() const;

  // Switches one actuator, or the machine; true only for the outcome done, not for done-degraded.
  bool SetState(const std::string& target_actuator, const std::string& target_state);
  bool SetState(const std::string& target_state);
  SwitchResult Switch(const std::string& target_actuator, const std::string& target_state);
  SwitchResult Switch(const std::string& target_state);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
