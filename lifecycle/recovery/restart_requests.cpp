// Restarts that a person requests.

#include "musher/lifecycle/recovery/recovery.hpp"

#include <utility>

#include "musher/base/suggest.hpp"

namespace musher {

void Recovery::On(const event::RestartRequested& requested) {
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
  if (record.presence == Presence::kPresent && ProcessOf(*i) == 0) {
    return refuse(kCodeUnSupport,
                  requested.actuator +
                      " was not started by this controller, and its process is not known: end it "
                      "where it was started; a second one would run beside it");
  }
  record.restart.requests.push_back(requested.request);
  if (record.restart.requested) return;
  record.restart.requested = true;
  record.restart.count = 0;
  record.restart.given_up = false;
  record.cause = RecordProcess(*i, kCodeOk, texts::RestartRequested(requested.actuator));
  EndForRestart(*i);
}

// TearDown if it can be commanded, else SIGTERM, and SIGKILL when that does not help.
void Recovery::EndForRestart(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  const std::int32_t pid = ProcessOf(i);
  if (pid == 0 && record.process.launch ==
                      Launch::kUnderWay) {  // the start that is under way is the one requested
    record.restart.requested = false;
    record.presence = Presence::kStarting;
    record.set_up_by = now_ + config_.TimeFor(i, kSetUp);
    return;
  }
  if (pid == 0) return processes_.Recover(i);
  const bool can_be_commanded = record.presence == Presence::kPresent && !record.command &&
                                !record.report.busy() && !machine_.current &&
                                record.health != Health::kHung && ConfigOf(i).Lists(kTearDown) &&
                                record.state() != kTearDown;
  if (can_be_commanded) {
    return commands_.Issue(i, machine_.number + 1, State(kTearDown), config_.TimeFor(i, kTearDown),
                           true);
  }
  processes_.Terminate(i, pid, kEndTime);
  Do(action::SignalProcess{i, pid, false});
}

// Answers the restart requests when it is back, or when it will not come back.
void Recovery::AnswerRestarts(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  if (IsComing(i)) return;
  const bool ended = machine_.phase != Phase::kRunning && machine_.phase != Phase::kFailed;
  const bool may_go_on = record.due && !machine_.emergency.stop;
  const bool driven =
      ((Fits(i) || record.join_tried) && !may_go_on) || machine_.phase == Phase::kFailed;
  const bool there = record.presence == Presence::kPresent && !record.command && driven;
  if (!ended && !there && !record.fault) return;
  Result<> answer;
  if (record.fault) {
    answer = Error(*record.fault);
  } else if (!there) {
    answer = Error{kCodeStateInvalid, "the machine is being torn down"};
  }
  for (const RequestId request : std::exchange(record.restart.requests, {})) {
    Do(action::AnswerCall{request, answer});
  }
}

}  // namespace musher
