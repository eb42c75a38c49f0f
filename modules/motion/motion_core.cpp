#include "musher/modules/motion/motion_core.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "musher/modules/motion/user_gait.hpp"

namespace musher::motion {
namespace {

using Key = MotionKey;

// The motion that get-down may interrupt.
constexpr std::array kDances = {140, 176, 177, 178};

constexpr std::size_t kMostMotions = 1000;  // of one request
// Of a lie-down that another commander of the board keeps from its begin: its body is not laid
// down, and the machine gets the reason.
constexpr int kHeldTries = 3;

constexpr const char* kWasStopped = "the body was stopped";
constexpr const char* kWasClosed = "the machine was in ";

std::string NameOf(const Motion& motion) {
  return std::to_string(motion.id) + " (" + motion.name + ")";
}

// These do not end in WALK_STAND: force control holds the body in its place, and a body that lies
// down or is switched off does not stand up for it.
bool EndsStanding(const BodyCommand& last, const std::optional<State>& closed) {
  if (last.id == kForceControl) return false;
  return !closed || (*closed != kTearDown && *closed != kOta);
}

// Short motions such as flips and jumps run to their end: that is safer than an interruption.
constexpr Duration kShortMotion = Milliseconds(8000);

bool IsTransitioning(const BodyReport& body) {
  return body.switch_status == static_cast<std::int8_t>(SwitchStatus::kTransitioning);
}

// One step of the decision.
class Decision {
 public:
  Decision(const MotionRules& rules, MotionCore& core, Time now)
      : rules_(rules), core_(core), now_(now) {}

  void Take(const motion_event::BoardReported& event);
  void Take(const motion_event::ServoArrived& event);
  void Take(const motion_event::PlayArrived& event);
  void Take(const motion_event::LieDown& event);
  void Take(const motion_event::Cancelled& event);
  void Take(const motion_event::Closed& event);
  void Take(const motion_event::Opened& event);
  void Take(const motion_event::EmergencyStop& event);
  void Take(const motion_event::WorldRestarted& event);
  void Take(const motion_event::BoardRestarted& event);
  void Take(const motion_event::BoardHeld& event);
  void Take(const motion_event::OtherGait& event);
  void Take(const motion_event::BoardFault& event);
  void Take(const motion_event::TimePassed& event);

  MotionActions Actions() && { return std::move(actions_); }

  Result<> CheckPlay(const motion_event::PlayArrived& event) const;

 private:
  bool LooksAgain();
  bool IsStopped() const;
  void NoteDamped(const BodyReport& before);
  void LatchEmergencyStop();
  void KeepStop();
  std::optional<BodyCommand> Walk() const;
  void ForgetBody();

  // Checks.
  Result<> CheckBoard() const;
  Result<> MayRun(const Motion& motion, const std::string& capability) const;
  Result<> CheckRequest(const MotionRequest& requested) const;
  Result<> CheckServo(const motion_event::ServoArrived& event) const;
  Result<> CheckPriority(const ServoCommand& command) const;
  bool Dancing() const;

  // Servo.
  void EndServo(const ServoCommand& command);
  void FollowServo(const ServoCommand& command, const Motion& motion);
  void BeginServo();
  void StopServo(const std::string& why);
  void WatchServo();
  void WatchLying();
  bool IsLifted() const;
  void WatchLifted();
  void Interrupt(std::int32_t code, const std::string& why);
  void WatchServoMode();
  bool IsServoTaken() const;
  void ReportServo();
  void RefuseServo(const ServoCommand& command, const Error& error);

  // Jobs.
  void BeginEmergencyStop(RequestToken token);
  void BeginJob(Job job);
  void BeginMotion();
  std::vector<std::int32_t> WayTo(const Motion& motion) const;
  std::int32_t CodeOfRefusal() const;
  std::string TextOfRefusal(std::int32_t code) const;
  std::string TextNotTaken(Duration within) const;
  void AdvanceJob(bool time_passed);
  bool AdvanceWait(bool time_passed);
  void EndMotion();
  void EndJob(std::int32_t code, const std::string& message);
  void FailMotion(std::int32_t code, const std::string& message);
  void DropJob(std::int32_t code, const std::string& message);
  void HaltBody(const JobMotion& motion);
  bool Lies() const;
  bool IsDown() const;
  void WaitToLie();
  bool MayLieDown() const;

  // The board.
  void WatchBoard();
  const Motion* Present() const;
  bool Taken() const;
  JobMotion MotionOf(const Motion& motion, const MotionArguments& arguments) const;
  void Command(const BodyCommand& command, bool at_once);
  void CountCommand(int last);
  void Stand(const BodyCommand& last);
  bool StandIsRefused() const;
  void Quiet();
  bool RepeatsStop() const;
  void Transmit();
  void TransmitIfDue();

  void Answer(RequestToken token, std::int32_t motion_id, std::int32_t code,
              const std::string& message);
  void Log(std::int32_t code, const std::string& text);
  void ReportMotors(const BodyReport& before);
  void ReportFeet(const BodyReport& before);
  void ReportEmergencyStop();

  const MotionRules& rules_;
  MotionCore& core_;
  const Time now_;
  MotionActions actions_;
};

}  // namespace

// --- checks ---

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
  return CheckBoard();
}

