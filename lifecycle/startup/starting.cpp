// Brings the machine up: processes in the order of `stage` and `after`, the first stage through
// SelfCheck to Active, or adoption of running actuators; later stages while the machine is in use.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// The record that Begin makes is the first one.
constexpr std::uint64_t kBegun = 1;
// How long a supervisor's start that finishes a TearDown waits for unknown actuators. They run
// already, and are discovered within a second.
constexpr Duration kFinishingGrace = std::chrono::seconds(3);

}  // namespace

int LastStage(const MachineConfig& config) {
  int last = 1;
  for (const ActuatorConfig& actuator : config.actuators) last = std::max(last, actuator.stage);
  return last;
}

void Decision::On(const event::Begin& begin) {
  machine_.phase = Phase::kStarting;
  machine_.by_hand = begin.by_hand;
  machine_.host = begin.host;
  machine_.epoch = begin.epoch + 1;
  machine_.finishing = begin.stop_intent && begin.restarted;
  Save(Stored::kEpoch);
  for (std::size_t i = 0; i < begin.running.size(); ++i) Of(i).found_running = begin.running[i];
  for (std::size_t i = 0; i < begin.processes.size(); ++i) Of(i).process = begin.processes[i];
  for (const RemoteActuator& remote : begin.remote) {
    if (const auto i = config_.IndexOf(remote.name)) Of(*i).elsewhere = remote.host;
  }
  RecordMachine(kCodeOk, "controller started: epoch " + std::to_string(machine_.epoch) + ", " +
                             std::to_string(machine_.actuators.size()) + " actuators");
  if (machine_.finishing) {
    RecordMachine(
        kCodeOk,
        "the previous controller was tearing the machine down; this start by a supervisor "
        "finishes that TearDown, and the machine stays down until `musher up` starts it",
        kBegun);
  } else if (begin.stop_intent) {
    Save(Stored::kStopIntent);  // clears the intent
  }
  StartStage(begin.by_hand || machine_.finishing ? LastStage(config_) : 1, kBegun);
  BeginStops(begin.stops);
  BeginPolicy(begin.policy);
}

void Decision::StartStage(int stage, std::uint64_t cause) {
  machine_.stage = stage;
  if (stage > 1 && !machine_.by_hand) {
    cause = RecordMachine(kCodeOk, "starting stage " + std::to_string(stage), cause);
  }
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    const bool waited_for = ConfigOf(i).command.empty() || record.found_running;
    if (ConfigOf(i).stage > stage || record.presence == Presence::kPresent || record.set_up_by)
      continue;
    record.cause = cause;
    const Duration set_up = config_.TimeFor(i, kSetUp);
    const Duration timeout = machine_.finishing ? std::min(set_up, kFinishingGrace) : set_up;
    // Only a Musher process holds its actuator's name, by which it is found running.
    const bool may_run = machine_.finishing && ConfigOf(i).protocol != Protocol::kMusher;
    if (waited_for || may_run) record.set_up_by = now_ + timeout;
  }
}

bool Decision::StartProcesses() {
  if (machine_.finishing) return false;
  bool changed = false;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    const ActuatorConfig& actuator = ConfigOf(i);
    if (actuator.stage > machine_.stage || actuator.command.empty() || record.found_running ||
        record.presence != Presence::kAbsent || record.set_up_by ||
        (record.fault && !record.blocked)) {
      continue;
    }
    std::string blocker;
    if (!NeedsMet(i, blocker)) {
      if (blocker.empty()) blocker = WaitsForSuspended(i);
      if (blocker.empty() || record.blocked) continue;
      record.blocked = true;
      Degrade(i, kCodeStatusError, blocker, CauseOfBlocker(i));
      FallBack(i);
    } else {
      if (std::exchange(record.blocked, false)) record.fault.reset();
      record.presence = Presence::kStarting;
      record.set_up_by = now_ + config_.TimeFor(i, kSetUp);
      record.launching = true;
      Do(action::StartProcess{i});
    }
    changed = true;
  }
  return changed;
}

