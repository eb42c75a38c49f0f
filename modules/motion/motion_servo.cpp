#include <utility>

#include "musher/modules/motion/motion_decision.hpp"

namespace musher::motion {
namespace {

using Key = MotionKey;

// These do not end in WALK_STAND: force control holds the body in its place, and who lies down or
// ends does not stand up for it.
bool EndsStanding(const BodyCommand& last, const std::optional<State>& closed) {
  if (last.id == kForceControl) return false;
  return !closed || (*closed != kTearDown && *closed != kOta);
}

}  // namespace

void Decision::Take(const motion_event::ServoArrived& event) {
  const ServoCommand& command = event.command;
  if (command.type == ServoCommand::kEnd) return EndServo(command);
  if (const auto good = CheckServo(command); !good) return RefuseServo(command, good.error());
  FollowServo(command, *rules_.table.Find(command.order.id));
}

Result<> Decision::CheckServo(const ServoCommand& command) const {
  const MotionOrder& order = command.order;
  const auto invalid = [](const std::string& what) {
    return Error{MotionCode(KeyCode::kParametersInvalid), what};
  };
  const Motion* motion = rules_.table.Find(order.id);
  if (motion == nullptr || motion->servo.empty()) {
    return Error{MotionCode(KeyCode::kUnSupport),
                 "there is no servo motion " + std::to_string(order.id)};
  }
  if (core_.emergency_stop) {
    return Error{MotionCode(Key::kEstop), MotionCodeText(MotionCode(Key::kEstop))};
  }
  if (auto may = MayRun(*motion, motion->servo); !may) return may;
  if (command.type != ServoCommand::kStart && command.type != ServoCommand::kData) {
    return invalid("cmd_type must be 0, 1 or 2, it is " + std::to_string(command.type));
  }
  if (!AllFinite(order.arguments)) return invalid("a number is no number, or infinite");
  if (const auto wrong = WrongLength(order.arguments)) return invalid(*wrong);
  if (auto priority = CheckPriority(command); !priority) return priority;
  const bool resumes = core_.job && core_.job->way_of == command.source;
  if (core_.job && !core_.servo && !resumes) {
    return Error{MotionCode(KeyCode::kTargetBusy),
                 "motion " + std::to_string(core_.job->motion_id) + " is under way"};
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
    return Error{MotionCode(KeyCode::kParametersInvalid),
                 "nobody knows " + SourceName(command.source)};
  }
  if (core_.servo && priority->second > priorities.at(core_.servo->source)) {
    return Error{MotionCode(KeyCode::kFailed),
                 SourceName(core_.servo->source) + " has the body, which has priority"};
  }
  return Ok();
}

// A stop is always taken, but from those who have less priority than who has the body.
void Decision::EndServo(const ServoCommand& command) {
  if (const auto priority = CheckPriority(command); !priority) {
    return RefuseServo(command, priority.error());
  }
  if (core_.servo) return StopServo("");
  actions_.emplace_back(
      motion_action::TellServo{command.order.id, core_.servo_commands, 0, 0, true});
}

void Decision::FollowServo(const ServoCommand& command, const Motion& motion) {
  const bool begins = !core_.servo;
  const bool changes = begins || core_.servo->command.id != motion.id;
  if (begins) {
    core_.servo.emplace();
    core_.servo->next_report = now_;
  }
  if (core_.job) {  // the body stands up for it, or for the same stream before it stalled
    core_.job->way_of = command.source;
    core_.job->for_servo = true;
  }
  Servo& servo = *core_.servo;
  servo.source = command.source;
  servo.command = MakeCommand(motion, command.order.arguments);
  servo.last_frame = now_;
  ++core_.servo_commands;
  if (TooFast(motion, command.order.arguments) && !std::exchange(servo.told_limit, true)) {
    Log(kCodeOk, "servo motion " + std::to_string(motion.id) + " of " + SourceName(command.source) +
                     " is slowed down to its limits");
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
        job.todo.back().asked = false;
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

// The way is free.
void Decision::BeginServo() {
  Servo& servo = *core_.servo;
  const Motion& motion = *rules_.table.Find(servo.command.id);
  if (const auto may = MayRun(motion, motion.servo); !may) {
    ServoCommand command;
    command.order.id = motion.id;
    core_.servo.reset();
    Quiet();
    return RefuseServo(command, may.error());
  }
  servo.moving = true;
  Command(servo.command, true);
}

void Decision::StopServo(const std::string& why) {
  const Servo servo = *std::exchange(core_.servo, std::nullopt);
  if (core_.job && core_.job->for_servo) core_.job->for_servo = false;  // it still stands up
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
  actions_.emplace_back(motion_action::TellServo{
      PresentMotion(rules_, core_), core_.servo_commands,
      core_.body ? core_.body->bar : std::int8_t{-1},
      core_.body ? core_.body->switch_status : std::int8_t{-1}, why.empty(), kCodeOk});
}

void Decision::WatchServo() {
  if (!core_.servo || now_ - core_.servo->last_frame < kServoWatchdog) return;
  StopServo("no frame for 200 ms");
}

// Who streams is told all the time what the board makes of it.
void Decision::ReportServo() {
  if (!core_.servo || now_ < core_.servo->next_report) return;
  core_.servo->next_report = now_ + kBoardPeriod;
  motion_action::TellServo tell;
  tell.cmd_id = core_.servo_commands;
  if (core_.BoardSilent()) {
    tell.code = MotionCode(Key::kBoardSilent);
  } else {
    tell.motion_id = PresentMotion(rules_, core_);
    tell.bar = core_.body->bar;
    tell.status = core_.body->switch_status;
    tell.code = CodeOfStatus(core_.body->switch_status);
    tell.result = tell.code == kCodeOk;
  }
  if (!tell.result) {
    Log(tell.code, "servo motion " + std::to_string(core_.servo->command.id) + ": " +
                       MotionCodeText(tell.code));
  }
  actions_.emplace_back(tell);
}

void Decision::RefuseServo(const ServoCommand& command, const Error& error) {
  Log(error.code, "servo motion " + std::to_string(command.order.id) + " of " +
                      SourceName(command.source) + " is refused: " + error.message);
  actions_.emplace_back(motion_action::TellServo{
      command.order.id, core_.servo_commands, 0,
      core_.body ? core_.body->switch_status : std::int8_t{-1}, false, error.code});
}

}  // namespace musher::motion