// Whether the board can be commanded.
Result<> Decision::CheckBoard() const {
  if (!core_.board_held.empty()) return Error{MotionCode(KeyCode::kTargetBusy), core_.board_held};
  if (core_.BoardSilent()) {
    const std::int32_t code = MotionCode(Key::kBoardSilent);
    return Error{code, core_.time_jumped.empty() ? MotionCodeText(code) : core_.time_jumped};
  }
  return Ok();
}

bool Decision::Dancing() const {
  if (!core_.job || core_.servo) return false;
  const std::int32_t id = core_.job->todo.front().command.id;
  return std::find(kDances.begin(), kDances.end(), id) != kDances.end();
}

// --- events ---

void Decision::Take(const motion_event::BoardReported& event) {
  const BodyReport before = core_.body.value_or(BodyReport{});
  const bool was_stopped = core_.body && IsStopped();
  core_.body = event.report;
  if (IsStopped() && !was_stopped) LatchEmergencyStop();
  NoteDamped(before);
  ReportMotors(before);
  ReportFeet(before);
  core_.body_reported_at = now_ - event.age;
  core_.board_silent = false;
  core_.time_jumped.clear();
  if (core_.link.until && Taken()) Quiet();
  WatchServoMode();
  WatchLying();
  WatchLifted();
  AdvanceJob(false);
}

// The board lets the body lie down by itself, as after a hang of this process. What streams servo
// commands has to notice that.
void Decision::WatchLying() {
  if (!core_.servo || !core_.servo->moving) return;
  Servo& servo = *core_.servo;
  if (!IsDown()) return servo.down_since.reset();
  if (!servo.down_since) {
    servo.down_since = now_;
    Quiet();
  }
  if (now_ - *servo.down_since < kLiesTime) return;
  Interrupt(MotionCode(Key::kBoardSilent), "the body has lain down by itself");
  StopServo("the body lies");
}

bool Decision::IsLifted() const {
  return core_.body && core_.body->switch_status == static_cast<std::int8_t>(SwitchStatus::kLifted);
}

// A board goes on with the walk that it has once the body is put down.
void Decision::WatchLifted() {
  if (!IsLifted()) return;
  if (core_.servo) {
    Interrupt(MotionCode(Key::kLifted), "the body was lifted");
    StopServo("the body is lifted");
  }
  const bool stands = core_.link.until && core_.link.command.id == kWalkStand;
  if (stands) core_.link.until = now_ + kStopRepeat;
}

void Decision::Interrupt(std::int32_t code, const std::string& why) {
  auto& stream = core_.interrupted_stream;
  std::set<std::int32_t> sources = stream ? std::move(stream->sources) : std::set<std::int32_t>();
  if (core_.servo) sources.insert(core_.servo->source);
  if (core_.last_source) sources.insert(*core_.last_source);
  stream = {now_, code, why, std::move(sources)};
}

// After it only recovery stand may follow.
bool Decision::IsStopped() const {
  const Motion* present = Present();
  const auto is = [&](SwitchStatus status) {
    return core_.body->switch_status == static_cast<std::int8_t>(status);
  };
  return (present != nullptr && present->id == kEmergencyStop) || is(SwitchStatus::kEstop) ||
         is(SwitchStatus::kEdamp);
}

void Decision::NoteDamped(const BodyReport& before) {
  const bool damped = core_.body->switch_status == static_cast<std::int8_t>(SwitchStatus::kEdamp);
  if (!damped || !IsDown()) return core_.damped_since.reset();
  if (!core_.damped_since || core_.body->bar != before.bar) core_.damped_since = now_;
}

// The body was stopped by another commander, such as remote control, by the board itself, or by an
// earlier process. A lie-down of the machine goes on, without a command: the body lies soon.
void Decision::LatchEmergencyStop() {
  if (std::exchange(core_.emergency_stop, true)) return;
  core_.stopped_at_board = true;
  Interrupt(MotionCode(Key::kEstop), kWasStopped);
  const std::int32_t status = CodeOfStatus(core_.body->switch_status);
  const std::int32_t code = MotionCode(Key::kEstop);
  const std::string text =
      "the body is stopped, off or in damping: it takes no motion before recovery stand (111)";
  actions_.emplace_back(motion_action::Log{text});
  if (IsBodyFault(status)) actions_.emplace_back(motion_action::ReportError{status});
  if (core_.servo) {
    if (core_.job && core_.job->for_servo) core_.job.reset();
    core_.servo.reset();
    actions_.emplace_back(
        motion_action::ServoResponse{kNoMotion, core_.servo_commands, 0, 0, false, code});
  }
  if (core_.job && core_.job->own) return WaitToLie();
  if (core_.job) DropJob(status != kCodeOk ? status : code, text);
  Quiet();
}

// A recovery stand that has not stood the body up leaves it stopped.
void Decision::KeepStop() {
  if (core_.body && IsStopped()) core_.emergency_stop = true;
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
    if (const auto limited = LimitedArrays(motion, requested.arguments); !limited.empty()) {
      Log(MotionCode(KeyCode::kOk),
          "motion " + NameOf(motion) + " is limited to its ranges: " + limited);
    }
    job.todo.push_back(MotionOf(motion, requested.arguments));
  }
  BeginJob(std::move(job));
}

