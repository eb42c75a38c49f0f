// Actuators that crashed, hang or lost their connection: a verdict, then a restart by policy, then
// back to the state of the machine; and what follows when no restarts are left.

#include <algorithm>
#include <cmath>

#include "musher/base/suggest.hpp"
#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// Before restart n, counted from 0.
Duration DelayOf(const RestartConfig& restart, int n) {
  if (restart.delay == Duration::zero()) return {};  // unbounded growth would be infinite
  const double factor = std::pow(restart.growth, n);
  const double longest = static_cast<double>(restart.max_delay.count());
  const double delay = static_cast<double>(restart.delay.count()) * factor;
  return Duration(static_cast<Duration::rep>(std::min(delay, longest)));
}

}  // namespace

// Whether it is starting, though it is not present yet.
bool Decision::Coming(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  const bool about_to_end = record.terminating != 0;  // and is restarted after that
  return record.restart_at || record.restart_requested ||
         (record.set_up_by && (record.presence == Presence::kStarting || about_to_end));
}

bool Decision::MayRestart(std::size_t i) const {
  return !ConfigOf(i).command.empty() && ConfigOf(i).restart.policy != RestartPolicy::kNo;
}

// The process that can be signalled: one that we started, or one of this host that publishes as it.
std::int32_t Decision::ProcessOf(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  if (record.process != 0) return record.process;
  const ActuatorReport& report = record.report;
  const bool here = !report.host.empty() && report.host == machine_.host;
  return here && report.incarnation != record.dead ? report.pid : 0;
}

void Decision::On(const event::HealthChanged& changed) {
  const std::size_t i = changed.actuator;
  ActuatorRecord& record = Of(i);
  if (changed.incarnation != record.report.incarnation || changed.incarnation == record.dead ||
      machine_.phase == Phase::kStopping) {
    return;
  }
  if (changed.health == Health::kWell) return Recovered(i, changed.how);
  record.health = changed.health;
  const std::string what = std::string(HealthName(changed.health)) + ": " + changed.how;
  switch (changed.health) {
    case Health::kHung:
      return Hang(i, changed.silent, what);
    case Health::kCrashed:
    case Health::kPartitioned:
      if (record.presence == Presence::kPresent || record.presence == Presence::kStarting) {
        LoseConnection(i, what);
      }
      return;
    case Health::kStarved:
    case Health::kWell:
      RecordActuator(i, kCodeTimeout, ConfigOf(i).name + " is " + what);
      return;
  }
}

void Decision::Recovered(std::size_t i, const std::string& how) {
  ActuatorRecord& record = Of(i);
  record.health = Health::kWell;
  record.cause =
      RecordActuator(i, kCodeOk, ConfigOf(i).name + " has recovered: " + how, record.cause);
  if (!record.restart_requested) {  // else it is terminated anyway
    record.terminating = 0;
    record.killed = false;
    record.terminate_at.reset();
    record.kill_at.reset();
  }
  if (record.presence == Presence::kLost) {
    record.presence = Presence::kStarting;
    return TakeControl(i);
  }
  if (record.presence == Presence::kPresent && record.fault && record.checked && !record.held) {
    record.due = true;
  }
}

// A hung actuator is killed if it may be restarted, once its backtrace was taken. An actuator that
// the controller may not restart is left as it is: it may recover.
void Decision::Hang(std::size_t i, bool silent, const std::string& how) {
  const std::int32_t pid = ProcessOf(i);
  const bool killable = MayRestart(i) && pid != 0;
  if (killable || silent) {
    Lose(i, how);
  } else {
    Degrade(i, kCodeTimeout, how);
  }
  if (!killable) return FallBack(i);
  Of(i).cause = RecordProcess(i, kCodeTimeout,
                              "taking a backtrace of " + ConfigOf(i).name + "; then process " +
                                  std::to_string(pid) + " gets SIGKILL",
                              Of(i).cause);
  Terminate(i, pid, kBacktraceTime);
  Do(action::TakeBacktrace{i, pid});
}

void Decision::Terminate(std::size_t i, std::int32_t pid, Duration grace) {
  ActuatorRecord& record = Of(i);
  record.terminating = pid;
  record.killed = false;
  record.terminate_at.reset();
  record.kill_at = now_ + grace;
  if (record.set_up_by) record.set_up_by = std::max(*record.set_up_by, now_ + grace + kEndTime);
}

