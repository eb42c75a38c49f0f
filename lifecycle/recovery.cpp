// What has died, hangs or is out of reach: a verdict, then a restart by policy, then back to where
// the machine is; and what follows when there are no restarts left.

#include <algorithm>
#include <cmath>

#include "musher/lifecycle/decision.hpp"
#include "musher/lifecycle/suggest.hpp"

namespace musher {
namespace {

// Before restart n, counted from 0.
Duration DelayOf(const RestartConfig& restart, int n) {
  if (restart.delay == Duration::zero()) return {};  // growth without bounds is no number
  const double factor = std::pow(restart.growth, n);
  const double longest = static_cast<double>(restart.max_delay.count());
  const double delay = static_cast<double>(restart.delay.count()) * factor;
  return Duration(static_cast<Duration::rep>(std::min(delay, longest)));
}

}  // namespace

// Whether it is on its way, though it is not there yet.
bool Decision::Coming(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  const bool about_to_end = record.terminating != 0;  // which is what it is restarted after
  return record.restart_at || record.restart_asked ||
         (record.set_up_by && (record.presence == Presence::kStarting || about_to_end));
}

bool Decision::MayRestart(std::size_t i) const {
  return !ConfigOf(i).command.empty() && ConfigOf(i).restart.policy != RestartPolicy::kNo;
}

// The process that can be signalled: one that we started, or one of this host that says it is it.
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
        LoseSight(i, what);
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
      RecordActuator(i, kCodeOk, ConfigOf(i).name + " is well again: " + how, record.cause);
  if (!record.restart_asked) {  // else it is to end, well or not
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

// One that hangs is killed if it may be started again, once it is known what it was doing. What is
// not ours to restart is left as it is: it may come to itself.
void Decision::Hang(std::size_t i, bool silent, const std::string& how) {
  const std::int32_t pid = ProcessOf(i);
  const bool killable = MayRestart(i) && pid != 0;
  if (killable || silent) {
    Lose(i, how);
  } else {
    Degrade(i, kCodeTimeout, how);
  }
  if (!killable) return Fall(i);
  Of(i).cause = RecordProcess(i, kCodeTimeout,
                              "what " + ConfigOf(i).name + " is doing is looked at; then process " +
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
  if (record.terminating != taken.pid || record.killed) return;  // it came to itself, or has ended
  action::Record backtrace;
  backtrace.kind = "process";
  backtrace.actuator = taken.actuator;
  backtrace.message = "what " + ConfigOf(taken.actuator).name + " was doing:";
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

// Its end was not seen, or the kernel holds it. Should it live on, its successor will say so.
void Decision::TakeForEnded(std::size_t i) {
  ActuatorRecord& record = Of(i);
  RecordProcess(i, kCodeTimeout,
                "nothing is heard of the end of process " + std::to_string(record.terminating) +
                    ", which was killed; it is taken for ended");
  if (record.process == record.terminating) record.process = 0;
  record.dead = record.report.incarnation;
  if (record.presence == Presence::kPresent) Lose(i, "it was killed");
  Recover(i);
}

// Whether it was said of this end that a new start does not help.
bool Decision::IsFinal(std::size_t i, const event::ProcessEnded& ended) const {
  return MayRestart(i) && !Of(i).restart_asked && ConfigOf(i).restart.Prevents(ended.exit_code);
}

std::string Decision::WhyFinal(const event::ProcessEnded& ended) const {
  const std::string code = "exit code " + std::to_string(ended.exit_code);
  return ended.how + "; it is not started again until `musher restart " +
         ConfigOf(ended.actuator).name + "`, because " + code +
         (ended.exit_code == kUsageExitCode ? " tells of a wrong configuration"
                                            : " is one of its restart_prevent_exit_codes");
}

// Its process has ended, or could not be started: what now?
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
  if (std::exchange(record.restart_asked, false)) {
    record.restart_at = now_;
    return;
  }
  // Who was torn down alone is meant to stay so.
  if (record.state() == kTearDown && record.report.apart) return;
  const bool content = ended.clean && config.restart.policy == RestartPolicy::kOnFailure;
  if (!MayRestart(i) || content) return Fall(i);
  if (IsFinal(i, ended)) return GiveUp(i, WhyFinal(ended));
  if (record.restarts >= config.restart.limit) {
    return GiveUp(i, "given up after " + std::to_string(record.restarts) + " restarts; " +
                         (record.fault ? record.fault->message : "its process ended"));
  }
  const Duration delay = DelayOf(config.restart, record.restarts);
  ++record.restarts;
  record.restart_at = now_ + delay;
  record.cause =
      RecordProcess(i, kCodeOk,
                    config.name + " is started again in " + std::to_string(ToMilliseconds(delay)) +
                        " ms, restart " + std::to_string(record.restarts) + " of " +
                        std::to_string(config.restart.limit),
                    record.cause);
}

void Decision::GiveUp(std::size_t i, const std::string& why) {
  Of(i).given_up = true;
  Degrade(i, kCodeFailed, why, Of(i).cause);
  Fall(i);
}

// It is there; its starts are counted until it has lived for a while.
void Decision::EvaluateArrival(std::size_t i) {
  ActuatorRecord& record = Of(i);
  const RestartConfig& restart = ConfigOf(i).restart;
  record.given_up = record.restarts > restart.limit;
  if (record.restarts > 0) record.healthy_at = now_ + restart.reset_after;
  if (!record.given_up) return;
  Degrade(i, kCodeFailed,
          "it was started " + std::to_string(record.restarts) +
              " times in a row; left alone until it has lived for " +
              std::to_string(ToMilliseconds(restart.reset_after)) + " ms",
          record.cause);
  Fall(i);
}

void Decision::CheckRestarts() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    if (record.terminate_at && *record.terminate_at <= now_) {
      record.terminate_at.reset();
      Do(action::SignalProcess{i, record.terminating, false});
    }
    if (record.kill_at && *record.kill_at <= now_) record.killed ? TakeForEnded(i) : Kill(i);
    if (record.healthy_at && *record.healthy_at <= now_) {
      record.healthy_at.reset();
      record.restarts = 0;
      if (std::exchange(record.given_up, false)) record.due = record.checked;
    }
    if (record.restart_at && *record.restart_at <= now_) StartAgain(i);
    if (!record.restart_requests.empty()) AnswerRestarts(i);
  }
}

// What was to end has, or there would be no successor.
void Decision::ForgetEnd(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.terminating = 0;
  record.killed = false;
  record.terminate_at.reset();
  record.kill_at.reset();
  record.restart_asked = false;
}

// Somebody else was faster.
void Decision::CallOffRestart(std::size_t i) {
  Of(i).restart_at.reset();
  Of(i).set_up_by = now_ + config_.TimeFor(i, kSetUp);
}

void Decision::StartAgain(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.restart_at.reset();
  record.blocked = false;
  record.found_running = false;
  record.report.state = config_.default_state;  // how the last one ended is no matter any more
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
    return refuse(kCodeUnSupport,
                  requested.actuator + " has no command in the config: whoever started it has to");
  }
  const bool in_use = machine_.phase == Phase::kRunning || machine_.phase == Phase::kFailed;
  if (!in_use) {
    return refuse(kCodeStatusError,
                  "the machine is " + std::string(PhaseName(machine_.phase)) + "; not now");
  }
  ActuatorRecord& record = Of(*i);
  if (RunsElsewhere(*i)) {
    return refuse(kCodeUnSupport, requested.actuator + " runs on another host, " +
                                      record.report.host.substr(0, 64) +
                                      ", where this controller can end no process; end process " +
                                      std::to_string(record.report.pid) + " there");
  }
  record.restart_requests.push_back(requested.request);
  if (record.restart_asked) return;
  record.restart_asked = true;
  record.restarts = 0;
  record.given_up = false;
  record.cause = RecordProcess(*i, kCodeOk, requested.actuator + " is restarted by hand");
  EndForRestart(*i);
}

