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
// Threads: call the functions below from your threads, one at a time. State callbacks run one at a
// time on a worker thread of this actuator; meanwhile the process keeps answering queries. A
// callback may block for as long as its time in the config; after that it is requested to stop
// (StopRequested()) and the machine continues without it. A loop thread of the process does the
// communication.
//
// A callback that fails leaves the actuator in its previous state, and the controller may then run
// that state's callback again to clean up: callbacks must be idempotent.
//
// Errors: Run() and Check() log them; the other calls return them. The calls of CyberDog's library
// are in cyberdog/machine.hpp.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/base/code.hpp"
#include "musher/base/log.hpp"
#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::transport {
class Endpoints;
}  // namespace musher::transport

namespace musher {

class CallbackHarness;

class MachineActuator {
 public:
  // The name as in [controller].actuators of the config.
  explicit MachineActuator(const std::string& actuator_name);
  // An actuator is started by Run(), which returns when it is stopped, or by an ActuatorRunner,
  // whose destructor stops it: callbacks never use destroyed members. A derived class that calls
  // Start() in a function of its own has to be stopped before it is destroyed; its destructor ends
  // the program otherwise.
  virtual ~MachineActuator();
  MachineActuator(const MachineActuator&) = delete;
  MachineActuator& operator=(const MachineActuator&) = delete;

  // Reads and validates the state config. `config_file` empty: $MUSHER_CONFIG, which a controller
  // sets for the processes that it starts. `node`: to share one participant among the actuators of
  // a process; null: creates its own.
  Result<> Init(const std::string& config_file = "",
                std::shared_ptr<transport::NodeThread> node = nullptr);

  // Registers the callback of `state`; before Start(). The callback returns CyberDog's code, 0 =
  // done.
  void RegisterStateCallback(const State& state, std::function<std::int32_t()> callback);
  // The same with a reason for people; an Error's code must not be 0. An exception counts as
  // Failed.
  void RegisterStateCallback(const State& state, std::function<Result<>()> callback);
  // Registers the callback for each state that the config lists for this actuator and that has no
  // callback of its own; it gets the state. A state that is not listed is never commanded.
  void RegisterStateCallback(std::function<std::int32_t(const State&)> callback);
  void RegisterStateCallback(std::function<Result<>(const State&)> callback);

  // Blocks until TearDown is done, or GiveUp() or Shutdown() is called; then shuts down, so that no
  // callback runs any more, and returns the program's exit code. In a process of several actuators
  // each leaves the machine by its own Wait().
  int Wait();

  // Init(), Start() and Wait(): the main function of a program that is this actuator. Returns its
  // exit code: kConfigurationError if the config is invalid or does not fit the callbacks (the
  // controller does not restart such an actuator automatically), 1 if SetUp fails or it cannot
  // start now, else that of Wait().
  static constexpr int kConfigurationError = 2;
  int Run(const std::string& config_file = "");
  // Only checks the config: 0 if Run() would continue with SetUp, else kConfigurationError.
  int Check(const std::string& config_file = "");

  // Writes a line to stderr, which is the actuator's log: its name, the level unless it is info,
  // and the text. MUSHER_LOG in the environment is the lowest level that is written. An Error with
  // a code other than 0 is a warning and has its code. Lines of several threads do not mix. From
  // any thread.
  void Log(const std::string& text) const;
  void Log(LogLevel level, const std::string& text) const;
  void Log(const Error& error) const;

  // The actuator cannot continue: prints the reason to stderr and makes Wait() return 1, so that
  // the program exits and its restart policy applies. From any thread.
  void GiveUp(const Error& why);

  // Stops without TearDown: waits for a running callback, then leaves the machine. Idempotent.
  void Shutdown();

  // Inside a long callback: whether the controller no longer waits for it, or an emergency stop was
  // engaged while it leads up. The callback should then return at the next safe point.
  bool StopRequested() const;

  // Reports that the calling thread makes progress; its next checkpoint must follow within
  // `allowance` (zero: checkpoint_ms of the config; without that nothing is watched). A thread that
  // gives no checkpoint for longer although it could have run is *hung*: the process is restarted
  // by its policy.
  //   - In a state callback: watched from its beginning until its end.
  //   - In each thread of your own, for example the robot's control cycle: watched from its first
  //     checkpoint until the next state callback begins, or Checkpoint(kNoMore), needed before the
  //     thread ends. Its first one after that callback watches it again: callbacks may stop it.
  // Callable from any thread; costs less than a microsecond.
  static constexpr std::chrono::nanoseconds kNoMore = std::chrono::nanoseconds::max();
  void Checkpoint(std::chrono::nanoseconds allowance = std::chrono::nanoseconds(0));

  // The actuator's current state; the config's default state before SetUp is done. From any thread.
  State CurrentState() const;