void Decision::Take(const motion_event::LieDown& event) {
  if (core_.servo) StopServo("the body lies down");
  const bool stops = core_.job && core_.job->motion_id == kEmergencyStop;
  const std::string why = "interrupted: the body lies down";
  if (stops) {
    EndJob(MotionCode(KeyCode::kStateInvalid), why);  // it is sent on
  } else if (core_.job) {
    DropJob(MotionCode(KeyCode::kStateInvalid), why);
  }
  if (Lies()) return Answer(event.token, event.id, kCodeOk, "");
  Job job;
  job.token = event.token;
  job.motion_id = event.id;
  job.own = true;
  job.tries = event.tries;
  job.todo.push_back(MotionOf(*rules_.table.Find(event.id), {}));
  const bool held = !core_.board_held.empty();
  if (held && event.tries == 0) job.tries = kHeldTries;
  if (!core_.emergency_stop && !held) return BeginJob(std::move(job));
  core_.job = std::move(job);
  WaitToLie();
}

void Decision::Take(const motion_event::Cancelled& event) {
  if (!core_.job || core_.job->token != event.token) return;
  EndJob(MotionCode(KeyCode::kTimeout), "cancelled: timeout");
}

void Decision::Take(const motion_event::Closed& event) {
  core_.closed = event.state;
  const std::string why = "the machine goes to " + std::string(event.state);
  if (core_.servo) {
    Interrupt(MotionCode(KeyCode::kStateInvalid), kWasClosed + std::string(event.state));
    StopServo(why);
  }
  if (!core_.job || core_.job->motion_id == kEmergencyStop) return;
  const JobMotion motion = core_.job->todo.front();
  DropJob(MotionCode(KeyCode::kStateInvalid), why);
  HaltBody(motion);
}

void Decision::Take(const motion_event::Opened&) {
  core_.closed.reset();
}

void Decision::Take(const motion_event::EmergencyStop&) {
  BeginEmergencyStop(0);
}

void Decision::Take(const motion_event::WorldRestarted& event) {
  const auto walk = Walk();
  if (core_.job) DropJob(MotionCode(Key::kBoardSilent), event.why);
  core_.servo.reset();
  core_.logged.clear();
  core_.stop_sent_at = {};  // the time may have gone back
  ForgetBody();
  core_.time_jumped = event.why;
  if (walk) Stand(*walk);
  // The board may not have taken it. What the board has set by itself is not for it to take: motion
  // 0 would let a body that it damps drop.
  if (core_.emergency_stop && !core_.stopped_at_board) BeginEmergencyStop(0);
}

// The command of the walk in progress.
std::optional<BodyCommand> Decision::Walk() const {
  const auto limited = [&](const BodyCommand& command) {
    return rules_.table.Find(command.id)->limit.has_value();
  };
  if (core_.servo && core_.servo->moving) {
    if (!EndsStanding(core_.servo->command, core_.closed)) return std::nullopt;
    return core_.servo->command;
  }
  if (core_.job && limited(core_.job->todo.front().command)) {
    return core_.job->todo.front().command;
  }
  return std::nullopt;
}

void Decision::ForgetBody() {
  core_.body.reset();
  core_.damped_since.reset();
  core_.second_look.reset();
  Quiet();
  core_.link.sent_at = Time::min();
  core_.link.next_change = {};  // the time may have gone back
}

void Decision::Take(const motion_event::BoardRestarted&) {
  const std::int32_t code = MotionCode(Key::kBoardSilent);
  const bool stops = core_.job && core_.job->motion_id == kEmergencyStop;
  // Also one that was refused while the board was silent.
  Interrupt(MotionCode(Key::kBoardSilent), "the motion board has restarted");
  if (core_.servo) {
    core_.servo.reset();
    actions_.emplace_back(
        motion_action::ServoResponse{kNoMotion, core_.servo_commands, -1, -1, false, code});
  }
  if (stops) return;  // which goes on until the board has taken it
  if (core_.job) DropJob(code, "the motion board has restarted");
  ForgetBody();
}

void Decision::Take(const motion_event::BoardHeld& event) {
  const std::string& why = core_.board_held = event.why;
  if (why.empty()) return;
  if (core_.servo) StopServo(why);
  if (!core_.job || core_.job->own) return;
  const JobMotion motion = core_.job->todo.front();
  DropJob(MotionCode(KeyCode::kTargetBusy), why);
  if (rules_.table.Find(motion.command.id)->limit) Stand(motion.command);
}

void Decision::Take(const motion_event::OtherGait& event) {
  const std::int32_t code = MotionCode(Key::kSequenceDefinition);
  Log(code, event.why);
  if (!core_.job) return;
  const auto& todo = core_.job->todo;
  const bool plays = std::any_of(todo.begin(), todo.end(), [&](const JobMotion& motion) {
    return PlaysUserGait(*rules_.table.Find(motion.command.id));
  });
  if (plays) EndJob(code, event.why);
}

