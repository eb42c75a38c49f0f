#include "musher/modules/meilin/servers/suspension.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "musher/modules/meilin/servers/goal_limit.hpp"

namespace musher::meilin::servers {
namespace {

constexpr std::size_t kDownAhead = 0;
constexpr std::size_t kAhead = 1;
constexpr std::size_t kDownBehind = 3;

constexpr double kRiserAheadMm = 200;  // a nearer one is a step that is still higher than the body
constexpr double kOverStepMm = 80;     // the body is over the step
constexpr double kClearMm = 200;       // the body is clear of the edge
constexpr double kHighDropMm = 380;    // a deeper one is a high step

std::string Silent(const std::optional<Time>& at, Time now, Duration stale) {
  if (!at) return "no reading yet";
  if (now - *at <= stale) return "";
  return fmt::format("no reading for {:.1f} s", ToSeconds(now - *at));
}

}  // namespace

const char* SuspensionStateName(SuspensionState state) {
  switch (state) {
    case SuspensionState::kIdle:
      return "IDLE";
    case SuspensionState::kUpPrepare:
      return "UP_1_PREPARE";
    case SuspensionState::kUpLift:
      return "UP_2_LIFT";
    case SuspensionState::kUpFrontDock:
      return "UP_3_FRONT_DOCK";
    case SuspensionState::kUpRetractFront:
      return "UP_4_RETRACT_FRONT";
    case SuspensionState::kUpFrontLand:
      return "UP_5_FRONT_LAND";
    case SuspensionState::kUpRearDock:
      return "UP_6_SIDE_DOCK_RETRACT_REAR";
    case SuspensionState::kUpRearLand:
      return "UP_7_REAR_LAND";
    case SuspensionState::kUpRecover:
      return "UP_8_RECOVER";
    case SuspensionState::kDownPrepare:
      return "DOWN_1_PREPARE";
    case SuspensionState::kDownRearLand:
      return "DOWN_2_FRONT_HOVER_LAND";
    case SuspensionState::kDownClear:
      return "DOWN_3_REAR_HOVER_LAND";
    case SuspensionState::kDownRecover:
      return "DOWN_4_RECOVERY";
  }
  return "unknown";
}

Suspension::Suspension(const SuspensionSettings& settings) : settings_(settings) {}

void Suspension::OnChassis(const std::array<bool, kWheels>& switches, const WheelHeights& heights,
                           Time now) {
  if (!std::all_of(heights.begin(), heights.end(), [](double mm) { return std::isfinite(mm); })) {
    return;
  }
  switches_ = switches;
  heights_ = heights;
  chassis_at_ = now;
  for (std::size_t i = 0; i < kWheels; ++i) switch_filters_[i].OnReading(switches[i]);
}

void Suspension::OnDistances(const std::array<double, kDistances>& mm, Time now) {
  distances_ = mm;
  distances_at_ = now;
  for (std::size_t i = 0; i < kDistances; ++i) distance_filters_[i].OnReading(mm[i]);
}

void Suspension::Forget() {
  chassis_at_.reset();
  distances_at_.reset();
  for (DistanceFilter& filter : distance_filters_) filter.Clear();
  for (SwitchFilter& filter : switch_filters_) filter.Clear();
}

std::string Suspension::SilentChassis(Time now) const {
  return Silent(chassis_at_, now, settings_.stale);
}

std::string Suspension::SilentDistances(Time now) const {
  return Silent(distances_at_, now, settings_.stale);
}

double Suspension::HighFor(double step_mm) const {
  return step_mm <= settings_.low_step_mm ? settings_.low_mm : settings_.high_mm;
}

std::string Suspension::WhyImpossible(const SuspensionGoal& goal) const {
  const double mm = goal.height_mm;
  if (goal.mode == SuspensionMode::kAuto && mm == 0) {
    return "AUTO needs a height: above 0 it climbs up, below 0 down";
  }
  if (goal.mode != SuspensionMode::kAuto && mm < 0) {
    return fmt::format("a height of {:.0f} mm is negative", mm);
  }
  const bool direct = goal.mode == SuspensionMode::kDirect;
  if (direct && mm > settings_.highest_mm + settings_.tolerance_mm) {
    return fmt::format("no wheel reaches {:.0f} mm, at most {:.0f} mm", mm, settings_.highest_mm);
  }
  if (!direct && std::abs(mm) > settings_.highest_step_mm) {
    return fmt::format("a step of {:.0f} mm is too high, at most {:.0f} mm", std::abs(mm),
                       settings_.highest_step_mm);
  }
  return "";
}

std::string Suspension::Begin(const SuspensionGoal& goal, Time now) {
  std::string why = WhyImpossible(goal);
  if (!why.empty()) return why;
  if (why = SilentChassis(now); !why.empty()) return "the wheels do not report: " + why;
  const bool direct = goal.mode == SuspensionMode::kDirect;
  if (!direct && !SilentDistances(now).empty()) {
    return "the distance sensors do not report: " + SilentDistances(now);
  }
  begun_ = now;
  limit_ = LimitOf(goal.limit_s, settings_.time_limit);
  view_ = ViewOf(goal.direction);
  step_mm_ = std::abs(goal.height_mm);
  run_ = direct ? Run::kDirect : Run::kClimb;
  if (direct) {
    Enter(SuspensionState::kIdle);
    SetAll(goal.height_mm);
    return "";
  }
  const bool up = goal.mode == SuspensionMode::kClimbUp ||
                  (goal.mode == SuspensionMode::kAuto && goal.height_mm > 0);
  high_mm_ = HighFor(step_mm_);
  Enter(up ? SuspensionState::kUpPrepare : SuspensionState::kDownPrepare);
  // A body that is lifted would take the ground below it for an edge.
  SetAll(up ? high_mm_ : settings_.rest_mm);
  return "";
}

void Suspension::Stop() {
  if (run_ == Run::kNone) return;
  run_ = Run::kNone;
  targets_ = heights_;
  for (double& mm : *targets_) mm = std::clamp(mm, 0.0, settings_.highest_mm);
}

std::optional<Suspension::End> Suspension::Fail(const std::string& why) {
  Stop();
  return End{false, why};
}

std::optional<Suspension::End> Suspension::Update(Time now) {
  if (run_ == Run::kNone) return std::nullopt;
  const std::string silent = SilentChassis(now);
  if (!silent.empty()) return Fail("Wheel feedback lost: " + silent);
  if (run_ == Run::kClimb && !SilentDistances(now).empty()) {
    return Fail("Distance feedback lost: " + SilentDistances(now));
  }
  const bool direct = run_ == Run::kDirect;
  if (direct ? For(2, AllReached()) : Tick()) {
    run_ = Run::kNone;
    state_ = SuspensionState::kIdle;
    return End{true, direct ? "Direct height set" : "Sequence complete"};
  }
  if (now - begun_ >= limit_) return Fail("Timeout");
  return std::nullopt;
}

double Suspension::ElapsedSeconds(Time now) const {
  return std::max(0.0, ToSeconds(now - begun_));
}

void Suspension::Enter(SuspensionState state) {
  state_ = state;
  moving_ = false;
  ticks_ = other_ticks_ = 0;
}

void Suspension::SetFront(double mm) {
  if (!targets_) targets_ = heights_;
  const double reachable = std::min(mm, settings_.highest_mm);
  for (const std::size_t i : {view_.corners[0], view_.corners[1]}) (*targets_)[i] = reachable;
}

void Suspension::SetRear(double mm) {
  if (!targets_) targets_ = heights_;
  const double reachable = std::min(mm, settings_.highest_mm);
  for (const std::size_t i : {view_.corners[2], view_.corners[3]}) (*targets_)[i] = reachable;
}

void Suspension::SetAll(double mm) {
  SetFront(mm);
  SetRear(mm);
}

bool Suspension::Reached(std::size_t first, std::size_t last, double mm) const {
  for (std::size_t i = first; i <= last; ++i) {
    if (std::abs(heights_[view_.corners[i]] - mm) > settings_.tolerance_mm) return false;
  }
  return true;
}

bool Suspension::FrontReached() const {
  return Reached(0, 1, (*targets_)[view_.corners[0]]);
}

bool Suspension::RearReached() const {
  return Reached(2, 3, (*targets_)[view_.corners[2]]);
}

std::optional<bool> Suspension::Switch(std::size_t corner) const {
  return switch_filters_[view_.corners[corner]].on();
}

bool Suspension::BothSwitches(bool front, bool on) const {
  const std::size_t first = front ? 0 : 2;
  return Switch(first) == on && Switch(first + 1) == on;
}

std::optional<double> Suspension::Distance(std::size_t which) const {
  return distance_filters_[view_.distances[which]].mm();
}

bool Suspension::For(int ticks, bool holds) {
  ticks_ = holds ? ticks_ + 1 : 0;
  return ticks_ >= ticks;
}

bool Suspension::Tick() {
  return state_ < SuspensionState::kDownPrepare ? TickUp() : TickDown();
}

bool Suspension::TickUp() {
  switch (state_) {
    case SuspensionState::kUpPrepare:
      if (For(2, AllReached())) {
        Enter(step_mm_ > 0 ? SuspensionState::kUpFrontDock : SuspensionState::kUpLift);
      }
      return false;
    case SuspensionState::kUpLift:
      return TickLift();
    case SuspensionState::kUpFrontDock: {
      const auto below = Distance(kDownAhead);
      if (!For(5, below && *below < kOverStepMm)) return false;
      Enter(SuspensionState::kUpRetractFront);
      SetFront(5);
      return false;
    }
    case SuspensionState::kUpRetractFront:
      if (FrontReached()) Enter(SuspensionState::kUpFrontLand);
      return false;
    case SuspensionState::kUpFrontLand:
      return TickFrontLand();
    case SuspensionState::kUpRearDock:
      return TickRearDock();
    case SuspensionState::kUpRearLand:
      return TickRearLand();
    default:
      return AllReached();
  }
}

// At the low height a riser ahead means a step that needs the high one.
bool Suspension::TickLift() {
  if (moving_) {
    if (AllReached()) Enter(SuspensionState::kUpFrontDock);
    return false;
  }
  const auto ahead = Distance(kAhead);
  const bool riser = ahead && *ahead < kRiserAheadMm;
  const bool free = ahead && !riser;
  other_ticks_ = free ? other_ticks_ + 1 : 0;
  if (For(18, riser)) {
    moving_ = true;
    high_mm_ = settings_.high_mm;
    SetAll(high_mm_);
  } else if (other_ticks_ >= 5) {
    Enter(SuspensionState::kUpFrontDock);
  }
  return false;
}

bool Suspension::TickFrontLand() {
  if (!For(5, BothSwitches(true, true)) && !moving_) return false;
  if (!moving_) {
    moving_ = true;
    SetFront(7);
    SetRear(high_mm_ + 3);
  }
  if (ticks_ >= 5 && AllReached()) Enter(SuspensionState::kUpRearDock);
  return false;
}

// The first rear switch over the step: the rear wheels are about to touch it.
bool Suspension::TickRearDock() {
  const bool over = For(20, Switch(2) == true || Switch(3) == true);
  if (over && !moving_) {
    moving_ = true;
    SetRear(0);
  }
  if (moving_ && RearReached()) Enter(SuspensionState::kUpRearLand);
  return false;
}

bool Suspension::TickRearLand() {
  if (!For(5, BothSwitches(false, true)) && !moving_) return false;
  moving_ = true;
  SetRear(3);
  if (!RearReached()) return false;
  Enter(SuspensionState::kUpRecover);
  SetAll(settings_.rest_mm);
  return false;
}

bool Suspension::TickDown() {
  switch (state_) {
    case SuspensionState::kDownPrepare:
      return TickDownFront();
    case SuspensionState::kDownRearLand:
      return TickDownRear();
    case SuspensionState::kDownClear: {
      const auto below = Distance(kDownBehind);
      if (!For(5, below && *below > kClearMm)) return false;
      Enter(SuspensionState::kDownRecover);
      SetAll(settings_.rest_mm);
      return false;
    }
    default:
      return AllReached();
  }
}

bool Suspension::TickDownFront() {
  if (!moving_) {
    const auto below = Distance(kDownAhead);
    const bool over = AllReached() && BothSwitches(true, false);
    // Of an unknown height, until the mean has no reading of the time before the edge.
    const bool known = step_mm_ > 0;
    if (!For(known ? 2 : 8, over && (known || below))) return false;
    if (!known) high_mm_ = *below > kHighDropMm ? settings_.high_mm : settings_.low_mm;
    moving_ = true;
    SetFront(high_mm_ + 30);
  }
  if (Reached(0, 1, high_mm_ + 10)) Enter(SuspensionState::kDownRearLand);
  return false;
}

bool Suspension::TickDownRear() {
  if (!moving_) {
    if (!For(2, BothSwitches(false, false))) return false;
    moving_ = true;
    SetRear(high_mm_ + 10);
  }
  if (Reached(2, 3, high_mm_)) Enter(SuspensionState::kDownClear);
  return false;
}

}  // namespace musher::meilin::servers
