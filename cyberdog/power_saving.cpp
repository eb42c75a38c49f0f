#include "musher/cyberdog/power_saving.hpp"

#include <utility>

namespace musher::cyberdog {
namespace {

constexpr const char* kService = "low_power_consumption";

}  // namespace

PowerSaving::PowerSaving(transport::Endpoints& endpoints, ControllerShell& shell)
    : shell_(shell),
      loop_(endpoints.node().loop()),
      client_(endpoints.OpenClient<msg::SetBool>(kService, [this] {
        on_.reset();  // another power manager, or none: its state is unknown
        given_up_.reset();
        Look();
      })) {}

// LowPower because of the battery applies only to the actuators, as on CyberDog.
bool PowerSaving::Wanted() const {
  const Machine& machine = shell_.machine();
  const auto& current = machine.current;
  const bool leaves = current && !current->only && current->direction != Direction::kCheck &&
                      current->target != kLowPower;
  return machine.state == kLowPower && !leaves && !machine.policy.stored.lowering &&
         waiting_.empty() && !answered_;
}

// What waits was requested before the stop, whose release alone moves nothing.
void PowerSaving::OnRecord() {
  if (shell_.machine().emergency.stop) {
    AnswerWaiting(Error{kCodeProtectedError, "an emergency stop is engaged"});
  }
  Look();
}

void PowerSaving::Look() {
  const Phase phase = shell_.machine().phase;
  const bool leads = phase != Phase::kIdle && phase != Phase::kFenced;
  if (!leads || !client_->Ready()) return AnswerWaiting(Ok());
  const bool wanted = Wanted();
  if (on_ == wanted) {
    given_up_.reset();
    if (!wanted) AnswerWaiting(Ok());
  } else if (!calling_ && !again_ && given_up_ != wanted) {
    Call(wanted);
  }
}

void PowerSaving::Call(bool on) {
  if (std::exchange(trying_, on) != on) tries_ = 0;
  ++tries_;
  calling_ = true;
  client_->Call({on}, kCallTime, [this, on](const auto& reply) {
    calling_ = false;
    if (reply && reply.value().success) {
      on_ = on;
      trying_.reset();
      return Look();
    }
    OnFailure(on, reply ? Error{kCodeFailed, "refused: " + reply.value().message} : reply.error());
  });
}

void PowerSaving::OnFailure(bool on, const Error& why) {
  on_.reset();
  if (Wanted() != on || !client_->Ready()) {
    trying_.reset();
    return Look();
  }
  if (tries_ < kTries) {
    again_ = loop_.At(loop_.Now() + kPause, [this] {
      again_ = nullptr;
      Look();
    });
    return;
  }
  trying_.reset();
  given_up_ = on;
  const Error failure = {why.code, std::string(kService) + " " + (on ? "true" : "false") +
                                       " failed " + std::to_string(kTries) +
                                       " times: " + why.message};
  shell_.Remark(failure.code, failure.message);
  if (!on) AnswerWaiting(failure);
}

void PowerSaving::Leave(std::function<void(const Result<>&)> then) {
  waiting_.push_back(std::move(then));
  given_up_.reset();
  Look();
}

// The waiting requests continue now; if a switch is refused, the machine and the board stay in
// LowPower.
void PowerSaving::AnswerWaiting(const Result<>& left) {
  if (waiting_.empty()) return;
  answered_ = loop_.At(loop_.Now(), [this] {
    answered_ = nullptr;
    Look();
  });
  for (const auto& then : std::exchange(waiting_, {})) then(left);
}

}  // namespace musher::cyberdog
