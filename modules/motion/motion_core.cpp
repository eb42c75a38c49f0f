#include "musher/modules/motion/motion_core.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "musher/modules/motion/motion_decision.hpp"

namespace musher::motion {
namespace {

using Key = MotionKey;

// The motion that get-down may interrupt.
constexpr std::array kDances = {140, 176, 177, 178};

constexpr std::size_t kMostMotions = 1000;  // of one request

std::string NameOf(const Motion& motion) {
  return std::to_string(motion.id) + " (" + motion.name + ")";
}

}  // namespace

// --- Checks
// --------------------------------------------------------------------------------------

Result<> Decision::MayRun(const Motion& motion, const std::string& capability) const {
  if (motion.id == kEmergencyStop) return Ok();
  if (core_.emergency_stop && motion.id != kRecoveryStand) {
    return Error{MotionCode(Key::kEstop), MotionCodeText(MotionCode(Key::kEstop))};
  }
  if (core_.closed) {
    return Error{MotionCode(KeyCode::kStateInvalid),
                 "no motion is permitted in " + std::string(*core_.closed)};
  }
  return rules_.allowed(capability);
}

Result<> Decision::CheckRequest(const MotionRequest& requested) const {
  const Motion* motion = rules_.table.Find(requested.id);
  if (motion == nullptr) {
    return Error{MotionCode(KeyCode::kUnSupport), "unknown motion " + std::to_string(requested.id)};
  }
  if (auto may = MayRun(*motion, motion->capability); !may) return may;
  const auto invalid = [&](const std::string& what) {
    return Error{MotionCode(KeyCode::kParametersInvalid),
                 "motion " + NameOf(*motion) + ": " + what};
  };
  if (!AllFinite(requested.arguments)) return invalid("a value is NaN or infinite");
  if (const auto wrong = WrongContact(requested.arguments.contact)) return invalid(*wrong);
  if (const auto wrong = WrongDuration(*motion, requested.arguments.duration_ms))
    return invalid(*wrong);
  return Ok();
}

Result<> Decision::CheckPlay(const motion_event::PlayArrived& event) const {
  if (event.requests.empty() || event.requests.size() > kMostMotions) {
    return Error{MotionCode(KeyCode::kParametersInvalid),
                 "expected 1 to " + std::to_string(kMostMotions) + " motions, found " +
                     std::to_string(event.requests.size())};
  }
  for (const MotionRequest& requested : event.requests) {
    if (auto good = CheckRequest(requested); !good) return good;
  }
  if (event.source == kFromMachine) {
    return Error{MotionCode(KeyCode::kPermissionDenied), "source FSM is the motion manager's own"};
  }
  if (rules_.config.priorities.count(event.source) == 0) {
    return Error{MotionCode(KeyCode::kParametersInvalid), "unknown " + SourceName(event.source)};
  }
  const bool interrupts = event.requests.front().id == kGetDown && Dancing();
  if (!core_.Idle() && !interrupts) {
    return Error{
        MotionCode(KeyCode::kTargetBusy),
        core_.servo
            ? "the body is controlled by servo commands of " + SourceName(core_.servo->source)
            : "motion " + std::to_string(core_.job->motion_id) + " is in progress"};
  }
  if (core_.BoardSilent()) {
    return Error{MotionCode(Key::kBoardSilent), MotionCodeText(MotionCode(Key::kBoardSilent))};
  }
  return Ok();
}

bool Decision::Dancing() const {
  if (!core_.job || core_.servo) return false;
  const std::int32_t id = core_.job->todo.front().command.id;
  return std::find(kDances.begin(), kDances.end(), id) != kDances.end();
}

// --- Events --------------------------------------------------------------------------------------

void Decision::Take(const motion_event::BoardReported& event) {
  const BodyReport before = core_.body.value_or(BodyReport{});
  core_.body = event.report;
  ReportMotors(before);
  core_.body_reported_at = now_;
  core_.board_silent = false;
  if (core_.link.until && Taken()) Quiet();
  AdvanceJob(false);
}

void Decision::Take(const motion_event::PlayArrived& event) {
  const std::int32_t id = event.requests.empty() ? 0 : event.requests.front().id;
  const bool stop = std::any_of(event.requests.begin(), event.requests.end(),
                                [](const MotionRequest& o) { return o.id == kEmergencyStop; });
  if (stop) return BeginEmergencyStop(event.token);
  if (const auto good = CheckPlay(event); !good) {
    const auto& [code, message] = good.error();
    Log(code, "motion " + std::to_string(id) + " of " + SourceName(event.source) +
                  " is refused: " + message);
    return Answer(event.token, id, code, message);
  }
  if (core_.job) DropJob(MotionCode(Key::kExecuteError), "interrupted by get-down");
  core_.emergency_stop = false;  // while it is set only recovery stand gets here
  Job job;
  job.token = event.token;
  job.motion_id = id;
  for (const MotionRequest& requested : event.requests) {
    const Motion& motion = *rules_.table.Find(requested.id);
    if (const auto wrong = WrongLength(requested.arguments)) {
      Log(MotionCode(KeyCode::kParametersInvalid),
          "motion " + NameOf(motion) + ": " + *wrong + "; zeros are used instead");
    }
    if (TooFast(motion, requested.arguments)) {
      Log(MotionCode(KeyCode::kOk),
          "motion " + NameOf(motion) + " is limited to its maximum speed");
    }
    job.todo.push_back(MotionOf(motion, requested.arguments));
  }
  BeginJob(std::move(job));
}

void Decision::Take(const motion_event::LieDown& event) {
  if (core_.servo) StopServo("the body lies down");
  if (core_.job) DropJob(MotionCode(KeyCode::kStateInvalid), "interrupted: the body lies down");
  if (Lies()) return Answer(event.token, event.id, kCodeOk, "");
  if (core_.emergency_stop) {
    const std::int32_t code = MotionCode(Key::kEstop);
    return Answer(event.token, event.id, code, MotionCodeText(code));
  }
  Job job;
  job.token = event.token;
  job.motion_id = event.id;
  job.own = true;
  job.tries = event.tries;
  job.todo.push_back(MotionOf(*rules_.table.Find(event.id), {}));
  BeginJob(std::move(job));
}

void Decision::Take(const motion_event::Cancelled& event) {
  if (!core_.job || core_.job->token != event.token) return;
  EndJob(MotionCode(KeyCode::kTimeout), "cancelled: timeout");
}

void Decision::Take(const motion_event::Closed& event) {
  core_.closed = event.state;
  const std::string why = "the machine goes to " + std::string(event.state);
  if (core_.servo) StopServo(why);
  if (!core_.job) return;
  const JobMotion motion = core_.job->todo.front();
  DropJob(MotionCode(KeyCode::kStateInvalid), why);
  if (motion.command.id != kEmergencyStop) HaltBody(motion);
}

void Decision::Take(const motion_event::Opened&) {
  core_.closed.reset();
}

void Decision::Take(const motion_event::EmergencyStop&) {
  BeginEmergencyStop(0);
}

void Decision::Take(const motion_event::WorldRestarted&) {
  if (core_.job) DropJob(MotionCode(Key::kBoardSilent), "the world was restarted");
  core_.servo.reset();
  core_.body.reset();
  core_.second_look.reset();
  core_.logged.clear();
  Quiet();
  core_.link.sent_at = Time::min();
}

void Decision::Take(const motion_event::TimePassed&) {
  if (LooksAgain()) return;
  WatchBoard();
  WatchServo();
  AdvanceJob(true);
  if (core_.link.until && now_ >= *core_.link.until) Quiet();
  TransmitIfDue();
  ReportServo();
}

// After the program or its host was suspended, timers are due before the messages of that time are
// read: the report or frame that seems to be missing may only wait. Only once, so that a process
// that is always late still detects timeouts.
bool Decision::LooksAgain() {
  if (core_.second_look) {
    if (now_ < *core_.second_look) return true;
    core_.second_look.reset();
    return false;
  }
  const auto deadline = NextDeadline(rules_, core_);
  if (!deadline || now_ - *deadline < kLate) return false;
  core_.second_look = now_ + kLate;
  return true;
}

// --- The board -----------------------------------------------------------------------------------

void Decision::WatchBoard() {
  if (core_.body && now_ - core_.body_reported_at >= rules_.config.board_silent) {
    core_.board_silent = true;
  }
}

const Motion* Decision::Present() const {
  return core_.body ? rules_.table.Find(core_.body->mode, core_.body->gait) : nullptr;
}

bool Decision::Taken() const {
  return core_.body && core_.body->life_count == core_.link.command.life_count;
}

JobMotion Decision::MotionOf(const Motion& motion, const MotionArguments& arguments) const {
  JobMotion job_motion;
  job_motion.command = MakeCommand(motion, arguments);
  job_motion.time = ExecutionTime(motion, arguments.duration_ms);
  return job_motion;
}

// A new command; it replaces the repeated one. Sent at once, or as soon as the link permits
// another frame.
void Decision::Command(const BodyCommand& command, bool at_once) {
  // The board may store the counts of its previous commander: do not use the one after its own.
  constexpr int kHighestLife = 127;
  constexpr int kFarAway = 64;
  const bool first = core_.link.sent_at == Time::min();
  const int last = first && core_.body
                       ? static_cast<std::uint8_t>(core_.body->life_count) + kFarAway
                       : core_.link.command.life_count;
  core_.link.command = command;
  core_.link.command.life_count = static_cast<std::int8_t>(last % kHighestLife + 1);
  core_.link.begun_at = now_;
  core_.link.active = true;
  core_.link.until.reset();
  if (at_once) {
    Transmit();
  } else {
    TransmitIfDue();
  }
}

// Stops a walk.
void Decision::Stand(const BodyCommand& last) {
  MotionArguments arguments;
  arguments.value = last.value;
  arguments.step_height = {last.step_height[0], last.step_height[1]};
  Command(MakeCommand(*rules_.table.Find(kWalkStand), arguments), true);
  core_.link.until = now_ + kStopRepeat;
}

void Decision::Quiet() {
  core_.link.active = false;
  core_.link.until.reset();
}

void Decision::Transmit() {
  core_.link.sent_at = now_;
  actions_.emplace_back(motion_action::Send{core_.link.command});
}

void Decision::TransmitIfDue() {
  const BoardLink& link = core_.link;
  const bool due = link.sent_at == Time::min() || now_ - link.sent_at >= kBoardPeriod;
  if (link.active && due) Transmit();
}

// --- Answers and logs
// ----------------------------------------------------------------------------

void Decision::Answer(RequestToken token, std::int32_t motion_id, std::int32_t code,
                      const std::string& message) {
  if (token != 0) actions_.emplace_back(motion_action::Answer{token, motion_id, code, message});
}

// The same code once in three minutes: a stream of invalid commands must not fill the log.
void Decision::Log(std::int32_t code, const std::string& text) {
  const bool low_battery = code == MotionCode(KeyCode::kProtectedError);
  if (low_battery &&
      (!core_.battery_low_announced || now_ - *core_.battery_low_announced >= kSayPause)) {
    core_.battery_low_announced = now_;
    actions_.emplace_back(motion_action::Say{kChargeFirst});
  }
  const auto last = core_.logged.find(code);
  if (last != core_.logged.end() && now_ - last->second < kLogPause) return;
  core_.logged[code] = now_;
  actions_.emplace_back(
      motion_action::Log{code == kCodeOk ? text : text + " (" + std::to_string(code) + ")"});
  if (IsBodyFault(code)) actions_.emplace_back(motion_action::ReportError{code});
}

// Reports faults that a motor has now and did not have before.
void Decision::ReportMotors(const BodyReport& before) {
  const auto& errors = core_.body->motor_error;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const std::int32_t code = CodeOfMotorError(errors.at(i) & ~before.motor_error.at(i));
    if (code != kCodeOk) Log(code, "motor " + std::to_string(i) + ": " + MotionCodeText(code));
  }
}

