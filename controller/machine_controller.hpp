#pragma once
// The controller as a member of your own program (seed 003), instead of the `musher` program: your
// code decides when the machine goes where.
//
//   musher::MachineController controller;
//   if (!controller.MachineControllerInit("robot.toml")) return 1;
//   if (!controller.WaitActuatorsSetUp()) return 1;
//   if (!controller.SetState("SelfCheck") || !controller.SetState("Active")) return 1;
//
// It starts the processes of actuators that have a `command`, keeps a journal and answers the CLI,
// like `musher up`. Every call also has a form that says all there is to say: what became of each
// actuator, with code, message and duration.
//
// Threads: calls from any thread; each blocks until it is answered. The work is done on a loop
// thread of its own (or of the node given). Not to be called from that loop.

#include <map>
#include <memory>
#include <string>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/switch_result.hpp"
#include "musher/transport/node_thread.hpp"

namespace musher {

class MachineController {
 public:
  MachineController();
  // Leaves actuators and their processes as they are; SetState("TearDown") ends them.
  ~MachineController();
  MachineController(const MachineController&) = delete;
  MachineController& operator=(const MachineController&) = delete;

  // Reads and judges the config (empty: $MUSHER_CONFIG), takes the machine over and starts
  // processes. Fails, and says why on stderr, when the config is wrong or a living controller has
  // the machine. The file is not needed any more after that. `node` null: one of its own.
  bool MachineControllerInit(const std::string& config_file = "",
                             std::shared_ptr<transport::NodeThread> node = nullptr);
  Result<> Init(const std::string& config_file = "",
                std::shared_ptr<transport::NodeThread> node = nullptr);

  // Waits until all actuators are set up; false when one is not within its SetUp time, or failed.
  bool WaitActuatorsSetUp();
  Result<> AwaitSetUp();

  // What the controller knows; asks nobody.
  void GetStateMap(std::map<std::string, std::string>& state_map) const;
  // False for an unknown actuator, and then `state` is left as it is.
  bool GetState(const std::string& target_actuator, std::string& state) const;
  // The machine's own state.
  State GetMachineState() const;

  // Switches one actuator, or the machine; true only when it is done, with nobody left behind.
  bool SetState(const std::string& target_actuator, const std::string& target_state);
  bool SetState(const std::string& target_state);
  SwitchResult Switch(const std::string& target_actuator, const std::string& target_state);
  SwitchResult Switch(const std::string& target_state);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
