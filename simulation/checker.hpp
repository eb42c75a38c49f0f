#pragma once
// Checks the invariants of a simulated robot after every event, and reports the first violation. It
// goes by what the actuators do, not by what the controller assumes, wherever the two can differ.

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "musher/lifecycle/config/stable_rule.hpp"
#include "musher/simulation/invariant.hpp"
#include "musher/simulation/robot.hpp"

namespace musher::simulation {

class Checker {
 public:
  // Sets the robot's callbacks. The robot must outlive it.
  explicit Checker(SimRobot& robot);
  Checker(const Checker&) = delete;
  Checker& operator=(const Checker&) = delete;

  const std::optional<Violation>& violation() const { return violation_; }
  // Keeps the first one only.
  void ReportViolation(Invariant invariant, const std::string& what);
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
  void OnWrongConfig(const std::string& name);
  // It is killed, perhaps before it exits with code 2.
  void OnCrash(const std::string& name) { config_errors_.erase(name); }
  // An operator requests a restart.
  void OnRestartRequest(const std::string& name) { config_errors_.erase(name); }
  // An emergency stop is engaged at a panel.
  void OnStopEngaged(std::size_t panel, StopId id);
  // Another machine in the same network.
  void SetOther(const SimRobot& other) { other_ = &other; }
  // What the panels have engaged for every machine in reach, also before this checker was made.
  void TakeStopsOf(const Checker& other);
  // A stop is meant for the other machine alone.
  void OnStopOfOther(StopId id) { stops_of_other_.insert(id); }
  // A program, numbered beside the panels, has engaged a stop, has ended with exit code 0, and
  // publishes the stop no more.
  void OnStopConfirmed(StopId id);
  void OnStopWithdrawn(StopId id) { withdrawn_.insert(id); }
  // Faults of all links begin, or end.
  void OnLinkFaults(bool active);
  // A client requests a switch.
  void OnClientRequest(const State& target) {
    urgent_requested_ |= target == kError || target == kTearDown;
  }
  // The actuator publishes a false state: its reports are no evidence from now on.
  void OnFalseReport(const std::string& name, const State& state) {
    false_reporters_[name] = state;
  }
  bool ReportsTearDownFalsely(const std::string& name) const {
    const auto found = false_reporters_.find(name);
    return found != false_reporters_.end() && found->second == kTearDown;
  }

  // Whether the state is stable: nothing is under way, and nothing will start by itself.
  bool AtRest() const { return PendingActivity().empty(); }
  std::string PendingActivity() const;  // what is under way; empty: nothing
  // The user's own, which CheckRest() checks as well.
  std::vector<StableRule> stable_rules;
  // Checks what must hold in a stable state. `provided`: also that the config's on_lost covers
  // every lost actuator.
  void CheckRest(bool provided);

 private:
  struct SentCommand {
    Time sent{};
    Duration budget{};
    bool may_rise = false;         // it may lead to a more active state
    std::uint64_t controller = 0;  // the serial of the controller that sent it
    bool has_reason = true;        // to lead to a more active state, among its records
    bool requested = true;         // since the last emergency stop that its controller knows
    std::uint64_t order = 0;       // see Checker::order_
  };
  struct Mark {
    Time at{};            // of the network
    Duration by_clock{};  // the least that the policy's clock may have shown then
  };
  struct Seen {  // of a controller
    State state;
    bool stopped = false;
    bool requested = false;                // an operator or a client requested `requested_state`
    std::optional<State> requested_state;  // the target of the switch under way, if it was
                                           // requested or is a part of the start
    // Since when its next deadline has passed, and how often it was checked since then.
    std::optional<std::pair<Time, int>> over_since;
    PerActuator<Incarnation> received;  // of each actuator, the incarnation reported last
    // As for all controllers below: those of before its start, then its own.
    PerActuator<Duration> lost_at;
    Duration requested_state_at{};
    Epoch epoch = 0;
    Epoch began_with = 0;
    // When it last knew a sample of the battery that permits at most LowPower, or Protected.
    std::optional<Time> low_power_at;
    std::optional<Time> protected_at;
    CommandNumber raise;  // the last one of the policy
    bool starts = true;
    int raised = 0;  // how often its epoch has risen
    // Since when, by the policy's clock, the machine is in Active or Protected, and is kept.
    std::optional<Mark> awake;
    std::optional<Mark> kept;
    std::int64_t kept_for_s = 0;
    std::uint64_t stop_order = 0;      // when it last engaged a stop, see Checker::order_
    std::set<RecordId> requests = {};  // its records of requests
    std::set<RecordId> up = {};        // of them, those that lead up as far as the battery permits
    bool requests_up = false;          // the next record of a request to its policy is one
  };
  using CommandKey =
      std::tuple<Epoch, ActuatorIndex, CommandNumber>;  // of the actuator with this index