void Decision::On(const event::BacktraceTaken& taken) {
  ActuatorRecord& record = Of(taken.actuator);
  if (record.terminating != taken.pid || record.killed) return;  // it has recovered, or has exited
  action::Record backtrace;
  backtrace.kind = "process";
  backtrace.actuator = taken.actuator;
  backtrace.message = "backtrace of " + ConfigOf(taken.actuator).name + ":";
  backtrace.cause = record.cause;
  backtrace.data = taken.text;
  Record(backtrace);
  Kill(taken.actuator);
}

void Decision::Kill(std::size_t i) {
  Of(i).killed = true;
  Of(i).kill_at = now_ + kEndTime;
  Do(action::SignalProcess{i, Of(i).terminating, true});
}

// Its exit was not seen, or the kernel delays it. If it still runs, its successor will report that.
void Decision::AssumeExited(std::size_t i) {
  ActuatorRecord& record = Of(i);
  RecordProcess(i, kCodeTimeout,
                "no exit reported for process " + std::to_string(record.terminating) +
                    " after SIGKILL; it is assumed to have exited");
  if (record.process == record.terminating) record.process = 0;
  record.dead = record.report.incarnation;
  if (record.presence == Presence::kPresent) Lose(i, "it was killed");
  Recover(i);
}

// Whether the exit code says that a restart does not help.
bool Decision::IsFinal(std::size_t i, const event::ProcessEnded& ended) const {
  return MayRestart(i) && !Of(i).restart_requested && ConfigOf(i).restart.Prevents(ended.exit_code);
}

std::string Decision::WhyFinal(const event::ProcessEnded& ended) const {
  const std::string code = "exit code " + std::to_string(ended.exit_code);
  return ended.how + "; not restarted automatically, because " + code +
         (ended.exit_code == kUsageExitCode ? " means a configuration error"
                                            : " is one of its restart_prevent_exit_codes") +
         "; restart it with `musher restart " + ConfigOf(ended.actuator).name + "`";
}

// Its process has exited, or could not be started: decides what follows.
void Decision::Recover(std::size_t i, const event::ProcessEnded& ended) {
  ActuatorRecord& record = Of(i);
  const ActuatorConfig& config = ConfigOf(i);
  record.terminating = 0;
  record.terminate_at.reset();
  record.kill_at.reset();
  record.killed = false;
  record.healthy_at.reset();
  const bool wanted = machine_.phase == Phase::kStarting || machine_.phase == Phase::kRunning ||
                      machine_.phase == Phase::kFailed;
  if (!wanted) return;
  if (std::exchange(record.restart_requested, false)) {
    record.restart_at = now_;
    return;
  }
  // An actuator that was torn down alone stays down.
  if (record.state() == kTearDown && record.report.apart) return;
  const bool content = ended.clean && config.restart.policy == RestartPolicy::kOnFailure;
  if (!MayRestart(i) || content) return FallBack(i);
  if (IsFinal(i, ended)) return GiveUp(i, WhyFinal(ended));
  if (record.restarts >= config.restart.limit) {
    return GiveUp(i, "given up after " + std::to_string(record.restarts) + " restarts; " +
                         (record.fault ? record.fault->message : "its process ended"));
  }
  const Duration delay = DelayOf(config.restart, record.restarts);
  ++record.restarts;
  record.restart_at = now_ + delay;
  record.cause = RecordProcess(
      i, kCodeOk,
      config.name + ": restarting in " + std::to_string(ToMilliseconds(delay)) + " ms (" +
          std::to_string(record.restarts) + " of " + std::to_string(config.restart.limit) + ")",
      record.cause);
}

void Decision::GiveUp(std::size_t i, const std::string& why) {
  Of(i).given_up = true;
  Degrade(i, kCodeFailed, why, Of(i).cause);
  FallBack(i);
}

// It is present; its restarts are counted until it has run for a while.
void Decision::EvaluateArrival(std::size_t i) {
  ActuatorRecord& record = Of(i);
  const RestartConfig& restart = ConfigOf(i).restart;
  record.given_up = record.restarts > restart.limit;
  if (record.restarts > 0) record.healthy_at = now_ + restart.reset_after;
  if (!record.given_up) return;
  Degrade(i, kCodeFailed,
          "started " + std::to_string(record.restarts) +
              " times in a row; not driven until it has run for " +
              std::to_string(ToMilliseconds(restart.reset_after)) + " ms",
          record.cause);
  FallBack(i);
}

void Decision::CheckRestarts() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    if (record.terminate_at && *record.terminate_at <= now_) {
      record.terminate_at.reset();
      Do(action::SignalProcess{i, record.terminating, false});
    }
    if (record.kill_at && *record.kill_at <= now_) record.killed ? AssumeExited(i) : Kill(i);
    if (record.healthy_at && *record.healthy_at <= now_) {
      record.healthy_at.reset();
      record.restarts = 0;
      if (std::exchange(record.given_up, false)) record.due = record.checked;
    }
    if (record.restart_at && *record.restart_at <= now_) StartAgain(i);
    if (!record.restart_requests.empty()) AnswerRestarts(i);
  }
}