// Whether its process is heard from another host: a second one here would run beside it.
bool Decision::RunsElsewhere(std::size_t i) const {
  const ActuatorRecord& record = Of(i);
  const bool heard =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  const ActuatorReport& report = record.report;
  return heard && record.process == 0 && report.incarnation != 0 &&
         report.incarnation != record.dead && !report.host.empty() && report.host != machine_.host;
}

// TearDown if it can be told, else SIGTERM, and SIGKILL when that does not help.
void Decision::EndForRestart(std::size_t i) {
  ActuatorRecord& record = Of(i);
  const std::int32_t pid = ProcessOf(i);
  if (pid == 0) return Recover(i);
  const bool can_be_told = record.presence == Presence::kPresent && !record.order &&
                           !record.report.busy() && !machine_.current &&
                           record.health != Health::kHung && ConfigOf(i).Lists(kTearDown) &&
                           record.state() != kTearDown;
  if (can_be_told) {
    return Issue(i, machine_.number + 1, State(kTearDown), config_.TimeFor(i, kTearDown), true);
  }
  Terminate(i, pid, kEndTime);
  Do(action::SignalProcess{i, pid, false});
}

// Those who asked for a restart hear when it is back, or that it will not come.
void Decision::AnswerRestarts(std::size_t i) {
  ActuatorRecord& record = Of(i);
  if (Coming(i)) return;
  const bool ended = machine_.phase != Phase::kRunning && machine_.phase != Phase::kFailed;
  const bool may_go_on = record.due && !machine_.emergency_stop;
  const bool driven =
      ((Fits(i) || record.join_tried) && !may_go_on) || machine_.phase == Phase::kFailed;
  const bool there = record.presence == Presence::kPresent && !record.order && driven;
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
