#pragma once
// The base class of an application that is written as a state machine (behavior/fsm): an actuator
// that runs the machine while the robot is Active and pauses it in every other state.
//
//   class Show : public musher::FsmActuator {
//    public:
//     Show() : FsmActuator("show", {.rate_hz = 50}) {}
//
//    private:
//     Result<> BuildMachine(fsm::Machine& machine) override {
//       machine.Add("IDLE", std::make_unique<Idle>(data_));
//       ...
//       return machine.Build("IDLE");
//     }
//     void OpenTopics(transport::Endpoints& topics) override {
//       topics.Subscribe<msg::String>("show/command", [this](const msg::String& word) {
//         if (const Result<> timely = CheckNotLate(); !timely) return Log(timely.error());
//         ...
//       });
//     }
//     void AfterTick(Time now) override { ... publish what the states have put into data_ ... }
//     void OnPause() override { ... bring the outputs to neutral ... }
//
//     ShowData data_;
//   };
//
//   int main() {
//     Show show;
//     return show.Run();
//   }
//
// clang-format off
//   robot          machine
//   SetUp          is built; topics are opened
//   SelfCheck      SelfCheck() is called
//   Active         is started, or continues in its state (or from the start: Options::resume); ticks
//                  (with Begin::kOnCommand, once START was sent to it since its process began)
//   TearDown       is stopped: its state is left; OnPause()
//   all others     is paused, its time stands still; OnPause()
//   an emergency stop: OnPause() at once, and it is paused until the stop is released and Active is
//                  set again, also where the robot is still in Active
//                  (during SetUp nothing moves yet: there is nothing to pause)
//   its process could not run for more than a minute: is stopped, OnPause(), and begins as after a
//                  restart of its process (with Begin::kOnCommand, by START)
// clang-format on
//
// A machine that its application stops, by Machine::Stop(), has ended: it begins again by START,
// and neither by a pause nor after an emergency stop.
//
// A machine that stops because its safe state failed, or because it has none, ends the process with
// a non-zero exit code, so that its restart policy applies. A state that blocks blocks the loop:
// with checkpoint_ms in the config the actuator is then reported as hung.
//
// Interfaces: service `<actuator>/get_behavior` (musher behavior, musher graph --behavior), topic
// `<actuator>/behavior_state` (std_msgs/String, latched: "PHOTO/COUNTDOWN"; "" when it does not
// run), and service `<actuator>/send_command` for its commands (musher behavior --send).
//
// In a fault-injection test (simulation/actuator_fault_test.hpp) there is neither transport nor
// clock: the machine is built, started, paused and stopped, and is not ticked.
//
// Threads: the machine, the hooks and the handlers of topics run on the loop, one at a time, so
// they share data without locks. BuildMachine() and SelfCheck() run on the actuator's worker. All
// times are the machine's, see [controller] clock: a world at four times the speed ticks four times
// as often.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/application/begin.hpp"
#include "musher/behavior/fsm/machine.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher {

class FsmActuator : public MachineActuator {
 public:
  enum class Resume : std::uint8_t {
    kWhereItWas,
    kFromStart  // Machine::Reset(): the start state, no commands
  };
  struct Options {
    double rate_hz = 50;             // of ticks; more than 0
    Begin begin = Begin::kAtActive;  // its start state stands, and waits for a command
    Resume resume = Resume::kWhereItWas;
    fsm::Machine::Options machine{};  // a default name is replaced by the actuator's
    // After more than a minute in which its process could not run. False: the application finds
    // that out itself (transport/loop_breaks.hpp).
    bool ends_after_break = true;
  };

  explicit FsmActuator(const std::string& actuator_name) : FsmActuator(actuator_name, Options{}) {}
  FsmActuator(const std::string& actuator_name, Options options);
  ~FsmActuator() override;

  // The same as Init().
  Result<> Prepare(const std::string& state_config = "") { return Init(state_config); }

 protected:
  // In SetUp: register states, events and safety checks, and Build(). A failure fails SetUp.
  virtual Result<> BuildMachine(fsm::Machine& machine) = 0;
  // After that, on the loop: topics and services. Their handlers may read the machine, Send()
  // commands, force and reset it. Not called in a fault-injection test, where there is no
  // transport.
  virtual void OpenTopics(transport::Endpoints& /*topics*/) {}
  // Whether its dependencies are available. May block.
  virtual Result<> SelfCheck() { return Ok(); }

  // Before and after each tick. An exception is logged, and the machine goes to its safe state as
  // if one of its states had failed; it runs there, and returns there at the end of each tick with
  // an exception.
  virtual void BeforeTick(Time /*now*/) {}
  virtual void AfterTick(Time /*now*/) {}
  // The robot is in a state in which the machine is paused, or an emergency stop was engaged:
  // bring the outputs to neutral. Must return at once and be idempotent. An exception is
  // logged, and shown in the status until a further pause succeeds.
  virtual void OnPause() {}
  // The robot goes to Active; called before the machine is started or continues. An exception fails
  // the switch to Active with its text, after OnPause().
  virtual void OnResume() {}

  // The state machine; available from SetUp on. On the loop only.
  fsm::Machine& machine();
  // Sends a command to the machine: called by <actuator>/send_command, and by handlers of topics.
  // Fails when the machine is paused, so that no command is executed hours later, and when
  // Machine::Send() fails. On the loop only.
  Result<> Send(std::string_view command);
  // The same for a command that carries data (behavior/fsm/event.hpp).
  template <class T>
  Result<> Send(std::string_view command, T data) {
    const Result<> ready = CheckTicking();
    return ready ? machine().Send(command, std::move(data)) : ready;
  }
  // Whether the machine is ticked now. On the loop only.
  bool ticking() const;
  // The time of the machine's clock. On the loop only.
  Time Now() const;
  // The same as a stamp of messages, see transport::Clock; zero without a transport.
  msg::Stamp Stamp() const;
  // Fails where this process could not run just now (base/break_watch.hpp): a command that has just
  // arrived may be as old. For commands that move the robot by topics of the application;
  // <actuator>/send_command has it. On the loop only.
  Result<> CheckNotLate() const;
  void OnEmergencyStop() override;

 private:
  Result<> CheckTicking() const;
  // Not available: a callback of a derived class would replace the one that runs the machine. Use
  // OnPause() and OnResume() instead.
  using MachineActuator::RegisterStateCallback;

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
