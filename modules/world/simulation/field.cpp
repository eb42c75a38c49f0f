#include "musher/modules/world/simulation/field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr double kBoxAsideM = 0.25;  // of a box from the line ahead that the arm reaches
constexpr double kArmMm = 10;        // of the arm over the underside at rest, less the rest height
constexpr Duration kRepetition = Milliseconds(200);
constexpr std::size_t kMostWaySamples = 20'000;
constexpr std::size_t kMostFieldEvents = 1000;

// The box whose square contains the point and that is higher.
std::optional<std::string> BoxAt(const FieldSpec& field, const std::vector<KfsBox>& boxes,
                                 const Vector2d& point_m, double height_mm) {
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].where != KfsBox::Where::kField) continue;
    const KfsSpec& spec = field.boxes[i];
    const Vector2d apart = (point_m - field.CentreOf(spec.cell)).cwiseAbs();
    if (apart.maxCoeff() > kKfsSizeM / 2) continue;
    if (height_mm < field.HeightMm(spec.cell) + kKfsSizeM * 1000) return "the box " + spec.name;
  }
  return std::nullopt;
}

}  // namespace

const char* NameOf(KfsBox::Where where) {
  constexpr std::array<const char*, 5> kNames{"field", "gripper", "body", "mid", "high"};
  return kNames.at(static_cast<std::size_t>(where));
}

Field::Field(FieldSpec spec) : spec_(std::move(spec)), robot_(spec_), boxes_(spec_.boxes.size()) {
  stands_mm_ = spec_.HeightMm(robot_.position_m());
  Record(Duration::zero());
}

std::optional<std::string> Field::Command(Tool& tool, const char* name, double command, double most,
                                          Duration now) const {
  if (!(command >= 0 && command <= most) || command != std::floor(command)) {
    return std::string(name) + ": the command " + NumberText(command) +
           " is refused: expected a whole number from 0 to " + NumberText(most);
  }
  const int number = static_cast<int>(command);
  const bool ended_now = tool.until > Duration::zero() && now - tool.until < kRepetition;
  if (number == tool.command && (tool.busy || ended_now)) return std::nullopt;
  const bool arm = &tool == &arm_;
  const auto index = static_cast<std::size_t>(number);
  tool = {number,
          now + FromSeconds(arm ? spec_.robot.arm_s.at(index) : spec_.robot.spear_s.at(index)),
          true, false, ""};
  return std::nullopt;
}

std::optional<std::string> Field::CommandArm(double command, Duration now) {
  return Command(arm_, "arm", command, static_cast<double>(spec_.robot.arm_s.size() - 1), now);
}

std::optional<std::string> Field::CommandSpear(double command, Duration now) {
  return Command(spear_, "spear", command, static_cast<double>(spec_.robot.spear_s.size() - 1),
                 now);
}

std::optional<std::string> Field::PutDown(const Vector2d& at_m, double yaw_rad, Duration now) {
  if (const auto refused = robot_.PutDown(spec_, at_m, yaw_rad)) {
    return "the robot cannot be there: " + *refused;
  }
  stands_mm_ = spec_.HeightMm(at_m);
  Record(now);
  return std::nullopt;
}

std::vector<std::string> Field::Step(const std::set<std::string>& faults, Duration now,
                                     Duration dt) {
  std::vector<std::string> log;
  const auto say = [&](const std::optional<std::string>& line) {
    if (line) log.push_back(*line);
  };
  const LiftPlace place{spec_, [this](const Vector2d& point_m, double height_mm) {
                          return BoxAt(spec_, boxes_, point_m, height_mm);
                        }};
  const LiftBody::Stuck stuck{faults.contains("suspension stuck"), faults.contains("base stuck")};
  readings_.clear();
  for (Duration at = now - dt + kFieldStep; at <= now; at += kFieldStep) {
    const int falls = robot_.falls();
    if (const auto line = robot_.Step(place, stuck, at, kFieldStep)) {
      log.push_back(*line + " at " + PointText(robot_.position_m()));
      Note(robot_.falls() > falls ? FieldEvent::Kind::kFall : FieldEvent::Kind::kBump, at, "");
    }
    readings_.push_back({robot_.Switches(spec_), robot_.wheels_mm(), robot_.DistancesMm(spec_)});
  }
  NoteClimb(now);
  if (arm_.busy && now >= arm_.until && !faults.contains("arm stuck")) say(EndArm(now));
  if (spear_.busy && now >= spear_.until && !faults.contains("spear stuck")) say(EndSpear(now));
  if (docked_at_ && !partner_ready_ &&
      now - *docked_at_ >= FromSeconds(spec_.partner.ready_after_s)) {
    partner_ready_ = true;
    Note(FieldEvent::Kind::kReady, now, "R1");
    log.emplace_back("R1 is ready");
  }
  if (way_.empty() || now - way_.back().at >= way_period_) Record(now);
  return log;
}