// Whether all actuators in the `after` of `i` are present; sets `blocker` when one will not be.
bool Decision::NeedsMet(std::size_t i, std::string& blocker) const {
  bool met = true;
  for (const std::string& name : ConfigOf(i).after) {
    const ActuatorRecord& needed = Of(*config_.IndexOf(name));
    if (needed.fault && !needed.suspended && !Coming(*config_.IndexOf(name)))
      blocker = "needs " + name + ", which is degraded: " + needed.fault->message;
    if (needed.presence != Presence::kPresent || needed.fault) met = false;
  }
  return met;
}

std::uint64_t Decision::CauseOfBlocker(std::size_t i) const {
  for (const std::string& name : ConfigOf(i).after) {
    const ActuatorRecord& needed = Of(*config_.IndexOf(name));
    if (needed.fault) return needed.cause;
  }
  return 0;
}

void Decision::On(const event::ProcessStarted& started) {
  ActuatorRecord& record = Of(started.actuator);
  record.process = started.pid;
  record.launching = false;
  record.cause = RecordProcess(
      started.actuator, kCodeOk,
      ConfigOf(started.actuator).name + " started (pid " + std::to_string(started.pid) + ")",
      record.cause);
  // The machine was torn down while the process was starting.
  const bool stopped = machine_.phase == Phase::kStopped;
  if (!stopped && machine_.phase != Phase::kStopping) return;
  Do(action::SignalProcess{started.actuator, started.pid, stopped || machine_.stopping->killed});
}

// Possibly after its process was forked and could not execute the program.
void Decision::On(const event::ProcessNotStarted& failed) {
  Of(failed.actuator).process = 0;
  Of(failed.actuator).launching = false;
  if (Of(failed.actuator).presence == Presence::kPresent) return;  // another party has started it
  Of(failed.actuator).presence = Presence::kAbsent;
  Degrade(failed.actuator, kCodeFailed, "its process could not be started: " + failed.why,
          Of(failed.actuator).cause);
  Recover(failed.actuator);
}

void Decision::On(const event::ProcessEnded& ended) {
  ActuatorRecord& record = Of(ended.actuator);
  if (record.process != ended.pid) return;
  record.process = 0;
  if (record.report.pid == ended.pid) record.dead = record.report.incarnation;
  const std::string how = "process " + std::to_string(ended.pid) + " ended: " + ended.how;
  record.cause =
      RecordProcess(ended.actuator, ended.clean ? kCodeOk : kCodeFailed,
                    ConfigOf(ended.actuator).name + "'s " + how, record.fault ? record.cause : 0);
  if (AnotherIsPresent(ended.actuator, ended.pid)) return;
  // The exit status of a process that we have not started is unknown.
  if (ended.clean || record.found_running) AssumeTornDown(ended.actuator);
  // A clean exit that was not requested is a loss, but not a crash.
  if (record.health != Health::kHung && !ended.clean) record.health = Health::kCrashed;
  const bool in_set_up = record.presence == Presence::kStarting;
  const std::string why = IsFinal(ended.actuator, ended)
                              ? WhyFinal(ended)
                              : std::string(ended.clean ? "ended: its " : "crashed: its ") + how +
                                    (in_set_up ? " during SetUp" : "");
  if (in_set_up || record.presence == Presence::kPresent) {
    const bool final = IsFinal(ended.actuator, ended);
    Lose(ended.actuator, why, record.cause, final ? kCodeFailed : kCodeNetError);
  } else if (WasDisconnected(ended.actuator)) {
    // The lost connection was the first sign of the exit.
    Degrade(ended.actuator, record.fault->code, why, record.cause);
  }
  Recover(ended.actuator, ended);
}

// Whether a lost connection is all that is known about its loss.
bool Decision::WasDisconnected(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  return record.presence == Presence::kLost && record.fault && record.fault->message == kOutOfReach;
}

// Whether a process of this host other than `pid` publishes as this actuator: another party has
// started it first, or `pid` was only the program that started it.
bool Decision::AnotherIsPresent(std::size_t i, std::int32_t pid) const {
  const ActuatorRecord& record = Of(i);
  const bool speaks =
      record.presence == Presence::kPresent ||
      (record.presence == Presence::kStarting && record.report.incarnation != record.dead);
  const bool here = !record.report.host.empty() && record.report.host == machine_.host;
  return speaks && here && record.report.pid != 0 && record.report.pid != pid;
}

