#include "musher/application/application_impl.hpp"

#include <utility>

#include "musher/application/refusal.hpp"
#include "musher/base/break_watch.hpp"
#include "musher/base/check.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"

namespace musher {

ApplicationImpl::ApplicationImpl(MachineActuator& actuator, double rate_hz)
    : actuator_(actuator), rate_hz_(rate_hz) {
  MUSHER_CHECK(rate_hz > 0);
}

Result<> ApplicationImpl::Run(const State& state) {
  if (state == kSetUp) {
    actuator_.RunOnLoop([this] { open_ = false; });
    return SetUp();
  }
  if (state == kSelfCheck) return SelfCheck();
  Result<> result;
  actuator_.RunOnLoop([&] {
    if (state == kActive) {
      result = Activate();
    } else {
      Leave(state);
    }
  });
  return result;
}

void ApplicationImpl::OnEmergencyStop() {
  if (!open_) return;
  const std::string moves = StopAtOnce();
  const std::string& trouble = pause_fault_.empty() ? moves : pause_fault_;
  if (!trouble.empty()) actuator_.ReportStopTrouble(trouble);
}

Result<> ApplicationImpl::Open(const std::function<void(transport::Endpoints&)>& open) {
  Result<> opened = actuator_.OpenEndpoints([&](transport::Endpoints& topics) {
    ticks_.Open(topics);
    open(topics);
  });
  actuator_.RunOnLoop([&] { open_ = opened.ok(); });
  return opened;
}

void ApplicationImpl::ServeCommands(transport::Endpoints& topics,
                                    std::function<Result<>(const std::string& command)> send,
                                    std::function<bool(const std::string& command)> is_urgent) {
  topics.Serve<msg::SendCommand>(actuator_.name() + "/send_command",
                                 [this, send = std::move(send), is_urgent = std::move(is_urgent)](
                                     const auto& request, auto reply) {
                                   Result<> sent =
                                       is_urgent(request.command) ? Ok() : CheckNotLate();
                                   if (sent) sent = send(request.command);
                                   reply({sent.ok(), sent ? "" : sent.error().message});
                                 });
}

Result<> ApplicationImpl::CheckNotLate() const {
  const auto could_not_run = ticks_.RecentBreak();
  if (!could_not_run) return Ok();
  return Refused<ApplicationRefusal::kMayBeLate>(actuator_.name(),
                                                 ToMilliseconds(*could_not_run) / 1000);
}

std::optional<std::string> ApplicationImpl::TakeLongBreak() {
  const auto could_not_run = ticks_.TakeBreak();
  if (!could_not_run || *could_not_run <= BreakWatch::kLong) return std::nullopt;
  return "its process could not run for " + std::to_string(ToMilliseconds(*could_not_run) / 1000) +
         " s";
}

Result<> ApplicationImpl::CheckNoStop() const {
  if (!actuator_.EmergencyStopped()) return Ok();
  return Refused<ApplicationRefusal::kStoppedMeanwhile>();
}

void ApplicationImpl::StartTicks() {
  ticking_ = true;
  ticks_.Start(rate_hz_, [this] { Tick(); });
}

void ApplicationImpl::StopTicks() {
  ticks_.Stop();
  ticking_ = false;
}

std::string ApplicationImpl::Whereabouts() const {
  return actuator_.CurrentState() + (actuator_.HeldByStop() ? ", held by the emergency stop" : "");
}

void ApplicationImpl::CallOnPause(const std::function<void()>& hook) {
  const auto thrown = Thrown("OnPause", hook);
  if (!pause_fault_.empty()) {
    actuator_.ReportFault({kCodeOk, pause_fault_});
    actuator_.ReportStopTrouble("");
    pause_fault_.clear();
  }
  if (!thrown) return;
  actuator_.Log(LogLevel::kError, "fault: " + *thrown);
  pause_fault_ = *thrown + "; its outputs may not be neutral";
  actuator_.ReportFault({kCodeFailed, pause_fault_});
}

void CheckStopped(const std::string& name, bool started) {
  MUSHER_CHECK(!started, name,
               "is destroyed while it is started, and the members that its hooks use are already "
               "destroyed; use Run(), Wait() or musher::ActuatorRunner");
}

}  // namespace musher