void Decision::ReportEmergencyStop() {
  const std::int32_t code = MotionCode(Key::kEstopReported);
  const auto last = core_.logged.find(code);
  if (last != core_.logged.end() && now_ - last->second < kLogPause) return;
  core_.logged[code] = now_;
  actions_.emplace_back(motion_action::ReportError{code});
}

// --- Interface
// -----------------------------------------------------------------------------------

MotionActions Step(const MotionRules& rules, MotionCore& core, const MotionEvent& event, Time now) {
  Decision decision(rules, core, now);
  std::visit([&](const auto& what) { decision.Take(what); }, event);
  return std::move(decision).Actions();
}

std::optional<Time> NextDeadline(const MotionRules& rules, const MotionCore& core) {
  if (core.second_look) return core.second_look;
  std::optional<Time> next;
  const auto consider = [&](Time time) { next = next ? std::min(*next, time) : time; };
  if (!core.BoardSilent()) consider(core.body_reported_at + rules.config.board_silent);
  if (core.job) consider(core.job->wait_end);
  if (core.servo) {
    consider(core.servo->last_frame + kServoWatchdog);
    consider(core.servo->next_report);
  }
  if (core.link.active) consider(core.link.sent_at + kBoardPeriod);
  if (core.link.until) consider(*core.link.until);
  return next;
}

std::int32_t PresentMotion(const MotionRules& rules, const MotionCore& core) {
  if (core.BoardSilent()) return kNoMotion;
  const Motion* motion = rules.table.Find(core.body->mode, core.body->gait);
  return motion == nullptr ? kNoMotion : motion->id;
}

}  // namespace musher::motion