void Decision::On(const event::SetUpAwaited& awaited) {
  machine_.set_up_requests.push_back(awaited.request);
  if (machine_.set_up) AnswerSetUpRequests();
}

void Decision::AnswerSetUpRequests() {
  Result<> answer;
  for (std::size_t i = 0; i < machine_.actuators.size() && answer; ++i) {
    const auto& fault = Of(i).fault;
    if (fault) answer = Error{kCodeTimeout, ConfigOf(i).name + " " + fault->message};
  }
  for (const RequestId request : std::exchange(machine_.set_up_requests, {})) {
    Do(action::AnswerCall{request, answer});
  }
}

// Why it is not set up by its deadline.
std::string Decision::NotSetUp(std::size_t i) const {
  const ActuatorConfig& actuator = ConfigOf(i);
  const ActuatorRecord& record = Of(i);
  const std::string within =
      "within " + std::to_string(ToMilliseconds(config_.TimeFor(i, kSetUp))) + " ms";
  const bool announced = record.report.incarnation != 0 && record.report.incarnation != record.dead;
  if (actuator.protocol == Protocol::kRos2Lifecycle && !announced) {
    const std::string folder = config_.name_space.empty() ? "/" : "/" + config_.name_space + "/";
    return "no managed node " + folder + actuator.name + " was discovered " + within +
           (record.process == 0
                ? ""
                : ", but its program runs (process " + std::to_string(record.process) + ")") +
           "; the node has another name, or no lifecycle states, or does not meet the machine: "
           "`musher check` says why";
  }
  if (record.process == 0 || announced || actuator.protocol != Protocol::kMusher) {
    return "was not set up " + within;
  }
  for (std::size_t other = 0; other < machine_.actuators.size(); ++other) {
    const bool shared = other != i && Of(other).process == record.process;
    if (!shared || Of(other).presence != Presence::kPresent) continue;
    return "was not set up " + within + ": process " + std::to_string(record.process) +
           ", which runs it and " + ConfigOf(other).name +
           ", did not announce it; `musher restart " + actuator.name + "` starts both again";
  }
  std::string command = R"(["musher-exec", "--")";
  for (const std::string& word : actuator.command) command += ", \"" + word + "\"";
  return "its program runs (process " + std::to_string(record.process) +
         ") but never announced itself as actuator " + actuator.name + " " + within +
         "; wrap a program that is not a Musher module with musher-exec: command = " + command +
         "]";
}

void Decision::CheckSetUpDeadlines() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    if (!record.set_up_by || *record.set_up_by > now_ || record.presence == Presence::kPresent) {
      continue;
    }
    record.set_up_by.reset();
    if (record.fault && record.presence != Presence::kStarting)
      continue;                        // the known fault says more
    if (machine_.finishing) continue;  // an actuator that does not run need not be torn down
    // The reason of a failed SetUp says more as well.
    const ActuatorReport& report = record.report;
    const bool failed = record.fault && report.incarnation != record.dead &&
                        report.state == config_.default_state && report.outcome_code != kCodeOk;
    if (!failed) Degrade(i, kCodeTimeout, NotSetUp(i), record.cause);
    FallBack(i);
  }
}

bool Decision::StageSetUp(int stage) const {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    if (ConfigOf(i).stage > stage) continue;
    if (machine_.finishing && !Of(i).set_up_by) continue;
    if (Of(i).presence != Presence::kPresent && (!Of(i).fault || Coming(i))) return false;
  }
  return true;
}

// Whether each actuator of the stage is in the state of the machine, or will not be.
bool Decision::StageSettled(int stage) const {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const ActuatorRecord& record = Of(i);
    if (ConfigOf(i).stage > stage || record.fault || record.held) continue;
    const bool joined =
        record.presence == Presence::kPresent && Fits(i) && !record.due && !record.command;
    if (!joined) return false;
  }
  return true;
}

