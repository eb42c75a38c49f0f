#include "musher/modules/world/simulation/guests.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurnRadS = 2.5;      // of a body
constexpr double kHeadTurnRadS = 4;    // of a head
constexpr double kFarthestTurn = 1.3;  // rad, of a head on its body
constexpr double kFarthestNod = 0.7;   // rad
constexpr double kSideways = 1.9;      // rad: a target farther round than that is reached backwards

double Angle(const Vector2d& way) {
  return std::atan2(way.y(), way.x());
}

double Between(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, 2 * M_PI);
}

// Turned towards `to` by at most `most`.
double Towards(double from_rad, double to_rad, double most_rad) {
  return std::remainder(from_rad + std::clamp(Between(from_rad, to_rad), -most_rad, most_rad),
                        2 * M_PI);
}

// The direction to look, in the place's frame.
double YawOf(const GuestLook& look, const Guest& guest, const Robot& robot, double ahead_rad) {
  const double at_robot = Angle(robot.eyes_m.head<2>() - guest.position_m);
  switch (look.at) {
    case GuestLook::At::kRobot:
      return at_robot;
    case GuestLook::At::kAway:
      return at_robot + M_PI;
    case GuestLook::At::kYaw:
      return look.yaw_rad;
    case GuestLook::At::kAhead:
      break;
  }
  return ahead_rad;
}

void TurnHead(const GuestSpec& spec, const GuestLook& look, const Robot& robot, double yaw_rad,
              double seconds, Guest& guest) {
  constexpr double kNearly = 0.15;  // rad
  const Vector3d to_eyes = robot.eyes_m - HeadOf(spec, guest);
  const bool at_robot = look.at == GuestLook::At::kRobot;
  const double pitch = at_robot ? -std::atan2(to_eyes.z(), to_eyes.head<2>().norm()) : 0;
  const double turn = std::clamp(Between(guest.yaw_rad, yaw_rad), -kFarthestTurn, kFarthestTurn);
  const double most = kHeadTurnRadS * seconds;
  guest.head_yaw_rad = Towards(guest.head_yaw_rad, guest.yaw_rad + turn, most);
  guest.head_pitch_rad =
      Towards(guest.head_pitch_rad, std::clamp(pitch, -kFarthestNod, kFarthestNod), most);
  guest.looks_at_robot = at_robot && std::abs(Between(guest.head_yaw_rad, yaw_rad)) < kNearly;
}

void KeepOut(const Robot& robot, Guest& guest) {
  const Vector2d gap = guest.position_m - robot.position_m;
  const double least_m = robot.radius_m + kGuestRadiusM;
  if (gap.norm() >= least_m) return;
  const Vector2d away = gap.norm() > 0 ? Vector2d(gap.normalized()) : Vector2d::UnitX();
  guest.position_m = robot.position_m + least_m * away;
}

}  // namespace

Guests::Guests(const Scene& scene) {
  Begin(scene);
}

void Guests::Begin(const Scene& scene) {
  guests_.assign(scene.guests.size(), {});
  plans_.assign(scene.guests.size(), {});
  for (std::size_t i = 0; i < guests_.size(); ++i) {
    const GuestSpec& spec = scene.guests[i];
    guests_[i].here = spec.acts.empty();
    guests_[i].position_m = spec.from_m;
    guests_[i].yaw_rad = guests_[i].head_yaw_rad = spec.yaw_rad;
    plans_[i].speed_m_s = spec.speed_m_s;
  }
}

void Guests::Step(const Scene& scene, const Robot& robot, Duration now, Duration dt) {
  const bool repeats = scene.guests_repeat > Duration::zero();
  const Duration within = repeats ? now % scene.guests_repeat : now;
  if (within < within_) Begin(scene);
  within_ = within;
  const double seconds = ToSeconds(dt);
  for (std::size_t i = 0; i < guests_.size(); ++i) {
    const GuestSpec& spec = scene.guests[i];
    Plan& plan = plans_[i];
    while (plan.next_act < spec.acts.size() && spec.acts[plan.next_act].at <= within) {
      Act(spec, spec.acts[plan.next_act++], guests_[i], plan);
    }
    if (guests_[i].here) Move(spec, robot, seconds, guests_[i], plan);
  }
}

void Guests::Act(const GuestSpec& spec, const GuestAct& act, Guest& guest, Plan& plan) {
  guest.here = true;
  if (act.speed_m_s) plan.speed_m_s = *act.speed_m_s;
  if (act.look) plan.look = *act.look;
  if (act.gesture) guest.gesture = *act.gesture;
  if (act.walk_to_m) plan.walk_to_m = act.walk_to_m;
  if (act.leave && !act.walk_to_m) plan.walk_to_m = spec.from_m;
  if (act.walk_to_m || act.leave) plan.leaves = act.leave;
}

void Guests::Move(const GuestSpec& spec, const Robot& robot, double seconds, Guest& guest,
                  Plan& plan) {
  std::optional<double> course;
  if (plan.walk_to_m) {
    const Vector2d way = *plan.walk_to_m - guest.position_m;
    const double step_m = plan.speed_m_s * seconds;
    const bool arrives = way.norm() <= step_m;
    guest.position_m += arrives ? way : Vector2d(way.normalized() * step_m);
    if (!arrives) course = Angle(way);
    if (arrives) plan.walk_to_m.reset();
    if (arrives && plan.leaves) {
      guest.here = false;
      guest.gesture = Gesture::kNone;
      guest.looks_at_robot = false;
      return;
    }
  }
  KeepOut(robot, guest);
  const double look = YawOf(plan.look, guest, robot, course.value_or(guest.yaw_rad));
  double face = course.value_or(look);
  // A guest who has the robot in view steps back from it, and does not turn round.
  const bool back = plan.look.at == GuestLook::At::kRobot && course && !plan.leaves;
  if (back && std::abs(Between(look, *course)) > kSideways) face = look;
  guest.yaw_rad = Towards(guest.yaw_rad, face, kTurnRadS * seconds);
  TurnHead(spec, plan.look, robot, look, seconds, guest);
}

double HeadHeightM(const GuestSpec& guest) {
  return 0.11 + 0.08 * guest.height_m;  // a child's is larger relative to its height
}

Vector3d HeadOf(const GuestSpec& spec, const Guest& guest) {
  return {guest.position_m.x(), guest.position_m.y(), spec.height_m - HeadHeightM(spec) / 2};
}

}  // namespace musher::world
