#pragma once
// The base class of a robot's module: derive from it, register a callback for each state, start.
//
//   class Gripper : public musher::MachineActuator {
//    public:
//     Gripper() : MachineActuator("gripper") {
//       RegisterStateCallback("SetUp", [this] { return OpenPort(); });
//       RegisterStateCallback("Active", [this] { return PowerOn(); });
//       ...
//     }
//   };
//
//   int main() {
//     Gripper gripper;
//     return gripper.Run();
//   }
//
// Threads: the calls below come from your threads, one at a time. State callbacks run one at a time
// on a worker thread of this actuator; meanwhile the process goes on answering "how is it going". A
// callback may block for as long as its time in the config says; past that it is asked to stop
// (StopRequested()) and the machine goes on without it. A loop thread of the process does the
// talking.
//
// A callback that fails leaves the actuator in the state it was in, and the controller may then run
// the callback of that state again to clear up what was half done: callbacks must bear to be run
// twice.
//
// Errors: the bool calls say what was wrong on stderr; the Result calls give it to you.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/lifecycle/code.hpp"
#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/node_thread.hpp"

namespace musher::transport {
class Endpoints;
}  // namespace musher::transport

namespace musher {

class CallbackHarness;

class MachineActuator {
 public:
  // The name as in [controller].actuators of the config.
  explicit MachineActuator(const std::string& actuator_name);
  // Waits for a running callback; then the actuator is gone from the machine. A derived class whose
  // callbacks use its members calls Shutdown() in its own destructor, before they die.
  virtual ~MachineActuator();
  MachineActuator(const MachineActuator&) = delete;
  MachineActuator& operator=(const MachineActuator&) = delete;

  // Reads and judges the state config. `config_file` empty: $MUSHER_CONFIG, which a controller sets
  // for the processes it starts. `node`: to share one participant among the actuators of a process;
  // null: one of its own.
  bool MachineActuatorInit(const std::string& config_file = "",
                           std::shared_ptr<transport::NodeThread> node = nullptr);
  Result<> Init(const std::string& config_file = "",
                std::shared_ptr<transport::NodeThread> node = nullptr);

  // What to do for `state`; before ActuatorStart(). Returns CyberDog's code, 0 = done.
  void RegisterStateCallback(const std::string& state, std::function<std::int32_t()> callback);
  // The same with a reason for people; an Error's code must not be 0. An exception counts as
  // Failed.
  void RegisterStateCallback(const std::string& state, std::function<Result<>()> callback);
  // What to do for each state that the config lists for this actuator and that has no callback of
  // its own: it is given the state. A state that is not listed is never asked for, as without it.
  void RegisterStateCallback(std::function<std::int32_t(const State&)> callback);
  void RegisterStateCallback(std::function<Result<>(const State&)> callback);

  // Runs SetUp and becomes visible to the controller. Fails, saying which, when a state of the
  // config has no callback or a callback no state; when SetUp fails, with its code; when an
  // actuator of this name runs on this host already. After a failure the program should end.
  bool ActuatorStart();
  Result<> Start();

  // Blocks until TearDown is done, or Shutdown() is called; gives the program's exit code.
  int Wait();

  // MachineActuatorInit(), ActuatorStart() and Wait(): the whole of a program that is this
  // actuator. Gives its exit code: kConfigurationError where the config is faulty or does not fit
  // the callbacks, which a new start would not mend, so that the controller tries none; 1 where
  // SetUp has failed or it cannot start now; else that of Wait().
  static constexpr int kConfigurationError = 2;
  int Run(const std::string& config_file = "");
  // The first part of it: 0 where Run() would go on to SetUp, else kConfigurationError.
  int Check(const std::string& config_file = "");

  // A line on stderr, which is the actuator's log: its name, the line and, of an Error, the code
  // that is not 0. Lines of several threads do not mix. From any thread.
  void Log(const std::string& line) const;
  void Log(const Error& error) const;

  // It cannot go on: says why on stderr, and Wait() gives 1, so that the program ends and its
  // restart policy acts. From any thread.
  void GiveUp(const Error& why);

