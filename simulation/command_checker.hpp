#pragma once
// Checks the commands of controllers at the actuators: each callback begins by one that is fresh,
// was requested and has a recorded reason, and an accepted command is dropped for a known reason
// only.
//
// Invariants: kNoStaleCommand, kNoCommandDropped, kNoUnrequestedActivation, kEmergencyStopHolds and
// kRisesAreRecorded (as a callback begins).

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "musher/simulation/authority_checker.hpp"
#include "musher/simulation/release_checker.hpp"

namespace musher::simulation {

class CommandChecker : public SubjectChecker {
 public:
  CommandChecker(CheckerContext& context, AuthorityChecker& authority, ReleaseChecker& release)
      : SubjectChecker(context), authority_(authority), release_(release) {}

  // Before a controller sends it.
  void OnSend(const Machine& machine, const action::SendSwitch& send);
  // A callback has begun.
  void OnBegun(const std::string& name, std::size_t host, const ActuatorReport& before,
               const ActuatorReport& report);
  // Commands that wait at an actuator.
  void CheckWaiting(const std::string& name, std::size_t host, const ActuatorReport& report);
  void CarryCommandsOver(std::uint64_t controller, Epoch from, Epoch to);
  void NoteGivenUp(Epoch epoch, ActuatorIndex i);
  // Whether the actuator entered its state without a command.
  bool HasSwitchedItself(const std::string& name) const { return self_switched_.contains(name); }

 private:
  using CommandKey =
      std::tuple<Epoch, ActuatorIndex, CommandNumber>;  // of the actuator with this index
  struct SentCommand {
    Time sent{};
    Duration budget{};
    bool may_rise = false;         // it may lead to a more active state
    std::uint64_t controller = 0;  // the serial of the controller that sent it
    bool has_reason = true;        // to lead to a more active state, among its records
    ReleaseChecker::Basis basis;
  };
  struct WaitingCommand {
    std::uint64_t process =
        0;  // its serial: after a boot of its host an incarnation may come again
    Incarnation incarnation = 0;
    Epoch epoch = 0;
    SwitchCommand command;
    bool stopped = false;  // the actuator has latched a stop meanwhile
  };

  bool MayRise(const Machine& machine, const State& target) const;
  bool IsGivenUp(const CommandKey& command) const;

  AuthorityChecker& authority_;
  ReleaseChecker& release_;
  std::map<CommandKey, SentCommand> sent_commands_;
  // The last that was given up, by epoch and actuator.
  std::map<std::pair<Epoch, ActuatorIndex>, CommandKey> given_up_;
  std::map<std::string, Time> self_switched_;  // entered their state without a command: when
  std::map<std::pair<std::string, std::size_t>, std::optional<WaitingCommand>> waiting_;
};

}  // namespace musher::simulation
