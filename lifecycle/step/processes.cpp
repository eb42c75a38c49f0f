#include "musher/lifecycle/step/processes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

void Processes::Recover(ActuatorIndex i, const event::ProcessEnded& ended) {
  KnownActuator& known = Of(i);
  const ActuatorConfig& config = ConfigOf(i);
  known.process.termination.reset();
  known.restart.reset_at.reset();
  const bool wanted = machine_.phase == Phase::kStarting || machine_.phase == Phase::kRunning ||
                      machine_.phase == Phase::kFailed;
  if (!wanted) return;
  // What has exited need not be torn down, and nothing starts after a TearDown.
  if (machine_.start_up.finishing) return known.set_up_by.reset();
  if (std::exchange(known.restart.requested, false)) {
    known.restart.at = now_;
    return;
  }
  // An actuator that was torn down alone stays down.
  if (known.state() == kTearDown && known.report.detached) return;
  const bool content = ended.clean && config.restart.policy == RestartPolicy::kOnFailure;
  if (!MayRestart(i) || content) return FallBack(i);
  if (IsFinal(i, ended)) return GiveUp(i, WhyFinal(ended));
  if (known.restart.count >= config.restart.limit) {
    return GiveUp(i,
                  texts::GivenUp(config.name, known.restart.count,
                                 known.fault ? std::optional(known.fault->message) : std::nullopt));
  }
  const Duration delay = DelayOf(config.restart, known.restart.count);
  ++known.restart.count;
  known.restart.at = now_ + delay;
  known.cause = RecordProcess(
      i, kCodeOk,
      texts::RestartScheduled(config.name, delay, known.restart.count, config.restart.limit),
      known.cause);
}

void Processes::GiveUp(ActuatorIndex i, const RecordText& why) {
  Of(i).restart.given_up = true;
  Of(i).set_up_by.reset();
  const auto& fault = Of(i).fault;  // it may have been given up, and started once more
  const bool said = fault && fault->event == why.event;
  if (!said) Degrade(i, kCodeFailed, why, Of(i).cause);
  FallBack(i);
}

void Processes::EvaluateArrival(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  const RestartConfig& restart = ConfigOf(i).restart;
  known.restart.given_up = known.restart.count > restart.limit;
  if (known.restart.count > 0) known.restart.reset_at = now_ + restart.reset_after;
  if (!known.restart.given_up) return;
  Degrade(i, kCodeFailed, texts::RestartedTooOften(known.restart.count, restart.reset_after),
          known.cause);
  FallBack(i);
}

void Processes::StartAgain(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.restart.at.reset();
  known.process.ended_pid = 0;
  known.process.ended_host.clear();
  known.report.state = config_.default_state;  // the old process does not count any more
  known.report.pid = 0;
  known.presence = Presence::kStarting;
  known.set_up_by = now_ + config_.TimeFor(i, kSetUp);
  known.process.launch = Launch::kUnderWay;
  Do(action::StartProcess{i});
}

void Processes::Terminate(ActuatorIndex i, std::int32_t pid, Duration grace) {
  KnownActuator& known = Of(i);
  known.process.termination = {pid, std::nullopt, now_ + grace, false};
  if (known.set_up_by) known.set_up_by = std::max(*known.set_up_by, now_ + grace + kEndTime);
}

void Processes::Kill(ActuatorIndex i) {
  Termination& termination = *Of(i).process.termination;
  termination.killed = true;
  termination.kill_at = now_ + kEndTime;
  Do(action::SignalProcess{i, termination.pid, true});
}

void Processes::ForgetProcess(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.process.pid = 0;
  known.process.host.clear();
  known.process.taken.reset();
  known.exit_by.reset();
}

void Processes::ForgetEnd(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.process.termination.reset();
  known.restart.requested = false;
}

void Processes::CancelRestart(ActuatorIndex i) {
  Of(i).restart.at.reset();
  Of(i).set_up_by = now_ + config_.TimeFor(i, kSetUp);
}

bool Processes::IsFinal(ActuatorIndex i, const event::ProcessEnded& ended) const {
  return MayRestart(i) && !Of(i).restart.requested && ConfigOf(i).restart.Prevents(ended.exit_code);
}

RecordText Processes::WhyFinal(const event::ProcessEnded& ended) const {
  return texts::RestartPrevented(ended.how, ended.exit_code, ConfigOf(ended.actuator).name);
}

}  // namespace musher
