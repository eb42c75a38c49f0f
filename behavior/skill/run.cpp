#include "musher/behavior/skill/run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "musher/behavior/skill/check.hpp"

namespace musher::skill {
namespace {

constexpr Duration kFarthest{kFarthestNs};

std::string WithReason(const std::string& what, const std::string& why) {
  return why.empty() ? what : what + ": " + why;
}

}  // namespace

std::string_view Name(Cause cause) {
  constexpr std::array<std::string_view, 7> kNames{"requested", "decided",   "retried", "replanned",
                                                   "limit",     "cancelled", "fault"};
  return kNames[static_cast<std::size_t>(cause)];
}

// The text of an exception of the skill.
template <class Call>
std::optional<std::string> Run::Thrown(const char* function, Call&& call) {
  try {
    call();
    return std::nullopt;
  } catch (const std::exception& thrown) {
    return std::string(function) + ": " + thrown.what();
  } catch (...) {
    return std::string(function) + ": threw something that is not a std::exception";
  }
}

Run::Run(std::string name, std::unique_ptr<Skill> skill, const Settings& settings)
    : name_(std::move(name)), skill_(std::move(skill)) {
  MUSHER_CHECK(skill_ != nullptr);
  if (const auto thrown = Thrown("Declare", [&] { skill_->Declare(table_); })) {
    built_ = Error{kCodeFailed, name_ + ": " + *thrown};
    return;
  }
  built_ = CheckErrors(name_, table_);
  if (const Result<> applied = table_.Apply(settings); built_ && !applied) {
    built_ = Error{applied.error().code, name_ + ": " + applied.error().message};
  }
  inside_ = skill_->inside();
  feedback_.state = table_.Name(kIdle);
}

Run::~Run() = default;

Result<> Run::Begin(const Values& parameters) {
  if (!built_) return built_;
  if (state_ != kIdle) {
    return Error{kCodeStateInvalid, name_ + ": has begun before; it is in " + Path()};
  }
  Result<Values> complete = table_.Complete(parameters);
  if (!complete) {
    return Error{complete.error().code, name_ + ": " + complete.error().message};
  }
  parameters_ = std::move(complete).value();
  Move(table_.first(), Cause::kRequested, "");
  return Ok();
}

void Run::Step(Duration step) {
  if (!running() || in_step_) return;
  if (pause_requested_ && !cancel_requested_) return;
  pause_requested_ = false;
  feedback_.paused = false;
  if (std::exchange(paused_, false)) {
    if (const auto thrown = Thrown("OnResume", [&] { skill_->OnResume(); })) {
      return FailByFault(*thrown);
    }
  }
  const Duration passed =
      std::exchange(fresh_, false) ? Duration{} : std::clamp(step, Duration{}, kFarthest - now_);
  now_ += passed;
  elapsed_ += passed;
  ++ticks_;
  Tick tick = MakeTick(passed);
  Next next = Next::Stay();
  in_step_ = true;
  const auto thrown = Thrown(cancel_requested_ && !cancel_passed_ ? "Cancel" : "Step",
                             [&] { next = Decide(tick); });
  in_step_ = false;
  Take(tick);
  if (thrown) return FailByFault(*thrown);
  Execute(next);
  CheckLimits();
  ShowState();
}

Tick Run::MakeTick(Duration step) {
  return {.state = state_,
          .entered = std::exchange(entered_, false),
          .now = now_,
          .step = step,
          .elapsed = elapsed_,
          .parameters = parameters_,
          .data = data_,
          .cancelling = cancel_requested_,
          .retries = retries_,
          .replans = replans_};
}

Next Run::Decide(Tick& tick) {
  limit_decides_ = false;
  if (cancel_requested_ && !std::exchange(cancel_passed_, true)) return skill_->Cancel(tick);
  Next next = skill_->Step(tick);
  if (next.kind() != Next::Kind::kStay || elapsed_ < table_.LimitOf(state_)) return next;
  limit_decides_ = true;
  return skill_->OnLimit(tick);
}

// Takes the feedback of a step.
void Run::Take(Tick& tick) {
  feedback_.details = std::move(tick.details);
  if (!tick.reported) return;
  feedback_.message = std::move(tick.reported_message);
  if (std::isnan(tick.reported_progress)) return;
  constexpr double kMost = 99;  // 100 is the success
  const int progress = static_cast<int>(std::clamp(tick.reported_progress, 0.0, kMost));
  feedback_.progress = table_.monotone() ? std::max(feedback_.progress, progress) : progress;
}

void Run::Execute(const Next& next) {
  const Cause cause = limit_decides_ ? Cause::kLimit : Cause::kDecided;
  const bool declared = next.kind() == Next::Kind::kStay || next.kind() == Next::Kind::kFail ||
                        next.kind() == Next::Kind::kCancel ||
                        (table_.Declared(state_, next.target()) &&
                         (next.kind() == Next::Kind::kSucceed || !IsEnd(next.target())));
  if (!declared) {
    const std::string_view to = table_.Name(next.target());
    return FailByFault("it has not declared its transition from " +
                       std::string(table_.Name(state_)) + " to " +
                       (to.empty() ? "an unknown state" : std::string(to)));
  }
  switch (next.kind()) {
    case Next::Kind::kStay:
      return;
    case Next::Kind::kTo:
      return Move(next.target(), cause, next.message());
    case Next::Kind::kFail:
      return End(Status::kFailed, cause, next.message());
    case Next::Kind::kCancel:
      return End(Status::kCancelled, cancel_requested_ ? Cause::kCancelled : cause, next.message());
    case Next::Kind::kSucceed:
      if (!cancel_requested_) return End(Status::kCompleted, cause, next.message());
      return End(Status::kCancelled, Cause::kCancelled, "");
    case Next::Kind::kRetry:
    case Next::Kind::kReplan:
      break;
  }
  Note(next.message());
  if (cancel_requested_) return End(Status::kCancelled, Cause::kCancelled, "");
  if (next.kind() == Next::Kind::kReplan) {
    ++replans_;
    return Move(next.target(), Cause::kReplanned, next.message());
  }
  const int most = table_.limits().retries;
  if (retries_ >= most) {
    return End(
        Status::kFailed, Cause::kLimit,
        WithReason("gives up after " + std::to_string(retries_) + " retries", next.message()));
  }
  ++retries_;
  feedback_.message = "Retrying (" + std::to_string(retries_) + "/" + std::to_string(most) + ")";
  Move(next.target(), Cause::kRetried, next.message());
}

void Run::Move(StateId target, Cause cause, const std::string& why) {
  history_.Add({now_, ticks_, state_, target, cause, why});
  state_ = target;
  entered_ = true;
  elapsed_ = {};
  if (cause != Cause::kRetried && !why.empty()) feedback_.message = why;
  ShowState();
  if (changed_) changed_(*this, history_.back());
}

void Run::CheckLimits() {
  if (!running()) return;
  const Limits& limits = table_.limits();
  if (cancel_requested_ && now_ - cancel_at_ >= limits.cancel) {
    return End(Status::kCancelled, Cause::kLimit,
               "its cancellation was not done after " + SecondsText(limits.cancel));
  }
  if (now_ >= limits.run) {
    End(Status::kFailed, Cause::kLimit, "not done after " + SecondsText(limits.run));
  }
}

void Run::FailByFault(const std::string& what) {
  if (running()) End(Status::kFailed, Cause::kFault, what);
}

void Run::End(Status status, Cause cause, std::string message) {
  const StateId from = state_;
  if (message.empty() && status == Status::kCancelled) {
    message = cancel_why_.empty() ? "no reason was given" : cancel_why_;
  }
  if (message.empty()) message = status == Status::kCompleted ? "Completed" : "Failed";
  in_step_ = true;
  const auto thrown = Thrown("OnEnd", [&] { skill_->OnEnd({status, from, message, paused_}); });
  in_step_ = false;
  if (thrown) {
    end_fault_ = *thrown;
    if (status == Status::kCompleted) {
      status = Status::kFailed;
      cause = Cause::kFault;
      message = *thrown;
    } else {
      Note(*thrown);
    }
  }
  if (status == Status::kFailed) Note(message);
  feedback_.status = status;
  feedback_.paused = false;
  feedback_.message = message;
  if (status == Status::kCompleted) feedback_.progress = 100;
  const StateId end = status == Status::kCompleted ? kSucceeded
                      : status == Status::kFailed  ? kFailed
                                                   : kCancelled;
  Move(end, cause, message);
}

std::string Run::EndFault() const {
  if (!end_fault_.empty()) return name_ + ": " + end_fault_;
  for (const Run* run : inside_) {
    if (std::string fault = run->EndFault(); !fault.empty()) return fault;
  }
  return "";
}

void Run::Note(const std::string& what) {
  errors_.Add({now_, std::string(table_.Name(state_)), what});
}

void Run::Pause() {
  fresh_ = true;
  if (!running() || in_step_ || std::exchange(paused_, true)) return;
  feedback_.paused = true;
  if (const auto thrown = Thrown("OnPause", [&] { skill_->OnPause(); })) {
    paused_ = false;  // its outputs may not be neutral
    FailByFault(*thrown);
  }
  ShowState();  // a skill inside may have failed
}

std::string Run::WhyNotPaused() const {
  if (!running()) return name_ + " does not run";
  if (!table_.cannot_pause().empty()) {
    return name_ + " cannot be paused: " + table_.cannot_pause();
  }
  for (const Run* run : inside_) {
    if (!run->running()) continue;
    if (std::string why = run->WhyNotPaused(); !why.empty()) return why;
  }
  return "";
}

Result<> Run::PauseUntilResumed(const std::string& why) {
  std::string refused = WhyNotPaused();
  if (refused.empty() && pause_requested_) refused = name_ + " is paused already";
  if (refused.empty() && cancel_requested_) refused = name_ + " is being cancelled";
  if (!refused.empty()) return Error{kCodeStateInvalid, refused};
  pause_requested_ = true;
  pause_why_ = why;
  Pause();
  if (!running()) return Error{kCodeFailed, name_ + " has failed: " + feedback_.message};
  return Ok();
}

Result<> Run::MayResume() {
  Result<> may = Ok();
  if (const auto thrown = Thrown("MayResume", [&] { may = skill_->MayResume(); })) {
    return Error{kCodeFailed, *thrown};
  }
  for (Run* run : inside_) {
    if (may && run->running()) may = run->MayResume();
  }
  return may;
}

Result<> Run::Resume() {
  if (!pause_requested()) {
    return Error{kCodeStateInvalid,
                 name_ + (running() ? " is not paused by a request" : " does not run")};
  }
  if (const Result<> may = MayResume(); !may) {
    return Error{may.error().code, name_ + " stays paused: " + may.error().message};
  }
  pause_requested_ = false;
  return Ok();
}

void Run::Cancel(const std::string& why) {
  if (!running() || std::exchange(cancel_requested_, true)) return;
  cancel_why_ = why;
  cancel_at_ = now_;
  // Its outputs are neutral, and its parts may be those of another skill by now.
  if (pause_requested_ && !in_step_) End(Status::kCancelled, Cause::kCancelled, "");
}

void Run::CancelNow(const std::string& why) {
  if (!running()) return;
  Cancel(why);
  if (in_step_ || ended()) return;
  End(Status::kCancelled, Cause::kCancelled, "");
}

void Run::FailNow(const std::string& why) {
  if (!in_step_) FailByFault(why);
}

void Run::ShowState() {
  feedback_.state = Path();
}

std::string Run::Path() const {
  std::string below;
  std::size_t count = 0;
  for (const Run* run : inside_) {
    if (!run->running()) continue;
    below += (count++ == 0 ? "" : ", ") + run->name() + "/" + run->Path();
  }
  if (count == 0 || !running()) return std::string(table_.Name(state_));
  return std::string(table_.Name(state_)) + "/" + (count == 1 ? below : "[" + below + "]");
}

fsm::Chart Run::chart() const {
  fsm::Chart chart = table_.chart();
  chart.name = name_;
  skill_->Draw(chart);
  return chart;
}

}  // namespace musher::skill