void Decision::Take(const motion_event::BoardFault& event) {
  actions_.emplace_back(motion_action::Log{event.text + " (" + std::to_string(event.code) + ")"});
  if (IsBodyFault(event.code)) actions_.emplace_back(motion_action::ReportError{event.code});
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

// --- the board ---

void Decision::WatchBoard() {
  if (core_.body && now_ - core_.body_reported_at >= rules_.config.board_silent) {
    core_.board_silent = true;
    core_.damped_since.reset();
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
  constexpr int kFarAway = 64;
  const bool first = core_.link.sent_at == Time::min();
  const int last = first && core_.body
                       ? static_cast<std::uint8_t>(core_.body->life_count) + kFarAway
                       : core_.link.command.life_count;
  core_.link.command = command;
  CountCommand(last);
  core_.link.begun_at = now_;
  core_.link.active = true;
  core_.link.until.reset();
  if (at_once) {
    Transmit();
  } else {
    TransmitIfDue();
  }
}

// The command is a new one for the board: its count differs from the last one.
void Decision::CountCommand(int last) {
  constexpr int kHighestLife = 127;
  core_.link.command.life_count = static_cast<std::int8_t>(last % kHighestLife + 1);
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
  core_.link.sent.reset();
  core_.link.until.reset();
}

bool Decision::RepeatsStop() const {
  return core_.link.active && core_.link.command.id == kEmergencyStop;
}

void Decision::Transmit() {
  BoardLink& link = core_.link;
  if (link.IsChanged()) {
    // One frame ahead at most, although some are sent before they are due.
    const Time due = std::max(link.next_change, now_);
    link.next_change = std::min(due, now_ + kLeastBoardPeriod) + kLeastBoardPeriod;
  }
  link.sent_at = now_;
  link.sent = link.command;
  actions_.emplace_back(motion_action::Send{core_.link.command});
}

void Decision::TransmitIfDue() {
  if (!core_.link.active || now_ < core_.link.NextFrame()) return;
  if (StandIsRefused()) CountCommand(core_.link.command.life_count);
  Transmit();
}

// A board that has refused WALK_STAND, because of a fault of the body, takes it with another count
// only; repeated, it would keep up the walk before it.
bool Decision::StandIsRefused() const {
  const BoardLink& link = core_.link;
  const bool reported = core_.body && core_.body_reported_at > link.begun_at;
  return link.until && link.command.id == kWalkStand && reported && !Taken() &&
         CodeOfStatus(core_.body->switch_status) != kCodeOk;
}

// --- answers and logs ---

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
    const std::int32_t added = errors.at(i) & ~before.motor_error.at(i);
    const std::int32_t code = CodeOfMotorError(added);
    if (code != kCodeOk) Log(code, MotorName(i) + ": " + MotorFaultText(added));
  }
}

// The same of a foot that is not where it should be.
void Decision::ReportFeet(const BodyReport& before) {
  const int added = core_.body->footpos_error & ~before.footpos_error;
  const std::string feet = FootFaultText(static_cast<std::int16_t>(added));
  if (!feet.empty()) Log(MotionCode(Key::kFootPosition), "feet in the wrong place: " + feet);
}

void Decision::ReportEmergencyStop() {
  const std::int32_t code = MotionCode(Key::kEstopReported);
  const auto last = core_.logged.find(code);
  if (last != core_.logged.end() && now_ - last->second < kLogPause) return;
  core_.logged[code] = now_;
  actions_.emplace_back(motion_action::ReportError{code});
}

// --- servo commands ---

void Decision::Take(const motion_event::ServoArrived& event) {
  const ServoCommand& command = event.command;
  // The body has one stream at a time: what interrupts one holds for all, until each that has sent
  // a frame since has ended, or no frame has come for a while.
  auto& interrupted = core_.interrupted_stream;
  if (command.type == ServoCommand::kEnd) {
    if (core_.last_source == command.source) core_.last_source.reset();
    const bool ends = interrupted && interrupted->sources.erase(command.source) > 0;
    if (ends && interrupted->sources.empty()) interrupted.reset();
    return EndServo(command);
  }
  core_.last_source = command.source;
  if (interrupted && now_ - interrupted->last_frame >= kServoWatchdog) interrupted.reset();
  if (IsLifted()) {
    Interrupt(MotionCode(Key::kLifted), "the body was lifted");
  } else if (core_.emergency_stop) {
    Interrupt(MotionCode(Key::kEstop), kWasStopped);
  } else if (core_.closed) {
    Interrupt(MotionCode(KeyCode::kStateInvalid), kWasClosed + std::string(*core_.closed));
  } else if (interrupted) {
    interrupted->last_frame = now_;
    interrupted->sources.insert(command.source);
  }
  if (const auto good = CheckServo(event); !good) return RefuseServo(command, good.error());
  FollowServo(command, *rules_.table.Find(command.requested.id));
}