  void OnReport(const std::string& name, std::size_t host, const ActuatorReport& report);
  void OnWrite(const SimulatedController& controller, const std::string& topic,
               const msg::Bytes& bytes);
  void OnBegun(const std::string& name, std::size_t host, const ActuatorReport& before,
               const ActuatorReport& report);
  void CheckController(const SimulatedController& controller);
  void OnSend(const Machine& machine, const action::SendSwitch& send);
  std::uint64_t SerialOf(const Machine& machine) const;
  void CarryCommandsOver(std::uint64_t controller, Epoch from, Epoch to);
  void OnStart(const SimulatedController& controller, const std::string& name);
  bool MayRise(const Machine& machine, const State& target) const;
  void CheckDeadline(const SimulatedController& controller, Seen& seen);
  void CheckChange(const Machine& machine, Seen& seen);
  // Hosts and the processes on them.
  void CheckRunsNowhereElse(const SimulatedController& controller, const std::string& name);
  void CheckRunsOnce(const std::string& name);
  void CheckProgramRunsOnce(const SimulatedController& controller, const std::string& name);
  void CheckKill(const SimulatedController& controller, std::int32_t pid);
  void NoteOverrun(const std::string& name, std::size_t host, bool begun,
                   const ActuatorReport& report);
  bool IsWell(const SimulatedController& controller, const std::string& name) const;
  void CheckSignal(const SimulatedController& controller, std::int32_t pid);
  // Authority: the newest word of a person counts, and nothing rises without one.
  void NoteWord(const SimulatedController& controller, bool restarted);
  void CheckRaised(const SimulatedController& controller, Seen& seen, Epoch before);
  void CheckFollows(const std::string& name, std::size_t host, const ActuatorReport& report);
  void NoteReasons(const SimulatedController& controller, const action::Record& record);
  void CheckReason(const SimulatedController& controller, const State& before);
  bool HasReason(std::uint64_t controller, const State& from, const State& to) const;
  // Two machines in one network.
  void CheckMeant(const action::Record& record);
  void CheckFence(const SimulatedController& controller, const action::Record& record);
  void CheckControllerOf(const std::string& name, Sender controller);
  // Emergency stops, and an accepted TearDown.
  void OnStopPublished(const SimulatedController& controller, const msg::EmergencyStop& stop);
  bool ReleasedElsewhere() const;
  enum class Open { kNo, kMaybe, kYes };
  Open StopIsOpen() const;
  bool IsStopped(const std::string& name, std::size_t host, const ActuatorReport& report) const;
  void CheckStopsAtRest(const Machine& machine);
  void CheckStopped(const std::string& name, std::size_t host, const ActuatorReport& before,
                    const ActuatorReport& report);
  void NoteLatched(const std::pair<std::string, std::size_t>& actuator,
                   const ActuatorReport& before, const ActuatorReport& report);
  void CheckStaysStopped(const std::string& name, const ActuatorReport& before,
                         const ActuatorReport& report);
  // After a release: what was requested since the last stop.
  bool TakesNothingOver(const SimulatedController& controller) const;
  void CheckStart(const SimulatedController& controller, const action::SwitchNote& begun);
  void NoteRequest(const SimulatedController& controller, const action::Record& record);
  bool IsRequestedSinceStop(std::uint64_t controller, ActuatorIndex i, const State& target);
  std::uint64_t LastStopOf(std::uint64_t controller);
  void CheckAfterRelease(const std::string& name, std::size_t host, const ActuatorReport& before,
                         const ActuatorReport& report, const SentCommand& sent);
  // Permits to move.
  void NotePermitStops(const ActuatorCore& core);
  void CheckPermits();
  void CheckPower();
  void CheckReleased(const SimulatedController& controller, const Result<>& released);
  void CheckStaysDown(const SimulatedController& controller);
  bool RunsForAnother(const SimulatedController& asked, ActuatorIndex i, std::size_t host) const;
  void NoteReceived(const SimulatedController& controller, Seen& seen);
  bool IsKnown(const SimulatedController& controller, ActuatorIndex i, std::size_t host,
               const ActuatorReport& report) const;
  void CheckTornDown(const SimulatedController& controller, const SwitchResult& result);
  // Commands that wait at an actuator, clients' calls, and outcomes of switches.
  void CheckWaiting(const std::string& name, std::size_t host, const ActuatorReport& report);
  void NoteGivenUp(Epoch epoch, ActuatorIndex i);
  bool IsGivenUp(const CommandKey& command) const;
  void OnReplyWritten(const SimulatedController& controller, const std::string& service);
  void CheckClients();
  void CheckClientsAtRest();
  void CheckNotDegraded(const Machine& machine, const SwitchResult& result);
  bool ObeysAnother(const Machine& machine, const ActuatorReport& report) const;
  bool IsExcused(const Machine& machine, ActuatorIndex i, const SwitchResult& result) const;
  // The policy, by the samples of the battery alone.
  void CheckCeiling(const SimulatedController& controller, bool at_rest);
  void CheckPolicyChange(const Machine& machine, const Seen& seen);
  void ForgetEndedPolicySwitches(const Machine& machine);
  void CheckRaise(const State& raised_to, int percent);
  void CheckQuiet(const Machine& machine, Seen& seen);
  void OnBattery(int percent, bool charging);
  void CheckPowerOffStarted(const action::Record& record);
  void NoteLevels(const BatteryPolicy& policy, int percent);
  void CheckPowerOff();
  // By the clock that the policy follows.
  void OnClock(Time time);
  Duration PolicyTime() const;
  Mark MarkNow() const;
  void OnMotion(std::int32_t motion);
  bool JustMoved() const;
  static std::optional<Mark> LaterOf(const std::optional<Mark>& a, const std::optional<Mark>& b);
  void NotePolicyTimes(const SimulatedController& controller, Seen& seen);
  void CheckPolicyTime(const SimulatedController& controller, const action::Record& record);
  void CheckWaited(const SimulatedController& controller, const std::optional<Mark>& since,
                   Duration limit, const std::string& what);
  bool ByPolicy(const State& state) const;
  void NoteLowering(const State& from);