// The process to be terminated has exited, or there would be no successor.
void Decision::ForgetEnd(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.terminating = 0;
  record.killed = false;
  record.terminate_at.reset();
  record.kill_at.reset();
  record.restart_requested = false;
}

// Another party has started it first.
void Decision::CancelRestart(std::size_t i) {
  Of(i).restart_at.reset();
  Of(i).set_up_by = now_ + config_.TimeFor(i, kSetUp);
}

void Decision::StartAgain(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.restart_at.reset();
  record.blocked = false;
  record.found_running = false;
  record.report.state = config_.default_state;  // the old process does not count any more
  record.presence = Presence::kStarting;
  record.set_up_by = now_ + config_.TimeFor(i, kSetUp);
  record.launching = true;
  Do(action::StartProcess{i});
}

void Decision::On(const event::RestartRequested& requested) {
  const auto refuse = [&](std::int32_t code, const std::string& why) {
    Do(action::AnswerCall{requested.request, Error{code, why}});
  };
  const auto i = config_.IndexOf(requested.actuator);
  if (!i) {
    return refuse(kCodeParametersInvalid, NoSuchActuator(requested.actuator, config_));
  }
  if (ConfigOf(*i).command.empty()) {
    return refuse(
        kCodeUnSupport,
        requested.actuator + " has no command in the config: restart it where it was started");
  }
  const bool in_use = machine_.phase == Phase::kRunning || machine_.phase == Phase::kFailed;
  if (!in_use) {
    return refuse(kCodeStatusError, "the machine is " + std::string(PhaseName(machine_.phase)) +
                                        "; it cannot be restarted now");
  }
  ActuatorRecord& record = Of(*i);
  if (RunsElsewhere(*i)) {
    return refuse(kCodeUnSupport, requested.actuator + " runs on another host, " +
                                      record.report.host.substr(0, 64) +
                                      ", where this controller cannot end processes; end process " +
                                      std::to_string(record.report.pid) + " there");
  }
  record.restart_requests.push_back(requested.request);
  if (record.restart_requested) return;
  record.restart_requested = true;
  record.restarts = 0;
  record.given_up = false;
  record.cause = RecordProcess(*i, kCodeOk, "restart of " + requested.actuator + " requested");
  EndForRestart(*i);
}

// Whether its process runs on another host: a second one here would run in parallel.
bool Decision::RunsElsewhere(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  const bool connected =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  const ActuatorReport& report = record.report;
  return connected && record.process == 0 && report.incarnation != 0 &&
         report.incarnation != record.dead && !report.host.empty() && report.host != machine_.host;
}

// TearDown if it can be commanded, else SIGTERM, and SIGKILL when that does not help.
void Decision::EndForRestart(std::size_t i) {
  ActuatorRecord& record = Of(i);
  const std::int32_t pid = ProcessOf(i);
  if (pid == 0) return Recover(i);
  const bool can_be_commanded = record.presence == Presence::kPresent && !record.command &&
                                !record.report.busy() && !machine_.current &&
                                record.health != Health::kHung && ConfigOf(i).Lists(kTearDown) &&
                                record.state() != kTearDown;
  if (can_be_commanded) {
    return Issue(i, machine_.number + 1, State(kTearDown), config_.TimeFor(i, kTearDown), true);
  }
  Terminate(i, pid, kEndTime);
  Do(action::SignalProcess{i, pid, false});
}

// Answers the restart requests when it is back, or when it will not come back.
void Decision::AnswerRestarts(std::size_t i) {
  ActuatorRecord& record = Of(i);
  if (Coming(i)) return;
  const bool ended = machine_.phase != Phase::kRunning && machine_.phase != Phase::kFailed;
  const bool may_go_on = record.due && !machine_.emergency_stop;
  const bool driven =
      ((Fits(i) || record.join_tried) && !may_go_on) || machine_.phase == Phase::kFailed;
  const bool there = record.presence == Presence::kPresent && !record.command && driven;
  if (!ended && !there && !record.fault) return;
  Result<> answer;
  if (record.fault) {
    answer = *record.fault;
  } else if (!there) {
    answer = Error{kCodeStateInvalid, "the machine is being torn down"};
  }
  for (const RequestId request : std::exchange(record.restart_requests, {})) {
    Do(action::AnswerCall{request, answer});
  }
}

}  // namespace musher
