// The end: TearDown in reverse order, then SIGTERM, then SIGKILL. Of the budget TearDown may use 70
// %; at 90 % whatever is left is killed; at 100 % the machine is stopped, come what may.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// A process that is torn down ends by itself; this long it is left alone.
constexpr Duration kExitGrace = Milliseconds(1000);

}  // namespace

void Decision::Stop(const Plan& plan, std::vector<RequestId> requests, std::uint64_t cause) {
  if (machine_.current) Supersede(machine_.number + 1, plan.target, cause);
  for (const RequestId request : std::exchange(machine_.set_up_requests, {})) {
    Do(action::AnswerCall{request, Error{kCodeStateInvalid, "the machine is being torn down"}});
  }
  const Duration budget = config_.shutdown_budget;
  Stopping stopping;
  stopping.begun = now_;
  stopping.tear_down_by = now_ + budget * 7 / 10;
  stopping.kill_at = now_ + budget * 9 / 10;
  stopping.give_up_at = now_ + budget;
  stopping.requests = std::move(requests);
  machine_.stopping = std::move(stopping);
  machine_.phase = Phase::kStopping;
  machine_.fallback.reset();
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    record.claim_again.reset();
    record.restart_at.reset();
    record.restart_asked = false;
    if (record.presence == Presence::kPresent) continue;
    record.fault.reset();  // what is not there cannot be left behind
    record.set_up_by.reset();
    if (const auto pid = OwnProcess(i); pid != 0) Do(action::SignalProcess{i, pid, false});
  }
  Begin(plan, Purpose::kStop, {}, cause);
}

void Decision::AfterTearDown(SwitchResult result) {
  Stopping& stopping = *machine_.stopping;
  stopping.result = std::move(result);
  const Duration grace = std::min(kExitGrace, config_.shutdown_budget / 10);
  stopping.terminate_at = std::min(now_ + grace, stopping.kill_at);
}

// The process that has to end with the machine: one that we started, or that a controller before us
// did. What somebody else started is theirs to end.
std::int32_t Decision::OwnProcess(std::size_t i) const {
  return ConfigOf(i).command.empty() ? 0 : ProcessOf(i);
}

bool Decision::ProcessesLeft() const {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    if (OwnProcess(i) != 0) return true;
  }
  return false;
}

void Decision::SignalProcesses(bool kill) {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const std::int32_t pid = OwnProcess(i);
    if (pid == 0) continue;
    RecordProcess(i, kCodeTimeout,
                  ConfigOf(i).name + " has not ended; process " + std::to_string(pid) +
                      (kill ? " gets SIGKILL" : " gets SIGTERM"));
    Do(action::SignalProcess{i, pid, kill});
  }
}

void Decision::AdvanceStopping() {
  Stopping& stopping = *machine_.stopping;
  if (stopping.terminate_at && now_ >= *stopping.terminate_at && !stopping.terminated) {
    stopping.terminated = true;
    SignalProcesses(false);
  }
  if (now_ >= stopping.kill_at && !stopping.killed) {
    stopping.killed = true;
    SignalProcesses(true);
  }
  ForcePower();
  const bool out_of_time = now_ >= stopping.give_up_at;
  if (out_of_time && machine_.current) EndUnfinished();
  if (!stopping.result || (ProcessesLeft() && !out_of_time)) return;
  machine_.phase = Phase::kStopped;
  RecordMachine(kCodeOk, "the machine is stopped after " +
                             std::to_string(ToMilliseconds(now_ - stopping.begun)) + " ms");
  Answer(stopping.requests, *stopping.result);
  if (machine_.policy.power) CommandPower(true);
  Do(action::Stopped{});
}

// The budget is used up while somebody still owes an answer to TearDown.
void Decision::EndUnfinished() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    if (Of(i).order)
      EndOrder(i, {ActuatorOutcome::kLost, kCodeTimeout, "no answer within the budget", true});
  }
  for (Leg& leg : machine_.current->legs) {
    if (leg.progress != Leg::Progress::kWaiting) continue;
    EndLeg(leg, {ActuatorOutcome::kSkipped, kCodeTimeout, "the budget was used up", false});
  }
  EndSwitch();
}

}  // namespace musher