bool Decision::AdvanceStart() {
  if (!machine_.set_up && machine_.phase == Phase::kStarting) {
    if (!StageSetUp(machine_.stage)) return false;
    EndFirstStage();
    return true;
  }
  const bool more = machine_.phase == Phase::kRunning && machine_.stage < LastStage(config_);
  if (!more || machine_.current || !StageSettled(machine_.stage)) return false;
  StartStage(machine_.stage + 1, kBegun);
  return true;
}

// All actuators of the first stage are set up, or given up.
void Decision::EndFirstStage() {
  machine_.set_up = true;
  machine_.state = State(kSetUp);
  std::vector<std::string> missing;
  std::size_t present = 0;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const ActuatorRecord& record = Of(i);
    if (record.fault) missing.push_back(ConfigOf(i).name + " " + record.fault->message);
    if (record.presence == Presence::kPresent && !IsUnconfigured(config_, i, record)) ++present;
  }
  AnswerSetUpRequests();
  const std::uint64_t recorded =
      RecordMachine(kCodeOk, std::to_string(present) + " actuators are set up", kBegun);
  if (machine_.finishing) return AdoptFrom(State(kTearDown), recorded);
  if (const auto lowest = LowestFound()) return AdoptFrom(*lowest, recorded);
  if (machine_.by_hand && config_.ros2.started_by_manager)
    return WaitForManager(present, missing, recorded);
  if (machine_.by_hand) return;
  if (present == 0) {
    return FailStartUp(missing.empty() ? "there is no actuator in stage 1" : missing.front(),
                       recorded);
  }
  if (machine_.emergency_stop) {
    return FailStartUp(
        "an emergency stop is engaged; run `musher estop --release`, then `musher set SelfCheck` "
        "and `musher set Active`",
        recorded);
  }
  if (!config_.HasState(kSelfCheck)) return Activate(recorded);
  Begin(MakePlan(config_, machine_, State(kSelfCheck)), Purpose::kStartUpCheck, {}, recorded);
}

void Decision::WaitForManager(std::size_t present, const std::vector<std::string>& missing,
                              std::uint64_t cause) {
  if (FailOnCriticalFault()) return;
  if (present == 0) {
    return FailStartUp(missing.empty() ? "the machine has no actuator" : missing.front(), cause);
  }
  std::string message = "the machine waits in SetUp for a manager to configure it";
  for (const std::string& actuator : missing) message += "; " + actuator;
  RecordMachine(kCodeOk, message, cause);
  Do(action::StartUpEnded{true, message});
}

// Returns whether a critical actuator of the stages so far has a fault.
bool Decision::FailOnCriticalFault() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    if (ConfigOf(i).stage > machine_.stage || !Critical(i) || !Of(i).fault) continue;
    FailStartUp("critical " + ConfigOf(i).name + ": " + CodeText(Of(i).fault->code) + ", " +
                    Of(i).fault->message,
                Of(i).cause);
    return true;
  }
  return false;
}

void Decision::AfterStartUpCheck(std::uint64_t checked) {
  if (!FailOnCriticalFault()) Activate(checked);
}

void Decision::Activate(std::uint64_t cause) {
  if (!config_.HasState(kActive)) {
    return BecomeRunning("self-check done; the machine has no Active", cause);
  }
  const Plan plan = MakePlan(config_, machine_, State(kActive));
  if (plan.refusal) return FailStartUp(plan.refusal->message, cause);
  Begin(plan, Purpose::kStartUpActivate, {}, cause);
}

void Decision::FailStartUp(const std::string& why, std::uint64_t cause) {
  machine_.phase = Phase::kFailed;
  const std::string message =
      "start-up failed, the machine stays in " + machine_.state + ": " + why;
  RecordMachine(kCodeFailed, message, cause);
  Do(action::StartUpEnded{false, message});
}

void Decision::BecomeRunning(const std::string& message, std::uint64_t cause) {
  machine_.phase = Phase::kRunning;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    const bool there = record.presence == Presence::kPresent;
    if (there && MayFollow(i) && !record.held && record.state() != machine_.state) {
      record.due = true;
    }
    const bool away = !there || IsUnconfigured(config_, i, record);
    if (away && record.fault && !Coming(i)) FallBack(i);
  }
  RecordMachine(kCodeOk, message, cause);
  Do(action::StartUpEnded{true, message});
}

}  // namespace musher