  // A stable state.
  void CheckStableRules(const Machine& machine);
  void CheckLoss(const Machine& machine, ActuatorIndex i, bool provided);
  void CheckPlace(const Machine& machine, ActuatorIndex i);
  void CheckPlaceInStart(const Machine& machine, ActuatorIndex i);
  std::string PendingActivity(const Machine& machine, ActuatorIndex i) const;

  SimRobot& robot_;
  const MachineConfig& config_;
  std::optional<Violation> violation_;
  std::uint64_t checks_ = 0;
  bool dirty_ = false;
  std::map<std::pair<std::string, std::string>, ActuatorReport> reports_;  // by actuator, host
  std::map<CommandKey, SentCommand> sent_commands_;
  // The last that was given up, by epoch and actuator.
  std::map<std::pair<Epoch, ActuatorIndex>, CommandKey> given_up_;
  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  struct Request {
    State target;
    std::uint64_t controller = 0;  // its serial
  };
  std::map<std::uint64_t, Request> open_requests_;  // that have no reply yet
  std::set<State> just_replied_;
  PerActuator<Duration> lost_at_;  // when each actuator was available for the last time
  Duration requested_state_at_{};  // when an operator's switch last ended in the requested state
  std::uint64_t next_request_ = 1;
  std::vector<State> policy_up_to_;  // the targets of its last switches
  std::vector<State> policy_down_to_;
  struct Level {
    int percent = 0;
    bool charging = false;
  };
  std::map<std::size_t, Level> level_on_;  // of a host: what a controller there knew last
  std::optional<int> raised_at_;           // the battery's percentage when it last decided to raise
  // The levels of Protected and LowPower; not reached, or not again since.
  std::array<bool, 2> left_ = {true, true};
  std::optional<State> checked_raise_;  // before its state was seen: a lowering began in that step
  bool lowering_begins_ = false;        // its switch is the next record
  std::optional<std::pair<State, State>> lowered_;  // by the battery: from, to
  std::size_t recording_host_ = 0;                  // of the controller that makes a record
  std::map<std::size_t, State> lowered_on_;  // by a controller of that host, which stores it: from
  bool raise_requested_ = false;             // possibly above what the battery permits
  bool state_lost_ = false;        // a disk was full: a controller may have stored outdated state
  bool urgent_requested_ = false;  // Error or TearDown, which supersede others
  std::optional<Time> power_due_;
  int empty_in_a_row_ = 0;        // samples of an empty battery that were published last
  int most_empty_in_a_row_ = 0;   // so far
  RecordId power_requested_ = 0;  // the record of the last request for a power-off
  // The actuators that exited with a configuration error, and the controller whose child each was.
  std::map<std::string, std::uint64_t> config_errors_;
  std::map<std::string, State> false_reporters_;  // the false state published last
  std::set<std::string> self_switched_;           // entered their state without a command
  std::set<std::string> duplicated_;  // started while the link to another process of it was cut
  std::map<StopId, std::size_t> engaged_;  // emergency stops: the panel
  std::map<std::size_t, StopId> last_of_panel_;
  std::map<StopId, std::set<std::size_t>> accepted_stops_;  // by controllers of these hosts
  std::map<StopId, std::set<std::size_t>> released_;        // stop: hosts that stored the release
  std::vector<std::pair<std::string, std::size_t>> idle_and_stopped_;  // actuator, host
  struct AcceptedTearDown {
    std::uint64_t controller = 0;  // its serial
    std::size_t host = 0;
  };
  std::optional<AcceptedTearDown> accepted_tear_down_;  // a TearDown was accepted
  // The processes of which controllers have received a report: the controller's host, actuator, the
  // host's id, incarnation.
  std::set<std::tuple<std::size_t, ActuatorIndex, std::string, Incarnation>> received_;
  struct Waiting {
    Incarnation incarnation = 0;
    Epoch epoch = 0;
    SwitchCommand command;
    bool stopped = false;  // the actuator has latched a stop meanwhile
  };
  std::map<std::pair<std::string, std::size_t>, std::optional<Waiting>> waiting_;
  struct RunningCallback {
    std::optional<Time> late_at;        // from then on its heartbeats report a hang
    std::optional<Time> overran_until;  // the end of the last one that they reported
  };
  std::map<std::pair<std::string, std::size_t>, RunningCallback> callbacks_;  // by actuator, host
  Time check_clients_at_{};
  std::map<std::uint64_t, Time> fenced_at_;  // by the serial of the controller
  // A person's word is a start or a takeover. A supervisor restarts a controller by the same word
  // by which the controller before it on this host was started.
  struct Word {
    std::uint64_t number = 0;               // grows with each
    std::uint64_t controller = 0;           // its serial
    std::map<std::uint64_t, Epoch> others;  // of the controllers that led then, by serial
    std::set<std::uint64_t> together;       // those that were starting as well
  };
  std::uint64_t words_ = 0;
  std::map<std::uint64_t, Word> word_of_;              // by the serial of the controller
  std::map<std::size_t, std::uint64_t> last_word_on_;  // of a host
  struct Followed {
    Incarnation incarnation = 0;
    Word word;  // the newest
  };
  std::map<std::pair<std::string, std::size_t>, Followed> followed_;  // by actuator, host
  // By the serial of the controller: the targets of requests and of the policy that it has
  // recorded, since nothing was under way.
  std::map<std::uint64_t, std::set<State>> reasons_;
  const SimRobot* other_ = nullptr;  // another machine in the network
  std::set<StopId> stops_of_other_;
  std::set<StopId> withdrawn_;       // by the programs that engaged them
  std::optional<Time> released_at_;  // when a controller last published a release
  std::map<StopId, Time> engaged_at_;
  std::optional<Time> link_faults_until_;  // of all links; max: they are under way
  // The order of stops, requests and commands; it grows with each.
  std::uint64_t order_ = 0;
  std::map<std::size_t, std::uint64_t>
      stopped_on_;  // when a controller of that host engaged a stop
  struct SinceStop {
    std::uint64_t order = 0;
    std::optional<ActuatorIndex> actuator;  // nullopt: of the machine
    State target;
    bool up = false;  // or on the level, or by a start: it may switch on
  };
  std::vector<SinceStop> since_stop_;  // requests that led somewhere
  // Controllers that found a folder that they may not read, until a state is requested, by serial.
  std::set<std::uint64_t> unanswered_;
  // When a person started a controller that took nothing over, by its serial.
  std::map<std::uint64_t, std::uint64_t> begun_by_a_person_;
  std::map<StopId, std::uint64_t> release_order_;  // of the stops that are over: when
  std::map<std::pair<std::string, std::size_t>, std::uint64_t> latched_;  // actuator, host: when
  std::map<Time, Time> permits_;  // given: the stamp, by the console's clock; when
  Time check_permits_at_{};
  // /clock, without its jumps: so much of it has passed at each of the last samples.
  Duration clock_passed_{};
  Duration clock_step_{};
  std::optional<Time> clock_;
  std::deque<std::pair<Time, Duration>> clock_samples_;  // when
  std::optional<Mark> still_;  // since when the body lies still, by its samples
  std::optional<Mark> still_before_;
  std::optional<Time> moved_at_;  // when it moved after that
};

}  // namespace musher::simulation