Result<> Decision::CheckServo(const motion_event::ServoArrived& event) const {
  const ServoCommand& command = event.command;
  const MotionRequest& requested = command.requested;
  const auto invalid = [](const std::string& what) {
    return Error{MotionCode(KeyCode::kParametersInvalid), what};
  };
  const Motion* motion = rules_.table.Find(requested.id);
  if (motion == nullptr || motion->servo.empty()) {
    return Error{MotionCode(KeyCode::kUnSupport),
                 "unknown servo motion " + std::to_string(requested.id)};
  }
  if (core_.emergency_stop) {
    return Error{MotionCode(Key::kEstop), MotionCodeText(MotionCode(Key::kEstop))};
  }
  if (auto may = MayRun(*motion, motion->servo); !may) return may;
  if (command.type != ServoCommand::kStart && command.type != ServoCommand::kData) {
    return invalid("cmd_type must be 0, 1 or 2, it is " + std::to_string(command.type));
  }
  if (!AllFinite(requested.arguments)) return invalid("a value is NaN or infinite");
  if (const auto wrong = WrongLength(requested.arguments)) return invalid(*wrong);
  if (auto priority = CheckPriority(command); !priority) return priority;
  if (event.could_not_run && !core_.servo) {
    return Error{MotionCode(KeyCode::kTimeout),
                 CouldNotRunText(*event.could_not_run) +
                     ", and the stream may be over; one that goes on is followed 2 s later"};
  }
  const bool resumes = core_.job && core_.job->way_of == command.source;
  if (core_.job && !core_.servo && !resumes) {
    return Error{MotionCode(KeyCode::kTargetBusy),
                 "motion " + std::to_string(core_.job->motion_id) + " is in progress"};
  }
  if (core_.interrupted_stream) {
    const auto& [last_frame, code, why, sources] = *core_.interrupted_stream;
    return Error{code, why + "; end the stream, or pause it for 200 ms"};
  }
  return core_.servo ? Ok() : CheckBoard();
}

Result<> Decision::CheckPriority(const ServoCommand& command) const {
  const Priorities& priorities = rules_.config.priorities;
  const auto priority = priorities.find(command.source);
  if (priority == priorities.end()) {
    return Error{MotionCode(KeyCode::kParametersInvalid), "unknown " + SourceName(command.source)};
  }
  if (core_.servo && priority->second > priorities.at(core_.servo->source)) {
    return Error{MotionCode(KeyCode::kFailed),
                 SourceName(core_.servo->source) + " controls the body and has priority"};
  }
  return Ok();
}

// A stop is always taken, except from a source with lower priority than the controlling one.
void Decision::EndServo(const ServoCommand& command) {
  if (const auto priority = CheckPriority(command); !priority) {
    return RefuseServo(command, priority.error());
  }
  if (core_.servo) return StopServo("");
  actions_.emplace_back(
      motion_action::ServoResponse{command.requested.id, core_.servo_commands, 0, 0, true});
}

void Decision::FollowServo(const ServoCommand& command, const Motion& motion) {
  const bool begins = !core_.servo;
  const bool changes = begins || core_.servo->command.id != motion.id;
  if (begins) {
    core_.servo.emplace();
    core_.servo->next_report = now_;
  }
  if (core_.job) {  // the body stands up for this stream, maybe before it stalled
    core_.job->way_of = command.source;
    core_.job->for_servo = true;
  }
  Servo& servo = *core_.servo;
  // Once for each priority: the frames of the lower one are refused from then on.
  const Priorities& priorities = rules_.config.priorities;
  const bool takes_over = !begins && priorities.at(command.source) != priorities.at(servo.source);
  servo.source = command.source;
  // The next frame of the stream changes its motion once the link permits one.
  const bool early = changes && !begins && !takes_over && core_.link.active &&
                     now_ < core_.link.next_change - kLeastBoardPeriod;
  // A body that lies changes no motion: the stream ends soon, unless the report was only old.
  const bool waits = changes && !core_.job && (servo.down_since || early);
  if (!waits) servo.command = MakeCommand(motion, command.requested.arguments);
  servo.last_frame = now_;
  ++core_.servo_commands;
  const std::string limited = LimitedArrays(motion, command.requested.arguments);
  if (!limited.empty() && !std::exchange(servo.limit_logged, true)) {
    Log(kCodeOk, "servo motion " + std::to_string(motion.id) + " of " + SourceName(command.source) +
                     " is limited to its ranges: " + limited);
  }
  if (changes && !core_.job && !waits) {
    if (const auto way = WayTo(motion); !way.empty()) {
      servo.moving = false;
      Job job;
      job.motion_id = motion.id;
      job.way_of = command.source;
      job.for_servo = true;
      for (const std::int32_t id : way) {
        job.todo.push_back(MotionOf(*rules_.table.Find(id), {}));
        job.todo.back().requested = false;
      }
      BeginJob(std::move(job));
    } else {
      servo.moving = true;
      Command(servo.command, true);  // it may not wait: it is permitted now
    }
  } else if (servo.moving && !waits && !IsDown()) {
    Command(servo.command, false);
  }
  ReportServo();
}

// The body is free.
void Decision::BeginServo() {
  Servo& servo = *core_.servo;
  const Motion& motion = *rules_.table.Find(servo.command.id);
  if (const auto may = MayRun(motion, motion.servo); !may) {
    ServoCommand command;
    command.requested.id = motion.id;
    core_.servo.reset();
    Quiet();
    return RefuseServo(command, may.error());
  }
  servo.moving = true;
  Command(servo.command, true);
}