  // Whether a function of this actuator may run now, according to [capability.<name>] of the
  // config; an undeclared function runs in Active only. Call it before each command of the
  // function. While a callback runs, the function must be allowed both in the state that is left
  // and in the state that is entered; during an emergency stop no function is allowed. The Error
  // has a sentence for people and the code of `module`: 13, ProtectedError, if the robot protects
  // itself (allowed in Active but not in Protected, or the battery is too low or unknown), else 3,
  // StateInvalid. From any thread; costs less than a microsecond if allowed.
  Result<> Allowed(const std::string& capability, ModuleCode module = ModuleCode::kRobot) const;

  // In the SelfCheck callback, before it returns Ok: reports that part of the actuator does not
  // work but the actuator can work without it. The actuator passes the check and goes to Active;
  // status shows it as degraded with the reason and its code, which must not be 0, until its next
  // self-check. The last call of a check counts; in other callbacks it has no effect. From any
  // thread.
  void ReportDegraded(const Error& why);
  // On the loop, in a handler or a timer: reports that part of the actuator has failed since its
  // self-check. Status shows it as degraded with the reason and its code, until its next
  // self-check, or until this is called with the same message and code 0. No effect in a
  // fault-injection test without transport.
  void ReportFault(const Error& fault);
  // What OnEmergencyStop() has begun and another thread ends is not done yet, or could not be done:
  // until this is called with "", the stop counts as not confirmed, with this reason. To be called
  // in OnEmergencyStop(), then from any thread.
  void ReportStopTrouble(const std::string& trouble);

  // Whether an emergency stop is engaged. The callbacks of less active states also run during a
  // stop, and must not move then. From any thread.
  bool EmergencyStopped() const;

  // Whether an emergency stop holds this actuator: a stop is engaged, or was, and since its release
  // no callback of the current or a higher state has succeeded. Functions that OnEmergencyStop()
  // has switched off are still off. Setting the current state again runs its callback. From any
  // thread.
  bool HeldByStop() const;

  const std::string& name() const;

  // The config that Init() has read; Init() must have succeeded.
  const MachineConfig& machine_config() const;
  // For topics and services of your own, in the SetUp callback: `open` runs on the loop and creates
  // them. They are kept until Shutdown(), or until the next call of this function. Their handlers
  // run on the loop and must return at once. Fails if one of them could not be opened. In a
  // fault-injection test without `make_node` there is no transport: `open` does not run.
  Result<> OpenEndpoints(const std::function<void(transport::Endpoints&)>& open);
  // Runs `work` on the loop, between two handlers, and waits for it, so that a callback can share
  // data with handlers. From any thread except the loop's. In a fault-injection test it runs at
  // once.
  void RunOnLoop(const std::function<void()>& work);

  // The participant and its loop, which both functions above use. Available from Start() on, so in
  // every state callback; null before, after Shutdown(), and in a fault-injection test without
  // `make_node`. Objects made from it must be created, used and dropped on its loop. A class that
  // keeps such objects must keep the pointer too, and drop them on the loop in its destructor; by
  // then it is shut down.
  std::shared_ptr<transport::NodeThread> node() const;

 protected:
  // Public in ActuatorRunner. Runs SetUp and becomes visible to the controller. Fails if a state of
  // the config has no callback or a callback no state (the error names it), if SetUp fails (with
  // its code), or if an actuator of this name already runs on this host. Once for each object:
  // after a failure it is shut down, Wait() returns 1, and the program should exit.
  Result<> Start();

  // Whether Start() has succeeded and Shutdown() has not been called since.
  bool started() const;

  // In a fork of the process, which has none of its threads: gives up its hold of the name, which
  // the parent keeps. It must not be used or destroyed there any more.
  void LeaveToParent();

  // An emergency stop is engaged: stop all motion now. Runs on the process's loop thread, possibly
  // beside a running state callback; it must return at once (set a flag, write a zero) and must not
  // block. Exceptions are caught. Until a person releases the stop, this actuator does not switch
  // to a more active state. Called for each stop, and again at the end of a callback that was
  // running: must be idempotent. A callback on the way up is requested to stop; until it has ended
  // the stop counts as not confirmed.
  virtual void OnEmergencyStop() {}

 private:
  friend class CallbackHarness;  // runs the callbacks without a machine, for tests
  Result<> CheckCallbacks() const;
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// An actuator that is started by hand, in a test or beside others of its process:
//
//   ActuatorRunner<Gripper> gripper(...);  // the arguments of Gripper's constructor
//   const auto begun = gripper.Init(config, node);
//   const auto started = begun ? gripper.Start() : begun;
//   if (!started) gripper.Log(started.error());
//
// It is a Gripper; when it is destroyed, its callbacks end before its members do.
template <typename Actuator>
class ActuatorRunner final : public Actuator {
 public:
  using Actuator::Actuator;
  using Actuator::Start;
  ~ActuatorRunner() override { this->Shutdown(); }
};

}  // namespace musher