  // Ends without TearDown: waits for a running callback, then leaves the machine. Idempotent.
  void Shutdown();

  // Inside a long callback: whether the controller does not wait for it any more. Give up when it
  // suits.
  bool StopRequested() const;

  // A sign of life of the thread that calls it: it gets on, and will say so again within
  // `allowance` (zero: checkpoint_ms of the config; without that nothing is watched). A thread that
  // is silent for longer although it could have run is *hung*: the process is restarted by its
  // policy.
  //   - In a state callback: watched from its beginning, until its end.
  //   - In a thread of your own, say the cycle that moves the robot: watched from its first
  //     checkpoint until the next state callback begins, or Checkpoint(kNoMore). Its first one
  //     after that callback has ended watches it again: callbacks may end and begin such threads.
  // From any thread; costs less than a microsecond.
  static constexpr std::chrono::nanoseconds kNoMore = std::chrono::nanoseconds::max();
  void Checkpoint(std::chrono::nanoseconds allowance = std::chrono::nanoseconds(0));

  // The state this actuator is in, from any thread. The config's default state before SetUp is
  // done.
  State CurrentState() const;

  // Whether a function of this actuator may run now, by the [capability.<name>] of the config; one
  // that is not declared runs in Active only. To be asked before each command that the function
  // obeys. While a callback runs it has to be allowed in the state that is left and in the one that
  // is entered; during an emergency stop nothing is. The Error has a sentence for people and the
  // code of `module`: 13, ProtectedError, where the robot spares itself (allowed in Active but not
  // in Protected, or the battery is too low or unknown), else 3, StateInvalid. From any thread;
  // costs less than a microsecond where the answer is yes.
  Result<> Allowed(const std::string& capability, ModuleCode module = ModuleCode::kRobot) const;

  // In the SelfCheck callback, before it returns Ok: part of the actuator does not work, and it can
  // do its work without. It passes the check and goes to Active; the reason and its code, which
  // must not be 0, are shown with it as degraded until its next self-check. The last call of a
  // check counts; in other callbacks it means nothing. From any thread.
  void ReportDegraded(const Error& why);

  // Whether an emergency stop is engaged. The callbacks of less active states run during one, and
  // then must not move what has been stopped. From any thread.
  bool EmergencyStopped() const;

  // Whether an emergency stop holds this actuator: one is engaged, or was, and no callback of the
  // present state or a higher one has ended well without a stop since: what OnEmergencyStop() has
  // switched off is off. Setting the present state again runs its callback. From any thread.
  bool HeldByStop() const;

  const std::string& name() const;

  // What was read by Init(), which must have succeeded.
  const MachineConfig& machine_config() const;
  // For topics and services of your own, in the SetUp callback: `open` runs on the loop and makes
  // them from what it is given. They are kept until Shutdown(), or until the next call of this.
  // Their handlers run on the loop and must come back at once: whatever takes time is not for them.
  // Fails when one of them could not be opened. In a trial there is no wire: `open` does not run.
  Result<> OpenEndpoints(const std::function<void(transport::Endpoints&)>& open);
  // Runs `work` between two handlers, on the loop, and waits for it: so a callback shares data with
  // them. From any thread but the loop's. In a trial it runs at once.
  void RunOnLoop(const std::function<void()>& work);

  // What those two stand on: the participant and its loop. There from Start() on, so in every state
  // callback; null before, after Shutdown(), and in a trial. What is made from it is made, used and
  // dropped on its loop. A class that keeps such things keeps the pointer too, and drops them in
  // its destructor, after Shutdown().
  std::shared_ptr<transport::NodeThread> node() const;

 protected:
  // An emergency stop is engaged: stop whatever moves, now. Runs on the process's loop thread,
  // beside a state callback that may be running; it must come back at once (set a flag, write a
  // zero) and must not block. Exceptions are caught. Until a person releases the stop, nothing
  // takes this actuator to a more active state. Once for each stop.
  virtual void OnEmergencyStop() {}

 private:
  friend class CallbackHarness;  // runs the callbacks without a machine, for tests
  Result<> CheckCallbacks() const;
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