void Decision::StopServo(const std::string& why) {
  const Servo servo = *std::exchange(core_.servo, std::nullopt);
  if (core_.job && core_.job->for_servo) core_.job->for_servo = false;  // it finishes standing up
  if (servo.moving) {
    if (EndsStanding(servo.command, core_.closed) && !IsDown()) {
      Stand(servo.command);
    } else {
      Quiet();
    }
  }
  if (!why.empty()) {
    Log(MotionCode(KeyCode::kStatusError), "the servo motion " + std::to_string(servo.command.id) +
                                               " of " + SourceName(servo.source) +
                                               " is stopped: " + why);
  }
  actions_.emplace_back(motion_action::ServoResponse{
      PresentMotion(rules_, core_), core_.servo_commands,
      core_.body ? core_.body->bar : std::int8_t{-1},
      core_.body ? core_.body->switch_status : std::int8_t{-1}, why.empty(), kCodeOk});
}

void Decision::WatchServo() {
  if (!core_.servo || now_ - core_.servo->last_frame < kServoWatchdog) return;
  StopServo("no frame for 200 ms");
}

// Since when the board reports another mode than that of the stream, by the times of its reports:
// after a hang of this process the last one is old. A body that lies: see WatchLying.
void Decision::WatchServoMode() {
  if (!core_.servo) return;
  Servo& servo = *core_.servo;
  const bool other = servo.moving && !IsDown() && core_.body->mode != servo.command.mode;
  if (!other) servo.other_since.reset();
  if (other && !servo.other_since) servo.other_since = core_.body_reported_at;
}

bool Decision::IsServoTaken() const {
  const auto& since = core_.servo->other_since;
  return !since || core_.body_reported_at - *since < kOtherModeTime;
}

// The streaming source gets the board's feedback periodically.
void Decision::ReportServo() {
  if (!core_.servo || now_ < core_.servo->next_report) return;
  core_.servo->next_report = now_ + kBoardPeriod;
  motion_action::ServoResponse response;
  bool taken = true;
  response.cmd_id = core_.servo_commands;
  if (core_.BoardSilent()) {
    response.code = MotionCode(Key::kBoardSilent);
  } else {
    response.motion_id = PresentMotion(rules_, core_);
    response.bar = core_.body->bar;
    response.status = core_.body->switch_status;
    response.code = CodeOfStatus(core_.body->switch_status);
    taken = IsServoTaken() || response.code != kCodeOk;
    if (!taken) response.code = MotionCode(Key::kBoardSilent);
    response.result = response.code == kCodeOk;
  }
  if (!response.result) {
    Log(response.code, "servo motion " + std::to_string(core_.servo->command.id) + ": " +
                           (taken ? MotionCodeText(response.code) : TextNotTaken(kOtherModeTime)));
  }
  actions_.emplace_back(response);
}

void Decision::RefuseServo(const ServoCommand& command, const Error& error) {
  Log(error.code, "servo motion " + std::to_string(command.requested.id) + " of " +
                      SourceName(command.source) + " is refused: " + error.message);
  actions_.emplace_back(motion_action::ServoResponse{
      command.requested.id, core_.servo_commands, 0,
      core_.body ? core_.body->switch_status : std::int8_t{-1}, false, error.code});
}

// --- jobs: motions executed to their end ---

void Decision::BeginEmergencyStop(RequestToken token) {
  const std::int32_t code = MotionCode(Key::kEstop);
  const bool was_set = std::exchange(core_.emergency_stop, true);
  core_.stopped_at_board = false;
  Interrupt(MotionCode(Key::kEstop), kWasStopped);
  if (core_.job) DropJob(code, "interrupted by emergency stop");
  if (core_.servo) {
    core_.servo.reset();
    actions_.emplace_back(
        motion_action::ServoResponse{kNoMotion, core_.servo_commands, 0, 0, false, code});
  }
  if (!was_set) {
    actions_.emplace_back(motion_action::Log{"emergency stop"});
    ReportEmergencyStop();
  }
  core_.stop_sent_at = now_;
  Job job;
  job.token = token;
  job.motion_id = kEmergencyStop;
  job.own = true;
  job.todo.push_back(MotionOf(*rules_.table.Find(kEmergencyStop), {}));
  BeginJob(std::move(job));
}

void Decision::BeginJob(Job job) {
  core_.job = std::move(job);
  BeginMotion();
}

void Decision::BeginMotion() {
  Job& job = *core_.job;
  const Motion& motion = *rules_.table.Find(job.todo.front().command.id);
  if (!job.own && job.todo.front().requested) {
    if (const auto may = MayRun(motion, motion.capability); !may) {
      return EndJob(may.error().code, may.error().message);
    }
  }
  if (!std::exchange(job.todo.front().prepared, true)) {
    std::vector<JobMotion> before;
    for (const std::int32_t id : WayTo(motion)) {
      before.push_back(MotionOf(*rules_.table.Find(id), {}));
      before.back().requested = false;
      before.back().prepared = true;
    }
    job.todo.insert(job.todo.begin(), before.begin(), before.end());
  }
  Command(job.todo.front().command, true);
  job.wait = Job::Wait::kFeedback;
  job.wait_end = now_ + rules_.config.board_feedback;
}

