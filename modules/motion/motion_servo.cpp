#include <utility>

#include "musher/modules/motion/motion_decision.hpp"

namespace musher::motion {
namespace {

using Key = MotionKey;

// These do not end in WALK_STAND: force control holds the body in its place, and a body that lies
// down or is switched off does not stand up for it.
bool EndsStanding(const BodyCommand& last, const std::optional<State>& closed) {
  if (last.id == kForceControl) return false;
  return !closed || (*closed != kTearDown && *closed != kOta);
}

}  // namespace

void Decision::Take(const motion_event::ServoArrived& event) {
  const ServoCommand& command = event.command;
  if (command.type == ServoCommand::kEnd) return EndServo(command);
  if (const auto good = CheckServo(command); !good) return RefuseServo(command, good.error());
  FollowServo(command, *rules_.table.Find(command.requested.id));
}

Result<> Decision::CheckServo(const ServoCommand& command) const {
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
  const bool resumes = core_.job && core_.job->way_of == command.source;
  if (core_.job && !core_.servo && !resumes) {
    return Error{MotionCode(KeyCode::kTargetBusy),
                 "motion " + std::to_string(core_.job->motion_id) + " is in progress"};
  }
  if (!core_.servo && core_.BoardSilent()) {
    return Error{MotionCode(Key::kBoardSilent), MotionCodeText(MotionCode(Key::kBoardSilent))};
  }
  return Ok();
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
  servo.source = command.source;
  servo.command = MakeCommand(motion, command.requested.arguments);
  servo.last_frame = now_;
  ++core_.servo_commands;
  if (TooFast(motion, command.requested.arguments) && !std::exchange(servo.limit_logged, true)) {
    Log(kCodeOk, "servo motion " + std::to_string(motion.id) + " of " + SourceName(command.source) +
                     " is limited to its maximum speed");
  }
  if (changes && !core_.job) {
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
      Command(servo.command, true);
    }
  } else if (servo.moving) {
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
    if (EndsStanding(servo.command, core_.closed)) {
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

// The streaming source gets the board's feedback periodically.
void Decision::ReportServo() {
  if (!core_.servo || now_ < core_.servo->next_report) return;
  core_.servo->next_report = now_ + kBoardPeriod;
  motion_action::ServoResponse response;
  response.cmd_id = core_.servo_commands;
  if (core_.BoardSilent()) {
    response.code = MotionCode(Key::kBoardSilent);
  } else {
    response.motion_id = PresentMotion(rules_, core_);
    response.bar = core_.body->bar;
    response.status = core_.body->switch_status;
    response.code = CodeOfStatus(core_.body->switch_status);
    response.result = response.code == kCodeOk;
  }
  if (!response.result) {
    Log(response.code, "servo motion " + std::to_string(core_.servo->command.id) + ": " +
                           MotionCodeText(response.code));
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

}  // namespace musher::motion
