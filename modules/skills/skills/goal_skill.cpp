#include "musher/modules/skills/skills/goal_skill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "musher/navigation/place_text.hpp"

namespace musher::skills {

using skill::Next;
using skill::Tick;
using Kind = TravelStep::Kind;

namespace {

constexpr std::string_view kRecovered = "recoveries_done";  // data, of this goal

constexpr double kPathAheadM = 1.2;  // of it that has to be free of who walks

constexpr double kAheadRad = 1;
constexpr double kBesideRad = 1.4;  // a body that backs up leaves what is not farther round

// What the scan sees nearest.
enum class Nearest : std::uint8_t { kNothing, kAhead, kElsewhere };

// `ahead_rad`: to either side.
Nearest NearestWithin(const Robot& robot, double within_m, double ahead_rad) {
  const auto pose = robot.pose();
  if (!pose) return Nearest::kElsewhere;
  double nearest_m = within_m;
  Nearest nearest = Nearest::kNothing;
  for (const navigation::Point& point : SeenAround(robot, *pose, within_m)) {
    const double away_m = std::hypot(point.x_m, point.y_m);
    if (away_m >= nearest_m) continue;
    nearest_m = away_m;
    const bool ahead = std::abs(std::atan2(point.y_m, point.x_m)) < ahead_rad;
    nearest = ahead ? Nearest::kAhead : Nearest::kElsewhere;
  }
  return nearest;
}

}  // namespace

void GoalSkill::Declare(skill::Table& table) {
  constexpr Duration kPlanning = std::chrono::seconds(15);
  constexpr Duration kMoving = std::chrono::seconds(120);
  initializing_ = table.State("INITIALIZING");
  planning_ = table.State("PLANNING", kPlanning);
  recovering_ = table.State("RECOVERING", std::chrono::seconds(30));
  executing_ = table.State("EXECUTING", kMoving);
  giving_way_ = table.State("GIVING_WAY", kMoving);
  stopping_ = table.State("STOPPING");
  table.To(initializing_, planning_, "planner and controller are reachable");
  table.To(planning_, executing_, "the path is planned");
  table.To(planning_, initializing_, "the planner is lost, or has no map");
  table.To(planning_, recovering_, "no room to start, or no path");
  table.To(recovering_, planning_, "the recovery has ended");
  table.To(recovering_, executing_, "who was in the way has got room");
  table.To(executing_, skill::kSucceeded, "at the goal");
  table.To(executing_, planning_, "an obstacle, a pause, another goal");
  table.To(executing_, recovering_, "an obstacle stays");
  table.To(executing_, initializing_, "the controller is lost");
  table.To(executing_, giving_way_, "another robot goes first");
  table.To(giving_way_, planning_, "the way is free");
  for (const skill::StateId state :
       {initializing_, planning_, recovering_, executing_, giving_way_}) {
    table.To(state, skill::kFailed, "failed");
    table.To(state, stopping_, "cancel");
  }
  table.To(stopping_, skill::kCancelled, "the robot stands");
  table.MonotoneProgress();
  table.Takes("recoveries", "leave_tight_start, clear, wait, back_up, spin",
              "what it does, one after the other, where it has no room to start or no path");
  table.Takes("at_obstacle", "back_up",
              "of recoveries, what it does in turn at an obstacle that stays");
  table.Takes("blocked_after", ToSeconds(kBlockedRecovery),
              "s at a stand there before the first of at_obstacle");
  table.Takes("blocked_again", ToSeconds(kBlockedAgain), "s from one of at_obstacle to the next");
  table.Takes("blocked_limit", ToSeconds(kBlockedLimit),
              "s at a stand there without coming nearer to the goal, then it fails");
  DeclareLostLimit(table);
  Describe(table);
}

Result<> GoalSkill::TakeRecoveries(const skill::Values& parameters) {
  for (const auto& [name, kinds] :
       {std::pair("recoveries", &recoveries_), std::pair("at_obstacle", &at_obstacle_)}) {
    const auto parsed = Recovery::Parse(name, parameters.Text(name));
    if (!parsed) return parsed.error();
    *kinds = parsed.value();
  }
  for (const auto& [name, time] :
       {std::pair("blocked_after", &blocked_after_), std::pair("blocked_again", &blocked_again_),
        std::pair("blocked_limit", &blocked_limit_)}) {
    constexpr double kMostS = 1e6;
    const double seconds = parameters.Number(name);
    if (!(seconds >= 0 && seconds <= kMostS)) {
      return Error{kCodeParametersInvalid,
                   fmt::format("{} is {:g}; expected 0 to 1000000 seconds", name, seconds)};
    }
    *time = FromSeconds(seconds);
  }
  return Ok();
}

Next GoalSkill::Step(Tick& tick) {
  if (tick.state == stopping_) return Stop(tick);
  if (const Result<> may = CheckAfterPause(); !may) return Next::Fail(may.error().message);
  movers_.Note(robot_, tick.step);
  if (!taken_) {
    const Result<> taken = Take(tick);
    if (!taken) return Next::Fail(taken.error().message);
    const Result<> recoveries = TakeRecoveries(tick.parameters);
    if (!recoveries) return Next::Fail(recoveries.error().message);
    const Result<> limit = CheckLostLimit(tick.parameters);
    if (!limit) return Next::Fail(limit.error().message);
    taken_ = true;
  }
  if (tick.state == initializing_) return Initialize(tick);
  if (tick.state == recovering_) {
    const bool stands = recovers_by_ == RecoveryKind::kWait || recovers_by_ == RecoveryKind::kClear;
    if (stands && trouble_ == Trouble::kBlocked) NoteBlockedTime(tick);
    return Recover(tick);
  }
  if (tick.state == giving_way_) return LetPass(tick);
  NoteBlockedTime(tick);
  return tick.state == planning_ ? Plan(tick) : Execute(tick);
}

Next GoalSkill::Initialize(Tick& tick) {
  if (const auto waits = WaitForParts(tick, 5, Prefix(tick), "Sending request...")) return *waits;
  const Result<> flies = CheckInTheAir(robot_, robot_.pose()->at.z_m);
  return flies ? Next::To(planning_) : Next::Fail(flies.error().message);
}

Next GoalSkill::Plan(Tick& tick) {
  tick.Report(tick.entered ? 15 : 30, Prefix(tick) + "Planning path...");
  const TravelStep step = travel_.Plan(Goal(tick), started_ ? std::nullopt : Start(), tick.step);
  if (step.trouble) return AfterTrouble(tick, *step.trouble, Prefix(tick) + step.why);
  if (step.kind != Kind::kDone) return Decide(tick, step);
  const auto pose = robot_.pose();
  if (!started_ && pose) {  // its first drive, also in another process
    const Result<> flies = CheckInTheAir(robot_, pose->at.z_m);
    if (!flies) return Next::Fail(flies.error().message);
  }
  started_ = true;
  travel_.Begin(travel_.planned());
  return Next::To(executing_);
}

Next GoalSkill::AfterTrouble(Tick& tick, Trouble trouble, const std::string& why) {
  auto next = static_cast<std::size_t>(tick.data.Get<std::int64_t>(kRecovered, 0));
  while (next < recoveries_.size() &&
         !Recovery::Helps(recoveries_[next], trouble, robot_.flies())) {
    ++next;
  }
  if (next >= recoveries_.size()) return Next::Fail(why);
  tick.data.Set(kRecovered, static_cast<std::int64_t>(next + 1));
  return BeginRecovery(recoveries_[next], trouble, why);
}

Next GoalSkill::BeginRecovery(RecoveryKind kind, Trouble trouble, const std::string& why) {
  trouble_ = trouble;
  recovers_by_ = kind;
  recovery_.Begin(kind);
  return Next::To(recovering_, why);
}

Next GoalSkill::Recover(Tick& tick) {
  if (!recovers_by_) return Next::To(planning_);
  const std::string name = Recovery::NameOf(*recovers_by_);
  const char* what = trouble_ == Trouble::kTightStart ? "No room to start: "
                     : trouble_ == Trouble::kNoPath   ? "No path: "
                                                      : "Blocked: ";
  tick.Report(15, Prefix(tick) + what + name);
  auto end = recovery_.Step(tick.step);
  if (!end && trouble_ == Trouble::kMover && !IsFaceToFace()) {
    robot_.StopMotion();
    end = Result<>();
  }
  if (!end) return Next::Stay();
  recovers_by_.reset();
  if (trouble_ == Trouble::kMover && *end) {
    travel_.BeginRest();
    return Next::To(executing_, name + " has ended");
  }
  return Next::To(planning_, *end ? name + " has ended" : name + ": " + end->error().message);
}

// A flyer plans around it: the rest of a path that climbs cannot be joined by a straight line on a
// level, and the scan sees other things at each height.
bool GoalSkill::IsMoverInTheWay() const {
  if (robot_.flies()) return false;
  constexpr double kOfRobotM = 0.3;
  std::vector<navigation::Point> in_the_way = travel_.InTheWay(kPathAheadM);
  for (const navigation::RobotIntent& other : robot_.others()) {
    std::erase_if(in_the_way, [&](const navigation::Point& point) {
      return travel_.Apart(point, other.at) < other.radius_m + kOfRobotM;
    });
  }
  return movers_.HaveCome(robot_, in_the_way);
}

bool GoalSkill::IsFaceToFace() const {
  constexpr double kFaceToFaceM = 0.3;
  const double near_m = robot_.radius_m() + kFaceToFaceM;
  return NearestWithin(robot_, near_m, kBesideRad) == Nearest::kAhead;
}

Next GoalSkill::LetMoverPass(const std::string& why) {
  const RecoveryKind back_up = RecoveryKind::kBackUp;
  const bool listed = std::ranges::find(recoveries_, back_up) != recoveries_.end();
  if (listed && Recovery::Helps(back_up, Trouble::kMover, robot_.flies()) && IsFaceToFace()) {
    return BeginRecovery(back_up, Trouble::kMover, why);
  }
  travel_.BeginRest();
  return Next::Stay();
}

Next GoalSkill::Execute(Tick& tick) {
  if (!travel_.driving()) return Next::Replan(planning_, "continues after a pause");
  const TravelStep step = travel_.Drive(tick.step);
  if (step.kind == Kind::kDone) {
    blocked_.reset();
    tick.data.Set(kRecovered, std::int64_t{0});
    const auto message = OnArrival(tick);
    return message ? Next::Succeed(*message) : Next::To(planning_);
  }
  if (step.kind != Kind::kPending) return Decide(tick, step);
  if (give_way_.Needed()) {
    give_way_.Begin();
    return Next::To(giving_way_, Prefix(tick) + "Gives way to " + give_way_.to());
  }
  NoteDriving(tick);
  const double length_m = std::max(travel_.length_m(), 0.1);
  const double share = std::clamp(1 - travel_.distance_to_goal_m() / length_m, 0.0, 1.0);
  tick.Report(50 + 45 * Share(tick, share),
              Prefix(tick) + fmt::format("Moving... ({:.1f}s)", ToSeconds(tick.elapsed)));
  travel_.AddDetails(tick);
  return Next::Stay();
}

Next GoalSkill::LetPass(Tick& tick) {
  const bool restored = give_way_.to().empty();
  if (!restored && !give_way_.Step(tick.step)) {
    tick.Report(50, Prefix(tick) + "Gives way to " + give_way_.to() + ": " + give_way_.Doing());
    return Next::Stay();
  }
  give_way_.Restart();
  return Next::Replan(planning_, Prefix(tick) + "The way is free");
}

Next GoalSkill::Decide(Tick& tick, const TravelStep& step) {
  const std::string why = Prefix(tick) + step.why;
  switch (step.kind) {
    case Kind::kBlocked:
      return AfterBlocked(tick, step);
    case Kind::kLost:
      // Also a server that rejects: it does until it is Active, for example after a restart.
      return AfterLoss(tick, Prefix(tick), step.why);
    case Kind::kFailed:
      return Next::Fail(why);
    case Kind::kPending:
    case Kind::kDone:
      break;
  }
  return Next::Stay();
}

void GoalSkill::NoteBlockedTime(const Tick& tick) {
  const auto pose = robot_.pose();
  if (!blocked_ || !pose) return;
  constexpr double kNearerM = 0.5;
  const double left_m = travel_.Apart(pose->at, Goal(tick).at);
  if (left_m < blocked_->nearest_m - kNearerM) *blocked_ = {.nearest_m = left_m};
  blocked_->standstill.Note(pose, tick.step);
  if (blocked_->standstill.time() > Duration{}) blocked_->stood += tick.step;
}

std::optional<RecoveryKind> GoalSkill::DueRecovery() const {
  if (blocked_->stood < blocked_after_ + blocked_again_ * blocked_->recoveries) {
    return std::nullopt;
  }
  // It does not back up into what is nearest.
  constexpr double kNearM = 1;
  const bool free = NearestWithin(robot_, kNearM, kAheadRad) != Nearest::kElsewhere;
  for (std::size_t i = 0; i < at_obstacle_.size(); ++i) {
    const auto next = static_cast<std::size_t>(blocked_->recoveries) + i;
    const RecoveryKind kind = at_obstacle_[next % at_obstacle_.size()];
    const bool listed = std::ranges::find(recoveries_, kind) != recoveries_.end();
    const bool helps = listed && Recovery::Helps(kind, Trouble::kBlocked, robot_.flies());
    if (helps && (free || kind != RecoveryKind::kBackUp)) return kind;
  }
  return std::nullopt;
}

Next GoalSkill::AfterBlocked(const Tick& tick, const TravelStep& step) {
  const auto at = robot_.pose().value_or(navigation::Pose()).at;
  const double left_m = travel_.Apart(at, Goal(tick).at);
  if (!blocked_) blocked_ = Blocked{.nearest_m = left_m};
  if (blocked_->stood < blocked_limit_) {
    const std::string why = Prefix(tick) + step.why;
    if (blocked_->stood < kLetPass && IsMoverInTheWay()) return LetMoverPass(why);
    const auto due = DueRecovery();
    if (!due) return Next::Replan(planning_, why);
    ++blocked_->recoveries;
    return BeginRecovery(*due, Trouble::kBlocked, why);
  }
  return Next::Fail(Prefix(tick) +
                    fmt::format("Blocked for {:.0f} s, {} m from the goal, at {}: {}",
                                ToSeconds(blocked_->stood), LengthText(left_m),
                                navigation::PlaceText(at, true), step.why) +
                    GiveWay::NearRobotText(robot_));
}

Next GoalSkill::OnLimit(Tick& tick) {
  if (tick.state == initializing_) return Next::Fail(WhyLost(tick));
  if (tick.state == recovering_) return Next::To(planning_);
  if (tick.state == planning_) return Next::Fail(Prefix(tick) + "Planning timeout");
  if (tick.state == giving_way_) {
    return Next::Fail(Prefix(tick) +
                      fmt::format("Gave way to {} for {:.0f} s: it has not left the way",
                                  give_way_.to(), ToSeconds(tick.elapsed)));
  }
  return Next::Fail(Prefix(tick) + "Navigate timeout");
}

}  // namespace musher::skills