// The motions needed before it from the body's present motion: none, or to stand up.
std::vector<std::int32_t> Decision::WayTo(const Motion& motion) const {
  if (motion.id == kEmergencyStop || motion.id == kRecoveryStand) return {};
  const Motion* present = Present();
  if (present != nullptr && present->MayGoTo(motion.mode)) return {};
  if (motion.id != kFromGroundStand) return {kRecoveryStand};
  const bool direct = present != nullptr && present->MayGoTo(rules_.table.Find(kGroundStand)->mode);
  if (direct) return {kGroundStand};
  return {kRecoveryStand, kGroundStand};
}

// Why the board has not taken a command: its reported status, or a timeout if it reports none.
std::int32_t Decision::CodeOfRefusal() const {
  const bool reported = core_.body && core_.body_reported_at > core_.link.begun_at;
  const std::int32_t code = reported ? CodeOfStatus(core_.body->switch_status) : kCodeOk;
  return code != kCodeOk ? code : MotionCode(Key::kBoardSilent);
}

std::string Decision::TextOfRefusal(std::int32_t code) const {
  if (code != MotionCode(Key::kBoardSilent) || core_.BoardSilent()) return MotionCodeText(code);
  return TextNotTaken(rules_.config.board_feedback);
}

std::string Decision::TextNotTaken(Duration within) const {
  return "the motion board has not taken it within " + std::to_string(ToMilliseconds(within)) +
         " ms; it reports mode " + std::to_string(core_.body->mode) + ", gait " +
         std::to_string(core_.body->gait);
}

// A report of the board does not end a wait: a newer one may be queued behind it.
void Decision::AdvanceJob(bool time_passed) {
  while (core_.job && AdvanceWait(time_passed)) {
  }
}

// Returns whether the job made progress.
bool Decision::AdvanceWait(bool time_passed) {
  Job& job = *core_.job;
  const bool over = time_passed && now_ >= job.wait_end;
  const auto go_on = [&](Job::Wait wait, Duration time) {
    job.wait = wait;
    job.wait_end = now_ + time;
    return true;
  };
  const auto fail = [&](std::int32_t code) {
    FailMotion(code, MotionCodeText(code));
    return true;
  };
  if (job.wait == Job::Wait::kRetry) {
    if (!over) return false;
    if (Lies()) {
      EndJob(kCodeOk, "");
    } else if (core_.emergency_stop && IsDown() && !core_.BoardSilent()) {
      WaitToLie();
    } else if (!core_.board_held.empty()) {
      FailMotion(MotionCode(KeyCode::kTargetBusy), core_.board_held);
    } else if (core_.emergency_stop && !MayLieDown()) {
      return fail(MotionCode(Key::kEstop));
    } else {
      BeginMotion();
    }
    return true;
  }
  if (job.wait == Job::Wait::kFeedback) {
    if (Taken()) return go_on(Job::Wait::kSettle, kSettleTime);
    if (!over) return false;
    const std::int32_t code = CodeOfRefusal();
    FailMotion(code, TextOfRefusal(code));
    return true;
  }
  if (job.wait == Job::Wait::kSettle) {
    return over && go_on(Job::Wait::kTransition, kTransitionTime);
  }
  const BodyCommand& command = job.todo.front().command;
  const std::int32_t code = CodeOfStatus(core_.body->switch_status);
  if (code != kCodeOk && command.id != kEmergencyStop) return fail(code);
  if (job.wait == Job::Wait::kTransition) {
    if (!IsTransitioning(*core_.body) && !core_.body->ambiguous) {
      return go_on(Job::Wait::kExecution, job.todo.front().time);
    }
    return over && fail(MotionCode(Key::kTransitionTimeout));
  }
  const Motion* present = Present();
  if (present != nullptr && present->id == command.id && core_.body->bar > kDoneBar) {
    EndMotion();
    return true;
  }
  return over && fail(MotionCode(Key::kExecuteTimeout));
}

void Decision::EndMotion() {
  Job& job = *core_.job;
  if (job.todo.size() == 1) return EndJob(kCodeOk, "");
  job.todo.pop_front();
  BeginMotion();
}

// A lie-down is retried as often as permitted.
void Decision::FailMotion(std::int32_t code, const std::string& message) {
  Job& job = *core_.job;
  const std::string what = "motion " + std::to_string(job.todo.front().command.id) + ": " + message;
  if (!job.tries || *job.tries == 1) return EndJob(code, what);
  Log(code, what + "; retrying");
  if (*job.tries > 1) --*job.tries;
  WaitToLie();
}

// Nothing is commanded meanwhile; an emergency stop is sent on.
void Decision::WaitToLie() {
  Job& job = *core_.job;
  job.todo.erase(job.todo.begin(), std::prev(job.todo.end()));
  job.todo.front().prepared = false;
  job.wait = Job::Wait::kRetry;
  job.wait_end = now_ + kLieDownPause;
  if (!RepeatsStop()) Quiet();
}

// Under the latch: from a normal motion, without recovery stand.
bool Decision::MayLieDown() const {
  const Motion* present = Present();
  const Motion& down = *rules_.table.Find(core_.job->todo.back().command.id);
  if (present == nullptr || core_.BoardSilent() || IsStopped()) return false;
  return !RepeatsStop() && present->MayGoTo(down.mode);
}

