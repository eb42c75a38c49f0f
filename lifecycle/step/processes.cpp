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
  ActuatorRecord& record = Of(i);
  const ActuatorConfig& config = ConfigOf(i);
  record.process.termination.reset();
  record.restart.reset_at.reset();
  const bool wanted = machine_.phase == Phase::kStarting || machine_.phase == Phase::kRunning ||
                      machine_.phase == Phase::kFailed;
  if (!wanted) return;
  if (std::exchange(record.restart.requested, false)) {
    record.restart.at = now_;
    return;
  }
  // An actuator that was torn down alone stays down.
  if (record.state() == kTearDown && record.report.detached) return;
  const bool content = ended.clean && config.restart.policy == RestartPolicy::kOnFailure;
  if (!MayRestart(i) || content) return FallBack(i);
  if (IsFinal(i, ended)) return GiveUp(i, WhyFinal(ended));
  if (record.restart.count >= config.restart.limit) {
    return GiveUp(
        i, texts::GivenUp(record.restart.count,
                          record.fault ? std::optional(record.fault->message) : std::nullopt));
  }
  const Duration delay = DelayOf(config.restart, record.restart.count);
  ++record.restart.count;
  record.restart.at = now_ + delay;
  record.cause = RecordProcess(
      i, kCodeOk,
      texts::RestartScheduled(config.name, delay, record.restart.count, config.restart.limit),
      record.cause);
}

void Processes::GiveUp(ActuatorIndex i, const RecordText& why) {
  Of(i).restart.given_up = true;
  Degrade(i, kCodeFailed, why, Of(i).cause);
  FallBack(i);
}

void Processes::EvaluateArrival(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  const RestartConfig& restart = ConfigOf(i).restart;
  record.restart.given_up = record.restart.count > restart.limit;
  if (record.restart.count > 0) record.restart.reset_at = now_ + restart.reset_after;
  if (!record.restart.given_up) return;
  Degrade(i, kCodeFailed, texts::RestartedTooOften(record.restart.count, restart.reset_after),
          record.cause);
  FallBack(i);
}

void Processes::StartAgain(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  record.restart.at.reset();
  record.report.state = config_.default_state;  // the old process does not count any more
  record.presence = Presence::kStarting;
  record.set_up_by = now_ + config_.TimeFor(i, kSetUp);
  record.process.launch = Launch::kUnderWay;
  Do(action::StartProcess{i});
}

void Processes::Terminate(ActuatorIndex i, std::int32_t pid, Duration grace) {
  ActuatorRecord& record = Of(i);
  record.process.termination = {pid, std::nullopt, now_ + grace, false};
  if (record.set_up_by) record.set_up_by = std::max(*record.set_up_by, now_ + grace + kEndTime);
}

void Processes::Kill(ActuatorIndex i) {
  Termination& termination = *Of(i).process.termination;
  termination.killed = true;
  termination.kill_at = now_ + kEndTime;
  Do(action::SignalProcess{i, termination.pid, true});
}

void Processes::ForgetEnd(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  record.process.termination.reset();
  record.restart.requested = false;
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
