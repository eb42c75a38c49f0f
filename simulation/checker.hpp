#pragma once
// Looks at a simulated robot after every event, and says when a invariant does not hold. It judges
// by what the actuators do, not by what the controller believes, wherever that can be told apart.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "musher/simulation/invariant.hpp"
#include "musher/simulation/robot.hpp"

namespace musher::simulation {

class Checker {
 public:
  // Hangs itself into the robot, which must outlive it.
  explicit Checker(SimRobot& robot);
  Checker(const Checker&) = delete;
  Checker& operator=(const Checker&) = delete;

  const std::optional<Violation>& violation() const { return violation_; }
  // The first one counts.
  void ReportViolation(Invariant invariant, const std::string& what);
  // How often something was judged.
  std::uint64_t checks() const { return checks_; }

  // To be called after every event of the network; cheap when no decision was taken.
  void AfterEvent();
  // A person asks a controller for a switch; whoever answers tells what he gets.
  std::uint64_t Asked(const ControllerProcess& controller, const State& target);
  void Answered(std::uint64_t request, const SwitchResult& result);
  // To be called with every record of a controller.
  void OnRecord(const action::Record& record);
  // The same as Asked() and Answered(), of what is asked of the policy.
  std::uint64_t AskedPolicy(const ControllerProcess& controller,
                            const event::PolicyRequested& asked);
  void AnsweredPolicy(std::uint64_t request, const event::PolicyRequested& asked,
                      const Result<>& answer);
  // Something befalls the controllers that may cost them a power-off, or what they remember.
  void ControllersBlocked(bool forgetful);
  // A controller is killed: its callers get no answer.
  void ControllerKilled(const ControllerProcess& controller);
  // A process that lives finds its configuration wrong, and is about to end with exit code 2.
  void FindsConfigWrong(const std::string& name);
  // A person asks for a restart.
  void AskedRestart(const std::string& name) { final_.erase(name); }
  // An emergency stop is engaged at a panel.
  void StopEngaged(std::size_t panel, std::uint64_t id);
  // A client asks for a switch.
  void ClientAsks(const State& target) { urgent_asked_ |= target == kError || target == kTearDown; }
  // What it says is no evidence from now on.
  void Lied(const std::string& name) { liars_.insert(name); }

  // Whether nothing is going on, and nothing will by itself.
  bool AtRest() const { return Unrest().empty(); }
  std::string Unrest() const;  // what is going on; empty: nothing
  // What has to hold then. `provided`: also that the config says what follows from every loss.
  void CheckRest(bool provided);

 private:
  struct SentOrder {
    Time sent{};
    Duration budget{};
    bool may_rise = false;
  };
  struct Seen {  // of a controller
    State state;
    bool stopped = false;
    bool requested = false;      // `asked` is, by a person or a client
    std::optional<State> asked;  // the target of the switch under way, if a person or the start is
                                 // behind it
    // Since when its next deadline is over, and how often it was looked at meanwhile.
    std::optional<std::pair<Time, int>> over_since;
  };
  using OrderKey =
      std::tuple<std::uint64_t, std::size_t, std::uint64_t>;  // epoch, actuator, number

  void OnReport(const std::string& name, std::size_t host, const ActuatorReport& report);
  void OnWrite(const ControllerProcess& controller, const std::string& topic,
               const msg::Bytes& bytes);
  void OnBegun(const std::string& name, const ActuatorReport& before, const ActuatorReport& report);
  void LookAt(const ControllerProcess& controller);
  void OnSend(const Machine& machine, const action::SendSwitch& command);
  void OnStart(const ControllerProcess& controller, const std::string& name);
  bool MayRise(const Machine& machine, const State& target) const;
  void CheckDeadline(const ControllerProcess& controller, Seen& seen);
  void CheckChange(const Machine& machine, Seen& seen);
  // host_invariants.cpp
  void CheckRunsNowhereElse(const ControllerProcess& controller, const std::string& name);
  void CheckRunsOnce(const std::string& name);
  void CheckProgramRunsOnce(const ControllerProcess& controller, const std::string& name);
  void CheckSignal(const ControllerProcess& controller, std::int32_t pid);
  // stop_invariants.cpp
  void OnStopPublished(const ControllerProcess& controller, const msg::EmergencyStop& stop);
  bool ReleasedElsewhere() const;
  bool StopIsOpen() const;
  void CheckStopsAtRest(const Machine& machine);
  void CheckStopped(const std::string& name, std::size_t host, const ActuatorReport& before,
                    const ActuatorReport& report);
  void CheckPower();
  void PersonStarts() { stop_asked_.reset(); }
  void CheckStaysDown(const ControllerProcess& controller);
  bool RunsForAnother(const ControllerProcess& asked, std::size_t i, std::size_t host) const;
  void CheckTornDown(const ControllerProcess& controller, const SwitchResult& result);
  // command_invariants.cpp
  void CheckWaiting(const std::string& name, std::size_t host, const ActuatorReport& report);
  bool IsGivenUp(std::uint64_t epoch, std::size_t i) const;
  void OnReplyWritten(const ControllerProcess& controller, const std::string& service);
  void CheckClients();
  void CheckClientsAtRest();
  // judge_policy.cpp
  void CheckCeiling(const Machine& machine, bool at_rest);
  void CheckPolicyChange(const Machine& machine, const Seen& seen);
  void CheckRaise(const State& raised_to, int percent);
  void NoteLevels(const BatteryPolicy& policy, int percent);
  void CheckPowerOff();
  bool ByPolicy(const State& state) const;

