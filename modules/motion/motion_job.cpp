#include <iterator>
#include <utility>

#include "musher/modules/motion/motion_decision.hpp"

namespace musher::motion {
namespace {

using Key = MotionKey;

// Short motions such as flips and jumps run to their end: that is safer than an interruption.
constexpr Duration kShortMotion = Milliseconds(8000);

bool IsTransitioning(const BodyReport& body) {
  return body.switch_status == static_cast<std::int8_t>(SwitchStatus::kTransitioning);
}

}  // namespace

void Decision::BeginEmergencyStop(RequestToken token) {
  const std::int32_t code = MotionCode(Key::kEstop);
  if (core_.job) DropJob(code, "interrupted by emergency stop");
  if (core_.servo) {
    core_.servo.reset();
    actions_.emplace_back(
        motion_action::ServoResponse{kNoMotion, core_.servo_commands, 0, 0, false, code});
  }
  if (!std::exchange(core_.emergency_stop, true)) {
    actions_.emplace_back(motion_action::Log{"emergency stop"});
    ReportEmergencyStop();
  }
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
    } else {
      BeginMotion();
    }
    return true;
  }
  if (job.wait == Job::Wait::kFeedback) {
    if (Taken()) return go_on(Job::Wait::kSettle, kSettleTime);
    return over && fail(CodeOfRefusal());
  }
  if (job.wait == Job::Wait::kSettle) {
    return over && go_on(Job::Wait::kTransition, kTransitionTime);
  }
  const BodyCommand& command = job.todo.front().command;
  const std::int32_t code = CodeOfStatus(core_.body->switch_status);
  if (code != kCodeOk && command.id != kEmergencyStop) return fail(code);
  if (job.wait == Job::Wait::kTransition) {
    if (!IsTransitioning(*core_.body)) {
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
  job.todo.erase(job.todo.begin(), std::prev(job.todo.end()));
  job.todo.front().prepared = false;
  job.wait = Job::Wait::kRetry;
  job.wait_end = now_ + kLieDownPause;
  Quiet();
}

void Decision::EndJob(std::int32_t code, const std::string& message) {
  const Job job = *std::exchange(core_.job, std::nullopt);
  const BodyCommand& last = job.todo.front().command;
  const Motion& motion = *rules_.table.Find(last.id);
  if (last.id == kEmergencyStop && !Taken()) {
    core_.link.until = Time::max();  // repeated until the board takes it
  } else if (motion.limit) {
    Stand(last);  // no walk continues after its command has ended
  } else {
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
  Quiet();
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
  if (present->id == kEmergencyStop) return true;
  return present->id == kGetDown && core_.body->bar > kDoneBar;
}

}  // namespace musher::motion
