#include "musher/test/modules/motion/motion_fault_test.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace musher::motion::testing {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool Walks(const BodyCommand& command) {
  const bool still = command.vel == std::array<float, 3>{};
  return TheTable().Find(command.id)->limit && !still;
}

}  // namespace

MotionFaultTest::MotionFaultTest(Draw draw) : draw_(std::move(draw)) {
  harness_.watch = [this](const auto& before, const auto& event, const auto& actions) {
    Watch(before, event, actions);
  };
}

std::optional<std::string> MotionFaultTest::Run(int steps) {
  for (int i = 0; i < steps && !violation_; ++i) Inject();
  // At the end the board works again and all requests must be completed.
  harness_.board.deaf = harness_.board.silent = harness_.board.ban = harness_.board.stuck = false;
  harness_.board.fault = 0;
  const auto over = [this] {
    return harness_.core.Idle() && harness_.answers.size() == harness_.requests_made();
  };
  for (int i = 0; i < 1500 && !over(); ++i) harness_.RunFor(std::chrono::seconds(1));
  if (harness_.answers.size() != harness_.requests_made()) Violate("every request is answered");
  if (!harness_.core.Idle()) Violate("every motion ends");
  return violation_;
}

void MotionFaultTest::Inject() {
  switch (draw_(8)) {
    case 0:
    case 1:
      return ServoFrame();
    case 2:
      return Command();
    case 3:
      return ChangeState();
    case 4:
      return ChangeBoard();
    case 5:
      return harness_.StandStill(Milliseconds(Any({10, 49, 50, 300, 700})));
    default:
      return harness_.RunFor(Milliseconds(Any({1, 10, 15, 50, 100, 199, 200, 500, 3000, 20'000})));
  }
}

void MotionFaultTest::ServoFrame() {
  const std::vector<float> vel = Any<std::vector<float>>({{0.3F, 0.1F, 0.5F},
                                                          {0.3F, 0, 0},
                                                          {},
                                                          {100, -100, 100},
                                                          {kNaN, 0, 0},
                                                          {0, kInfinity, 0},
                                                          {0.3F}});
  harness_.Servo(Any({303, 303, 305, 309, 201, 121, 7777}), Any({-1, 0, 0, 3, 4, -2, 9}), vel,
                 Any({0, 1, 1, 1, 2, 3}));
}

void MotionFaultTest::Command() {
  MotionArguments arguments;
  arguments.duration_ms = Any({0, 0, 0, 1000, -1});
  arguments.vel_des = Any<std::vector<float>>({{}, {0.3F, 0, 0}, {-9, 9, 9}, {kNaN, 0, 0}});
  std::vector<MotionRequest> requests;
  for (std::size_t i = Any<std::size_t>({1, 1, 1, 3, 0}); i > 0; --i) {
    requests.push_back({Any({111, 101, 121, 140, 303, 212, 309, 0, 7777}), arguments});
  }
  harness_.Play(std::move(requests), Any({-2, -1, 0, 0, 4, 9}));
}

void MotionFaultTest::ChangeState() {
  switch (draw_(6)) {
    case 0:
      return harness_.Do(motion_event::Closed{
          State(Any<std::string_view>({kDeActive, kError, kLowPower, kOta, kTearDown}))});
    case 1:
      return harness_.Do(motion_event::Opened{});
    case 2:
      harness_.refused.clear();
      return;
    case 3:
      harness_.refused[Any<std::string>({"walk", "back_flip", "dance", "stand", ""})] = {3013,
                                                                                         "no"};
      return;
    case 4:
      harness_.LieDown(Any({kGetDown, kPassiveGetDown}), Any({1, 3}));
      return;
    default:
      return harness_.Do(motion_event::EmergencyStop{});
  }
}

void MotionFaultTest::ChangeBoard() {
  Board& board = harness_.board;
  switch (draw_(6)) {
    case 0:
      board.deaf = !board.deaf;
      return;
    case 1:
      board.silent = !board.silent;
      return;
    case 2:
      board.stuck = !board.stuck;
      return;
    case 3:
      board.fault = Any<std::int8_t>({0, 0, 2, 3, 4, 13, 99});
      return;
    case 4:
      harness_.Body(Any({0, 101, 111, 121, 201, 303}));
      return;
    default:
      board.ban = !board.ban;
      return;
  }
}

// --- The invariants
// ------------------------------------------------------------------------------

void MotionFaultTest::Watch(const MotionCore& before, const MotionEvent& event,
                            const MotionActions& actions) {
  for (const MotionAction& action : actions) {
    if (const auto* send = std::get_if<motion_action::Send>(&action)) {
      CheckCommand(send->command, event);
    }
  }
  CheckPriority(before, event);
  CheckRest(event);
}

void MotionFaultTest::CheckCommand(const BodyCommand& command, const MotionEvent& event) {
  const bool fresh = std::exchange(last_life_, command.life_count) != command.life_count;
  // A frame of a running walk was taken before; it waited for its turn on the link.
  const bool waited = std::holds_alternative<motion_event::TimePassed>(event);
  const bool goes_on = waited && harness_.core.servo && command.id == last_sent_.id;
  last_sent_ = command;
  if (fresh && !goes_on && !MayBegin(command, event)) {
    Violate("motion " + std::to_string(command.id) + " does not begin where it is forbidden");
  }
  const auto& limit = TheTable().Find(command.id)->limit;
  for (std::size_t i = 0; i < command.vel.size(); ++i) {
    const float speed = command.vel.at(i);
    if (!std::isfinite(speed)) Violate("the board gets finite numbers only");
    if (limit && std::abs(speed) > limit->at(i)) Violate("speeds are within their limits");
  }
}

bool MotionFaultTest::MayBegin(const BodyCommand& command, const MotionEvent& event) const {
  const MotionCore& core = harness_.core;
  const Motion& motion = *TheTable().Find(command.id);
  if (command.id == kEmergencyStop) return true;
  if (command.id == kWalkStand && !Walks(command)) return true;
  if (core.job && core.job->own) return true;  // the body lies down
  const bool breaks_off = std::holds_alternative<motion_event::Closed>(event);
  if (breaks_off && command.id == kRecoveryStand) return true;
  if (core.closed) return false;
  if (core.emergency_stop && command.id != kRecoveryStand) return false;
  if (core.servo && core.servo->moving) return Allows(motion.servo);
  if (!core.job) return false;
  return !core.job->todo.front().requested || Allows(motion.capability);
}

bool MotionFaultTest::Allows(const std::string& capability) const {
  return harness_.refused.count("") == 0 && harness_.refused.count(capability) == 0;
}

void MotionFaultTest::CheckPriority(const MotionCore& before, const MotionEvent& event) {
  const auto* frame = std::get_if<motion_event::ServoArrived>(&event);
  if (frame == nullptr || !before.servo || harness_.core.servo == before.servo) return;
  const Priorities& priorities = harness_.config.priorities;
  const auto priority = priorities.find(frame->command.source);
  if (priority == priorities.end() || priority->second > priorities.at(before.servo->source)) {
    Violate("only a source with priority moves the body");
  }
}

void MotionFaultTest::CheckRest(const MotionEvent& event) {
  const MotionCore& core = harness_.core;
  const bool time_passed = std::holds_alternative<motion_event::TimePassed>(event);
  const bool is_due = time_passed && !core.second_look;
  if (is_due && core.servo && harness_.now - core.servo->last_frame >= kServoWatchdog) {
    Violate("a walk is stopped 200 ms after its last frame");
  }
  // In these states the body lies down next, and need not stand still before.
  const bool passes = core.closed && (*core.closed == kTearDown || *core.closed == kOta);
  // A body that lies by its own report is not commanded to stand either.
  constexpr std::int8_t kDamping = 7;
  const auto status = core.body ? SwitchStatus(core.body->switch_status) : SwitchStatus::kNormal;
  const bool stopped = status == SwitchStatus::kEstop || status == SwitchStatus::kEdamp;
  const bool lies = core.body && (core.body->mode == kDamping || core.body->mode == 0 || stopped);
  if (passes || lies || std::holds_alternative<motion_event::LieDown>(event)) left_ = last_life_;
  if (core.Idle() && Walks(last_sent_) && left_ != last_life_) Violate("nothing walks unwatched");
}

void MotionFaultTest::Violate(const std::string& invariant) {
  if (!violation_) violation_ = invariant;
}

}  // namespace musher::motion::testing
