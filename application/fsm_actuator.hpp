#pragma once
// The base class of an application that is written as a state machine (behavior/fsm): an actuator
// that runs the machine while the robot is Active and pauses it in every other state.
//
//   class Show : public musher::FsmActuator {
//    public:
//     Show() : FsmActuator("show", {.rate_hz = 50}) {}
//     ~Show() override { Shutdown(); }  // its hooks use the members below
//
//    private:
//     Result<> BuildMachine(fsm::Machine& machine) override {
//       machine.Add("IDLE", std::make_unique<Idle>(data_));
//       ...
//       return machine.Build("IDLE");
//     }
//     void OpenTopics(transport::Endpoints& topics) override {
//       topics.Hear<msg::String>("show/command", [this](const msg::String& word) { ... });
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
//   SelfCheck      SelfCheck() is asked
//   Active         is started, or goes on where it was (or anew: Options::resume); ticks
//   TearDown       is stopped: its state is left; OnPause()
//   all others     rests, its time stands still; OnPause()
//   an emergency stop: OnPause() at once, and it rests until the stop is released and Active is set
//                  again, also where the robot is in Active still
//                  (during SetUp nothing moves yet: there is nothing to pause)
// clang-format on
//
// A machine that stops because its safe state failed, or because it has none, ends the process with
// a code that is not 0, so that its restart policy acts. A state that blocks blocks the loop: with
// checkpoint_ms in the config the actuator is then called hung.
//
// Others see it by `<actuator>/get_behavior` (musher behavior, musher graph --behavior) and
// `<actuator>/behavior_state` (std_msgs/String, latched: "PHOTO/COUNTDOWN"; "" when it does not
// run), and send it its commands by `<actuator>/send_command` (musher behavior --send).
//
// In a trial (simulation/actuator_fault_test.hpp) there is neither wire nor clock: the machine is
// built, started, paused and stopped, and is not ticked.
//
// Threads: the machine, the hooks and the handlers of topics run on the loop, one at a time, so
// they share data without locks. BuildMachine() and SelfCheck() run on the actuator's worker. All
// times are the machine's, see [controller] clock: a world at four times the speed ticks four times
// as often.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/behavior/fsm/machine.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher {

class FsmActuator : public MachineActuator {
 public:
  enum class Resume : std::uint8_t {
    kWhereItWas,
    kAnew  // Machine::Reset(): the start state, no commands
  };
  struct Options {
    double rate_hz = 50;  // of ticks; more than 0
    Resume resume = Resume::kWhereItWas;
    fsm::Machine::Options machine{};  // a name that is left as it is becomes the actuator's
  };

  explicit FsmActuator(const std::string& actuator_name) : FsmActuator(actuator_name, Options{}) {}
  FsmActuator(const std::string& actuator_name, Options options);
  ~FsmActuator() override;

  // The same as Init().
  Result<> Prepare(const std::string& state_config = "") { return Init(state_config); }

 protected:
  // In SetUp: register states, events and safety checks, and Build(). A failure fails SetUp.
  virtual Result<> BuildMachine(fsm::Machine& machine) = 0;
  // After that, on the loop: topics and services. Their handlers may look at the machine, Send()
  // commands, force and reset it. Does not run in a trial, where there is no wire.
  virtual void OpenTopics(transport::Endpoints& /*topics*/) {}
  // Whether what it needs is there. May take its time.
  virtual Result<> SelfCheck() { return Ok(); }

  // Around each tick. An exception is told, and the machine goes to its safe state as if one of its
  // states had failed; it runs there, and is back there at the end of each tick that had one.
  virtual void BeforeTick(Time /*now*/) {}
  virtual void AfterTick(Time /*now*/) {}
  // The robot has gone to a state in which the machine rests, or was stopped in an emergency: bring
  // the outputs to neutral. Comes back at once; may come twice. An exception is told.
  virtual void OnPause() {}
  // It goes to Active; before the machine is started or goes on. An exception fails the switch to
  // Active with its words, after OnPause().
  virtual void OnResume() {}

  // From SetUp on. On the loop only.
  fsm::Machine& machine();
  // A command from outside, for the machine to handle: that of <actuator>/send_command, and the one
  // to be called by handlers of topics. Fails when the machine rests, so that nothing is done hours
  // later, and where Machine::Send() does. On the loop only.
  Result<> Send(std::string_view command);
  // Whether the machine is ticked now. On the loop only.
  bool ticking() const;
  // What the machine's clock says. On the loop only.
  Time Now() const;
  // The same as messages are stamped, see transport::Clock; nothing where there is no wire.
  msg::Stamp Stamp() const;
  void OnEmergencyStop() override;

 private:
  // What the states of the robot mean is said above; beside it a callback of one's own would keep
  // the machine from hearing of its state. OnPause() and OnResume() are the places.
  using MachineActuator::RegisterStateCallback;

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
