#pragma once
// The controller as a member of your own program, instead of the `musher` program: your code
// decides when the machine switches to which state.
//
//   musher::MachineController controller;
//   if (const auto begun = controller.Init("robot.toml"); !begun) return Fail(begun.error());
//   if (const auto there = controller.AwaitSetUp(); !there) return Fail(there.error());
//   if (!controller.Switch("SelfCheck").done() || !controller.Switch("Active").done()) return 1;
//
// It starts the processes of actuators that have a `command`, keeps a journal and answers the CLI,
// like `musher up`. The calls of CyberDog's library are in cyberdog/machine.hpp.
//
// Threads: calls from any thread; each but SwitchAsync() blocks until it has its result. The work
// runs on a loop thread of its own (or of the given node). Calls that block must not be made on
// that loop.

#include <functional>
#include <map>
#include <memory>
#include <optional>
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
  // Leaves actuators and their processes running; Switch("TearDown") stops them.
  ~MachineController();
  MachineController(const MachineController&) = delete;
  MachineController& operator=(const MachineController&) = delete;

  // Reads and validates the config (empty: $MUSHER_CONFIG), takes the machine over and starts
  // processes. Fails if the config is invalid or a running controller leads the machine. The file
  // is not needed after that. `node` null: creates its own.
  Result<> Init(const std::string& config_file = "",
                std::shared_ptr<transport::NodeThread> node = nullptr);

  // Waits until all actuators are set up; fails if one fails or exceeds its SetUp time.
  Result<> AwaitSetUp();

  // The last known state of each actuator by its name, without a call.
  std::map<std::string, State> States() const;
  // The same of one actuator; nullopt if the config has none of this name.
  std::optional<State> StateOf(const std::string& actuator) const;
  // The machine's own state.
  State GetMachineState() const;

  // Switches one actuator, or the machine, and waits for the end. The result has the outcome of
  // each actuator with its code, message and duration; done() is true for the outcome done, not for
  // done-degraded.
  SwitchResult Switch(const std::string& actuator, const State& target);
  SwitchResult Switch(const State& target);

  // The same without waiting, from any thread including the loop's. Before Init(), `on_end` gets a
  // refusal in this call. After it, `on_end` gets the result exactly once, on the loop's thread and
  // after this call has returned: it must return at once, and may begin the next switch. A switch
  // that has not ended when this object is destroyed continues or ends with the next controller;
  // its `on_end` does not run.
  using OnEnd = std::function<void(const SwitchResult&)>;
  void SwitchAsync(const std::string& actuator, const State& target, OnEnd on_end);
  void SwitchAsync(const State& target, OnEnd on_end);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