void Decision::EndJob(std::int32_t code, const std::string& message) {
  const Job job = *std::exchange(core_.job, std::nullopt);
  KeepStop();
  const BodyCommand& last = job.todo.front().command;
  const Motion& motion = *rules_.table.Find(last.id);
  if (last.id == kEmergencyStop && !Taken()) {
    core_.link.until = Time::max();  // repeated until the board takes it
  } else if (motion.limit) {
    Stand(last);  // no walk continues after its command has ended
  } else if (PlaysUserGait(motion) && code != kCodeOk) {
    // It may go on, and WALK_STAND may not follow it.
    Command(MotionOf(*rules_.table.Find(kRecoveryStand), {}).command, true);
    core_.link.until = now_ + kStopRepeat;
  } else if (last.id == kEmergencyStop || !RepeatsStop()) {
    Quiet();
  }
  if (code != kCodeOk) Log(code, message);
  if (!job.for_servo) return Answer(job.token, job.motion_id, code, message);
  if (code == kCodeOk) return BeginServo();
  ServoCommand command;
  command.source = core_.servo->source;
  command.requested.id = core_.servo->command.id;
  core_.servo.reset();
  RefuseServo(command, {code, message});
}

// Ends the job for a more urgent request, which commands the board next.
void Decision::DropJob(std::int32_t code, const std::string& message) {
  const Job job = *std::exchange(core_.job, std::nullopt);
  KeepStop();
  if (job.motion_id == kEmergencyStop || !RepeatsStop()) Quiet();
  Answer(job.token, job.motion_id, code, message);
}

// Ends a motion that was dropped. If the body lies down next, only a walk is stopped before.
void Decision::HaltBody(const JobMotion& motion) {
  const State& state = *core_.closed;
  const bool passes = state == kOta || state == kTearDown;
  const bool lies_down = passes || state == kLowPower;
  const bool ends_itself = motion.time <= kShortMotion || motion.command.id == kRecoveryStand;
  if (rules_.table.Find(motion.command.id)->limit) {
    if (!passes) Stand(motion.command);
  } else if (!ends_itself && !lies_down) {
    Command(MotionOf(*rules_.table.Find(kRecoveryStand), {}).command, true);
    core_.link.until = now_ + kStopRepeat;
  }
}

bool Decision::Lies() const {
  const Motion* present = Present();
  if (present == nullptr || core_.BoardSilent()) return false;
  const Duration time = ExecutionTime(*rules_.table.Find(kGetDown), 0);
  const bool sunk = core_.damped_since && now_ - *core_.damped_since >= time;
  return present->id == kEmergencyStop || (IsDown() && (sunk || core_.body->bar > kDoneBar));
}

// It lies, or lies down.
bool Decision::IsDown() const {
  const Motion* present = Present();
  return present != nullptr && (present->id == kGetDown || present->id == kPassiveGetDown);
}

// --- interface ---

bool BoardLink::IsChanged() const {
  BodyCommand last = sent.value_or(BodyCommand{});
  last.life_count = command.life_count;
  return !sent || last != command;
}

Time BoardLink::NextFrame() const {
  if (sent_at == Time::min()) return sent_at;
  const Time repeated = sent_at + kBoardPeriod;
  return IsChanged() ? std::min(next_change - kLeastBoardPeriod, repeated) : repeated;
}

Result<> MayPlay(const MotionRules& rules, const MotionCore& core,
                 const motion_event::PlayArrived& event) {
  MotionCore copy = core;
  return Decision(rules, copy, Time{}).CheckPlay(event);
}

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
  if (core.link.active) consider(core.link.NextFrame());
  if (core.link.until) consider(*core.link.until);
  return next;
}

std::int32_t PresentMotion(const MotionRules& rules, const MotionCore& core) {
  if (core.BoardSilent()) return kNoMotion;
  const Motion* motion = rules.table.Find(core.body->mode, core.body->gait);
  return motion == nullptr ? kNoMotion : motion->id;
}

std::string CouldNotRunText(Duration length) {
  return "the motion manager could not run for " + std::to_string(ToMilliseconds(length) / 1000) +
         " s";
}

std::string StopTrouble(const MotionRules& rules, const MotionCore& core) {
  if (!core.emergency_stop) return "";
  const std::string held = core.board_held.empty() ? "" : "; " + core.board_held;
  if (core.BoardSilent())
    return "the motion board is silent: it may not have taken the stop" + held;
  // It may have been off before, and report that still.
  if (core.body->motors_taken)
    return "another program moves the motors: no stop reaches them" + held;
  const bool stopped = core.body->switch_status == static_cast<std::int8_t>(SwitchStatus::kEstop);
  if (stopped || PresentMotion(rules, core) == kEmergencyStop) {
    const bool taken = core.body->life_count == core.link.command.life_count;
    if (taken || core.body_reported_at > core.stop_sent_at) return "";
    return "the motion board has not reported since the stop" + held;
  }
  if (core.body->switch_status == static_cast<std::int8_t>(SwitchStatus::kEdamp))
    return "the motion board damps the body, which is not yet off" + held;
  return "the motion board has not taken the stop: it reports mode " +
         std::to_string(core.body->mode) + ", gait " + std::to_string(core.body->gait) + held;
}

}  // namespace musher::motion
