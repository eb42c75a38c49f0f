#include "musher/modules/meilin/nodes/wait_nodes.hpp"

#include <chrono>

#include <fmt/format.h>

namespace musher::meilin {
namespace {

// Its server repeats the state of the arm 5 times a second.
constexpr Duration kArmStateAge = std::chrono::seconds(1);

bool IsOver(Time now, Time begun, double limit_s) {
  return limit_s > 0 && now - begun >= std::chrono::duration<double>(limit_s);
}

}  // namespace

using tree::Status;

WaitArmIdle::WaitArmIdle(tree::Setup& setup, Robot& robot)
    : timeout_s_(setup.Input<double>("timeout_sec", 30.0, "s; 0: no limit")),
      message_(setup.Output<std::string>("message", "\"Arm idle\", or the failure")),
      robot_(robot),
      board_(setup.board()) {}

Status WaitArmIdle::OnStart(const tree::Tick& tick) {
  begun_ = tick.now;
  board_.active_action.Set("WaitArmIdle");
  board_.SetState(kActionRunning);
  return Look(tick.now);
}

Status WaitArmIdle::Look(Time now) {
  const Signal& idle = robot_.arm_idle();
  const bool fresh = now >= idle.at && now - idle.at <= kArmStateAge;
  if (fresh && idle.value == true) {
    message_.Set("Arm idle");
    return Status::kSuccess;
  }
  if (!IsOver(now, begun_, timeout_s_.Get())) return Status::kRunning;
  const std::string why = fmt::format("WaitArmIdle timed out ({:g} s; {})", timeout_s_.Get(),
                                      !idle.value ? "no message of the arm came"
                                      : fresh     ? "the arm is not idle"
                                                  : "no message of the arm comes any more");
  board_.Fail(why);
  message_.Set(why);
  return Status::kFailure;
}

WaitForR1Signal::WaitForR1Signal(tree::Setup& setup, Robot& robot)
    : topic_(setup.OptionalInput<std::string>("signal_topic", "r1_ready, of the config")),
      timeout_s_(setup.Input<double>("timeout_sec", 60.0, "s; 0: no limit")),
      robot_(robot),
      board_(setup.board()) {
  const std::string* topic = topic_.entry() == nullptr ? topic_.Find() : nullptr;
  if (topic != nullptr && *topic != "r1_ready" && *topic != "/r1_ready") {
    setup.Report("signal_topic", Severity::kError,
                 "port 'signal_topic': the mission subscribes r1_ready; found '" + *topic + "'");
  }
}

Status WaitForR1Signal::Evaluate(const tree::Tick& tick) {
  if (!running()) {
    begun_ = tick.now;
    const int docked = board_.dock_trues.Get();
    trues_ = docked >= 0 ? static_cast<std::uint64_t>(docked) : robot_.partner_ready().trues;
    board_.active_action.Set("WaitForR1Signal");
    board_.SetState(kActionRunning);
  }
  const Signal& ready = robot_.partner_ready();
  if (ready.value == true && ready.trues > trues_) return Status::kSuccess;
  if (!IsOver(tick.now, begun_, timeout_s_.Get())) return Status::kRunning;
  board_.Fail(fmt::format("WaitForR1Signal timed out ({:g} s without r1_ready; {})",
                          timeout_s_.Get(),
                          ready.value ? "the partner is not ready" : "no message of it came"));
  return Status::kFailure;
}

WaitSeconds::WaitSeconds(tree::Setup& setup) : seconds_(setup.Input<double>("seconds", "s")) {}

Status WaitSeconds::OnStart(const tree::Tick& tick) {
  begun_ = tick.now;
  return OnRunning(tick);
}

Status WaitSeconds::OnRunning(const tree::Tick& tick) {
  const std::chrono::duration<double> waited = tick.now - begun_;
  return waited.count() < seconds_.Get() ? Status::kRunning : Status::kSuccess;
}

SetDebugStatus::SetDebugStatus(tree::Setup& setup)
    : execution_state_(setup.OptionalInput<std::string>("execution_state", "\"MEILIN_SUCCESS\"")),
      active_action_(setup.OptionalInput<std::string>("active_action")),
      last_error_(setup.OptionalInput<std::string>("last_error")),
      retry_count_(setup.OptionalInput<int>("retry_count")),
      board_(setup.board()) {}

Status SetDebugStatus::Do(const tree::Tick&) {
  if (const std::string* state = execution_state_.Find()) board_.execution_state.Set(*state);
  if (const std::string* action = active_action_.Find()) board_.active_action.Set(*action);
  if (const std::string* error = last_error_.Find()) board_.last_error.Set(*error);
  if (const int* count = retry_count_.Find()) board_.retry_count.Set(*count);
  return Status::kSuccess;
}

IsSegmentType::IsSegmentType(tree::Setup& setup)
    : type_(setup.Input<std::string>("segment_type", "of the present segment")),
      expected_(setup.Input<std::string>("expected_type", "\"move\"")) {}

Status IsSegmentType::Evaluate(const tree::Tick&) {
  return type_.Get() == expected_.Get() ? Status::kSuccess : Status::kFailure;
}

}  // namespace musher::meilin
