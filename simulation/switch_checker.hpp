#pragma once
// Checks the machine's switches: the requests, the replies to them and to clients, the outcomes,
// and each change of the machine's state.
//
// Invariants: kOneReplyPerRequest, kDoneIsComplete, kPolicyNeverSupersedes, kOnlyLeaderReplies,
// kClientGetsOutcome, kStatesRecorded, kNoUnrequestedActivation and kEmergencyStopHolds (of the
// machine).

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "musher/simulation/command_checker.hpp"
#include "musher/simulation/hold_checker.hpp"
#include "musher/simulation/policy_checker.hpp"
#include "musher/simulation/rest_checker.hpp"
#include "musher/simulation/tear_down_checker.hpp"

namespace musher::simulation {

class SwitchChecker : public SubjectChecker {
 public:
  SwitchChecker(CheckerContext& context, const CommandChecker& commands, TearDownChecker& tear_down,
                HoldChecker& holds, PolicyChecker& policy, RestChecker& rest)
      : SubjectChecker(context),
        commands_(commands),
        tear_down_(tear_down),
        holds_(holds),
        policy_(policy),
        rest_(rest) {}

  // As Checker's functions of the same names.
  std::uint64_t OnRequest(const SimulatedController& controller, const State& target);
  void OnReply(std::uint64_t request, const SwitchResult& result);
  void OnClientRequest(const State& target) {
    urgent_requested_ |= target == kError || target == kTearDown;
  }
  // Returns whether the request was open.
  bool OnPolicyReply(std::uint64_t request, const event::PolicyRequested& requested);
  void OnControllerKilled(const SimulatedController& controller);

  // A request for that state has a reply, or a record: the machine may be in it after this step.
  void NoteReplied(const State& target) { just_replied_.insert(target); }
  void ForgetReplied() { just_replied_.clear(); }
  // The machine's state after the step before; empty: the controller has made none.
  const State& StateOf(const SimulatedController& controller) {
    return seen_[controller.serial()].state;
  }
  void CheckChange(const SimulatedController& controller);
  // A controller writes a reply to a client.
  void OnReplyWritten(const SimulatedController& controller, const std::string& service);
  void CheckClients();
  void CheckAtRest();
  void CheckClientsAtRest();

 private:
  struct Seen {  // of a controller
    State state;
    bool stopped = false;
    bool requested = false;                // an operator or a client requested `requested_state`
    std::optional<State> requested_state;  // the target of the switch under way, if it was
                                           // requested or is a part of the start
  };
  struct Request {
    State target;
    std::uint64_t controller = 0;  // its serial
  };

  void CheckNotDegraded(const Machine& machine, const SwitchResult& result);
  void CheckSecondProcesses(const SimulatedController& controller, const SwitchResult& result);
  bool HasArrived(const SimulatedController& controller, const std::string& name,
                  std::size_t host) const;
  bool ObeysAnother(const Machine& machine, const ActuatorReport& report) const;
  bool IsExcused(const Machine& machine, ActuatorIndex i, const SwitchResult& result) const;

  const CommandChecker& commands_;
  TearDownChecker& tear_down_;
  HoldChecker& holds_;
  PolicyChecker& policy_;
  RestChecker& rest_;
  std::map<std::uint64_t, Seen> seen_;              // by the serial of the controller
  std::map<std::uint64_t, Request> open_requests_;  // that have no reply yet
  std::set<State> just_replied_;
  std::uint64_t next_request_ = 1;
  bool urgent_requested_ = false;  // Error or TearDown, which supersede others
  Time check_clients_at_{};
  std::map<std::uint64_t, Time> fenced_at_;  // by the serial of the controller
};

}  // namespace musher::simulation
