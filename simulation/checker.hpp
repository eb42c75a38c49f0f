#pragma once
// Checks the invariants of a simulated robot after every event, and reports the first violation. It
// goes by what the actuators do, not by what the controller assumes, wherever the two can differ.
// The events of the robot arrive here; the checker of each subject is called in turn, and its
// header names its invariants. Checked here: kMachineIsConsistent, kNoPastDeadline,
// kTearDownEndsProcesses, and that no actuator goes back to an older command (kNoStaleCommand).

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/simulation/authority_checker.hpp"
#include "musher/simulation/command_checker.hpp"
#include "musher/simulation/hold_checker.hpp"
#include "musher/simulation/invariant.hpp"
#include "musher/simulation/policy_checker.hpp"
#include "musher/simulation/policy_time_checker.hpp"
#include "musher/simulation/process_checker.hpp"
#include "musher/simulation/release_checker.hpp"
#include "musher/simulation/rest_checker.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/simulation/stop_checker.hpp"
#include "musher/simulation/switch_checker.hpp"
#include "musher/simulation/tear_down_checker.hpp"
#include "musher/simulation/user_rule_checker.hpp"

namespace musher::simulation {

class Checker {
 public:
  // Sets the robot's callbacks. The robot must outlive it.
  explicit Checker(SimRobot& robot);
  Checker(const Checker&) = delete;
  Checker& operator=(const Checker&) = delete;

  const std::optional<Violation>& violation() const { return context_.violation; }
  // Keeps the first one only.
  void ReportViolation(Invariant invariant, const std::string& what) {
    context_.ReportViolation(invariant, what);
  }
  // How many checks were made.
  std::uint64_t checks() const { return checks_; }

  // Call after every event of the network; cheap when no controller took a decision.
  void AfterEvent();
  // An operator requests a switch from a controller; OnReply() takes the number that it returns.
  std::uint64_t OnRequest(const SimulatedController& controller, const State& target);
  void OnReply(std::uint64_t request, const SwitchResult& result);
  // Call with every record of a controller.
  void OnRecord(const action::Record& record);
  // The same as OnRequest() and OnReply(), for requests to the policy.
  std::uint64_t OnPolicyRequest(const SimulatedController& controller,
                                const event::PolicyRequested& requested);
  void OnPolicyReply(std::uint64_t request, const event::PolicyRequested& requested,
                     const Result<>& reply);
  // An event hits the controllers that may cancel a power-off or, with `state_lost`, lose what they
  // have stored.
  void OnControllersBlocked(bool state_lost);
  // A controller is killed: its callers get no reply.
  void OnControllerKilled(const SimulatedController& controller);
  // A running process is about to exit with code 2 (configuration error).
  void OnWrongConfig(const std::string& name) { processes_.OnWrongConfig(name); }
  // It is killed, perhaps before it exits with code 2.
  void OnCrash(const std::string& name) { processes_.ForgetWrongConfig(name); }
  // An operator requests a restart.
  void OnRestartRequest(const std::string& name) { processes_.ForgetWrongConfig(name); }
  // An emergency stop is engaged at a panel.
  void OnStopEngaged(std::size_t panel, StopId id) { stops_.OnStopEngaged(panel, id); }
  // Another machine in the same network.
  void SetOther(const SimRobot& other) { authority_.SetOther(other); }
  // What the panels have engaged for every machine in reach, also before this checker was made.
  void TakeStopsOf(const Checker& other) { stops_.TakeStopsOf(other.stops_); }
  // A stop is meant for the other machine alone.
  void OnStopOfOther(StopId id) { stops_.OnStopOfOther(id); }
  // A program, numbered beside the panels, has engaged a stop, has ended with exit code 0, and
  // publishes the stop no more.
  void OnStopConfirmed(StopId id);
  void OnStopWithdrawn(StopId id) { stops_.OnStopWithdrawn(id); }
  // Faults of all links begin, or end.
  void OnLinkFaults(bool active);
  // A client requests a switch.
  void OnClientRequest(const State& target) { switches_.OnClientRequest(target); }
  // The actuator publishes a false state: its reports are no evidence from now on.
  void OnFalseReport(const std::string& name, const State& state) {
    context_.false_reporters[name] = state;
  }
  bool ReportsTearDownFalsely(const std::string& name) const {
    const auto found = context_.false_reporters.find(name);
    return found != context_.false_reporters.end() && found->second == kTearDown;
  }

  // Whether the state is stable: nothing is under way, and nothing will start by itself.
  bool AtRest() const { return PendingActivity().empty(); }
  // What is under way; empty: nothing.
  std::string PendingActivity() const { return rest_.PendingActivity(); }
  // The rules of the user, which are checked as well. Call before the first event.
  void SetUserRules(const UserRules& rules) { user_rules_.SetRules(rules); }
  UserRulesCoverage user_rules_coverage() const { return user_rules_.coverage(); }
  // Checks what must hold in a stable state. `provided`: also that the config's on_lost covers
  // every lost actuator.
  void CheckRest(bool provided);

 private:
  void OnReport(const std::string& name, std::size_t host, const ActuatorReport& report);
  void OnWrite(const SimulatedController& controller, const std::string& topic,
               const msg::Bytes& bytes);
  void CheckController(const SimulatedController& controller);
  void CheckDeadline(const SimulatedController& controller);

  CheckerContext context_;
  SimRobot& robot_;
  const MachineConfig& config_;
  std::uint64_t checks_ = 0;
  bool dirty_ = false;
  // By the serial of the controller: since when its next deadline has passed, and how often it was
  // checked since then.
  std::map<std::uint64_t, std::pair<Time, int>> over_since_;
  // Each calls only the ones above it.
  AuthorityChecker authority_{context_};
  ProcessChecker processes_{context_};
  ReleaseChecker release_{context_};
  CommandChecker commands_{context_, authority_, release_};
  TearDownChecker tear_down_{context_, processes_};
  HoldChecker holds_{context_, processes_};
  StopChecker stops_{context_, processes_, tear_down_, release_};
  PolicyChecker policy_{context_};
  PolicyTimeChecker policy_time_{context_};
  RestChecker rest_{context_};
  UserRuleChecker user_rules_{context_};
  SwitchChecker switches_{context_, commands_, tear_down_, holds_, policy_, rest_};
};

}  // namespace musher::simulation