// Returns a line for the log.
std::optional<std::string> Field::EndArm(Duration now) {
  arm_.busy = false;
  std::optional<std::string> failed;
  switch (static_cast<ArmCommand>(arm_.command)) {
    case ArmCommand::kGrasp:
      failed = Grasp(now);
      break;
    case ArmCommand::kStoreToBody:
      if (const auto box = BoxIn(KfsBox::Where::kGripper);
          box && CountIn(KfsBox::Where::kBody) < spec_.robot.stores) {
        boxes_[*box].where = KfsBox::Where::kBody;
      } else {
        failed = box ? "the body is full" : "the gripper is empty";
      }
      break;
    case ArmCommand::kGetBody:
      if (const auto box = BoxIn(KfsBox::Where::kBody); box && !BoxIn(KfsBox::Where::kGripper)) {
        boxes_[*box].where = KfsBox::Where::kGripper;
      } else {
        failed = box ? "the gripper is full" : "the body is empty";
      }
      break;
    case ArmCommand::kPlaceMid:
      failed = Place(KfsBox::Where::kMid, now);
      break;
    case ArmCommand::kPlaceHigh:
      failed = Place(KfsBox::Where::kHigh, now);
      break;
    case ArmCommand::kStoreOnArm:
      if (!BoxIn(KfsBox::Where::kGripper)) failed = "the gripper is empty";
      break;
    case ArmCommand::kIdle:
      break;
  }
  arm_.done = !failed;
  arm_.result = failed.value_or("");
  if (!failed) return std::nullopt;
  return "arm: command " + std::to_string(arm_.command) + " is not done: " + *failed;
}

// The nearest box ahead. One that the gripper already holds goes into the body first.
std::optional<std::string> Field::Grasp(Duration now) {
  const auto held = BoxIn(KfsBox::Where::kGripper);
  if (held && CountIn(KfsBox::Where::kBody) >= spec_.robot.stores) {
    return "the gripper and the body are full";
  }
  const WheelHeights& wheels = robot_.wheels_mm();
  const double raised_mm =
      (wheels[0] + wheels[1] + wheels[2] + wheels[3]) / 4 - spec_.robot.rest_mm - kArmMm;
  const double arm_mm = spec_.HeightMm(robot_.position_m()) + raised_mm;
  std::string why = "no box is ahead within " + MetresText(spec_.robot.reach_m) + " m";
  std::optional<std::size_t> nearest;
  double nearest_m = spec_.robot.reach_m;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (boxes_[i].where != KfsBox::Where::kField) continue;
    const FieldCell cell = spec_.boxes[i].cell;
    const Vector2d away =
        Rotation2Dd(-robot_.yaw_rad()) * (spec_.CentreOf(cell) - robot_.position_m());
    if (away.x() <= 0 || std::abs(away.y()) > kBoxAsideM || away.norm() > nearest_m) continue;
    if (std::abs(spec_.HeightMm(cell) - arm_mm) > spec_.robot.grasp_tolerance_mm) {
      why = "the box " + spec_.boxes[i].name + " is " +
            NumberText(std::round(spec_.HeightMm(cell) - arm_mm)) + " mm higher than the arm";
      continue;
    }
    nearest = i;
    nearest_m = away.norm();
  }
  if (!nearest) return why;
  if (held) boxes_[*held].where = KfsBox::Where::kBody;
  boxes_[*nearest] = {KfsBox::Where::kGripper, now};
  Note(FieldEvent::Kind::kTaken, now, spec_.boxes[*nearest].name);
  return std::nullopt;
}

std::optional<std::string> Field::Place(KfsBox::Where where, Duration now) {
  const auto held = BoxIn(KfsBox::Where::kGripper);
  const auto box = held ? held : BoxIn(KfsBox::Where::kBody);
  if (!box) return "there is no box to place";
  boxes_[*box].where = where;
  Note(FieldEvent::Kind::kPlaced, now, spec_.boxes[*box].name + " " + NameOf(where));
  return std::nullopt;
}

std::optional<std::string> Field::EndSpear(Duration now) {
  spear_.busy = false;
  spear_.done = true;
  if (static_cast<SpearCommand>(spear_.command) == SpearCommand::kDockExtend && !docked_at_) {
    docked_at_ = now;
    Note(FieldEvent::Kind::kDocked, now, "R1");
    return "the spear is docked with R1";
  }
  if (static_cast<SpearCommand>(spear_.command) == SpearCommand::kDockRelease) {
    docked_at_.reset();
    partner_ready_ = false;
  }
  return std::nullopt;
}

// The one that was taken first.
std::optional<std::size_t> Field::BoxIn(KfsBox::Where where) const {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (boxes_[i].where != where) continue;
    if (!first || boxes_[i].taken_at < boxes_[*first].taken_at) first = i;
  }
  return first;
}

int Field::CountIn(KfsBox::Where where) const {
  return static_cast<int>(std::count_if(boxes_.begin(), boxes_.end(),
                                        [where](const KfsBox& box) { return box.where == where; }));
}

void Field::Note(FieldEvent::Kind kind, Duration now, const std::string& text) {
  if (events_.size() < kMostFieldEvents) events_.push_back({kind, now, robot_.position_m(), text});
}

// A climb is over when the whole robot is above another platform.
void Field::NoteClimb(Duration now) {
  const double here = spec_.HeightMm(robot_.position_m());
  if (here == stands_mm_ || robot_.fallen()) return;
  const Rotation2Dd turn(robot_.yaw_rad());
  for (const double x : {-kLiftWheelM, kLiftWheelM}) {
    for (const double y : {-kLiftWheelM, kLiftWheelM}) {
      if (spec_.HeightMm(robot_.position_m() + turn * Vector2d(x, y)) != here) return;
    }
  }
  Note(here > stands_mm_ ? FieldEvent::Kind::kUp : FieldEvent::Kind::kDown, now,
       NumberText(std::abs(here - stands_mm_)));
  stands_mm_ = here;
}

// It is bounded: when it is full, every second sample is dropped.
void Field::Record(Duration now) {
  way_.push_back({now, robot_.position_m(), robot_.height_mm(), robot_.wheels_mm()});
  if (way_.size() < kMostWaySamples) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < way_.size(); i += 2) way_[kept++] = way_[i];
  way_.resize(kept);
  way_period_ *= 2;
}

}  // namespace musher::world