  void CheckLoss(const Machine& machine, std::size_t i, bool provided);
  void CheckPlace(const Machine& machine, std::size_t i);
  std::string Unrest(const Machine& machine, std::size_t i) const;
  void CheckNotDegraded(const Machine& machine, const SwitchResult& result);
  bool IsExcused(const Machine& machine, std::size_t i, const SwitchResult& result) const;

  SimRobot& robot_;
  const MachineConfig& config_;
  std::optional<Violation> violation_;
  std::uint64_t checks_ = 0;
  bool dirty_ = false;
  std::map<std::pair<std::string, std::string>, ActuatorReport> reports_;  // by actuator, host
  std::map<OrderKey, SentOrder> orders_;
  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  struct Request {
    State target;
    std::uint64_t controller = 0;  // its serial
  };
  std::map<std::uint64_t, Request> open_;  // requests that are not answered
  std::set<State> just_answered_;
  std::vector<Duration> lost_at_;  // when an actuator was there for the last time
  Duration went_on_{};  // when a person's switch ended with the machine in the state that was asked
  std::uint64_t next_request_ = 1;
  std::vector<State> policy_up_to_;  // the targets of its last switches
  std::vector<State> policy_down_to_;
  std::optional<int> raised_at_;  // percent of the battery when it last decided to raise
  std::array<bool, 2> left_{};    // the levels of Protected and LowPower, and not reached again
  std::optional<State> judged_raise_;  // before its state was seen: a lowering began in that step
  bool lowering_begins_ = false;       // its switch is the next record
  std::optional<std::pair<State, State>> lowered_;  // by the battery: from, to
  bool woken_ = false;         // somebody wanted more than the battery may have allowed
  bool forgetful_ = false;     // a disk was full: a controller may remember what is over
  bool urgent_asked_ = false;  // for Error or TearDown, which supersede others
  std::optional<Time> power_due_;
  // Who ended for good, since a new start does not help, and the controller whose child it was.
  std::map<std::string, std::uint64_t> final_;
  std::set<std::string> liars_;
  std::set<std::string> on_its_own_;              // went where it is without a command
  std::set<std::string> twice_;                   // started while another one could not be heard
  std::map<std::uint64_t, std::size_t> engaged_;  // emergency stops: the panel
  std::map<std::size_t, std::uint64_t> last_of_panel_;
  std::set<std::uint64_t> taken_up_;                         // by a controller
  std::map<std::uint64_t, std::set<std::size_t>> released_;  // by the hosts that know of it
  std::vector<std::pair<std::string, std::size_t>> free_and_stopped_;  // actuator, host
  struct StopAsked {
    std::uint64_t controller = 0;  // its serial
    std::size_t host = 0;
  };
  std::optional<StopAsked> stop_asked_;  // a TearDown was accepted
  struct Waiting {
    std::uint64_t incarnation = 0;
    std::uint64_t epoch = 0;
    SwitchCommand command;
  };
  std::map<std::pair<std::string, std::size_t>, std::optional<Waiting>> waiting_;
  Time check_clients_at_{};
  std::map<std::uint64_t, Time> fenced_at_;  // by the serial of the controller
};

}  // namespace musher::simulation
