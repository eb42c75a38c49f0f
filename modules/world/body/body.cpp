#include "musher/modules/world/body/body.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "musher/modules/world/scene/place.hpp"

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr Duration kSwitching = Milliseconds(100);
constexpr Duration kQuickest = Milliseconds(400);  // to stand up or lie down, at least
constexpr double kTakeoff = 0.2;  // shares of a jump: on the ground until, and from, these
constexpr double kLanding = 0.8;
constexpr double kGravity = 9.81;
constexpr double kStillSpeed = 0.02;  // m/s, rad/s: below this it stands

constexpr double kAmbientC = 28;
constexpr double kWarmingSeconds = 120;

double Smooth(double share) {
  return share * share * (3 - 2 * share);
}

// The share of a jump's flight that is over, 0 to 1.
double Flight(double share) {
  return std::clamp((share - kTakeoff) / (kLanding - kTakeoff), 0.0, 1.0);
}

double Wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * M_PI);
}

Attitude Between(const Attitude& from, const Attitude& to, double share) {
  return {from.height_m + (to.height_m - from.height_m) * share,
          from.roll_rad + (to.roll_rad - from.roll_rad) * share,
          from.pitch_rad + (to.pitch_rad - from.pitch_rad) * share};
}

Duration TimeOf(const Scene& scene, const BoardCommand& command, const Motion& motion,
                double height_m) {
  Duration time = motion.time;
  for (const MotionTime& other : scene.motion_times) {
    if (other.mode == command.mode && other.gait == command.gait) time = other.time;
  }
  if (motion.kind == Kind::kWalk || motion.kind == Kind::kPose) {
    return command.duration > Duration::zero() ? command.duration : time;
  }
  const bool plain_stand = motion.kind == Kind::kStand && motion.gait == kAnyGait;
  if (!plain_stand && motion.kind != Kind::kLie) return time;
  // The shorter the distance that is left, the less time it takes.
  const BodySpec& spec = scene.body;
  const double to_m = plain_stand ? spec.stand_height_m : spec.lie_height_m;
  const double way = std::abs(to_m - height_m) / (spec.stand_height_m - spec.lie_height_m);
  const auto left =
      Duration(static_cast<std::int64_t>(static_cast<double>(time.count()) * std::min(way, 1.0)));
  return std::max(left, std::min(kQuickest, time));
}

double WarmthC(Activity activity) {
  switch (activity) {
    case Activity::kOff:
      return 0;
    case Activity::kLying:
      return 2;
    case Activity::kStanding:
      return 10;
    case Activity::kMoving:
      return 25;
  }
  return 0;
}

}  // namespace

const std::vector<FaultKind>& Faults() {
  static const std::vector<FaultKind> faults = {
      {"none", BoardStatus::kNormal, false},
      {"lifted", BoardStatus::kLifted, false},
      {"over_heat", BoardStatus::kOverHeat, false},
      {"orientation", BoardStatus::kOrientation, false},
      {"foot_position", BoardStatus::kFoot, false},
      {"stuck", BoardStatus::kStuck, false},
      {"motor_over_heat", BoardStatus::kMotorOverHeat, true},
      {"motor_over_current", BoardStatus::kMotorOverCurrent, true},
      {"motor", BoardStatus::kMotor, true},
  };
  return faults;
}

const FaultKind* FindFault(std::string_view name) {
  for (const FaultKind& fault : Faults()) {
    if (fault.name == name) return &fault;
  }
  return nullptr;
}

Body::Body(const Scene& scene)
    : motion_(FindMotion(scene.start_standing ? kModeStand : kModeLie, 1)),
      gait_(scene.start_standing ? 0 : 1),
      fault_(&Faults().front()),
      motor_temperature_c_(kAmbientC),
      pose_(scene.start) {
  attitude_.height_m = scene.start_standing ? scene.body.stand_height_m : scene.body.lie_height_m;
  began_at_ = attitude_;
  acceleration_.z() = kGravity;
}

std::optional<std::string> Body::Take(const Scene& scene, const BoardCommand& command,
                                      Duration now) {
  last_heartbeat_ = now;
  if (seen_life_count_ == command.life_count) return std::nullopt;
  seen_life_count_ = command.life_count;
  const Motion* motion = FindMotion(command.mode, command.gait);
  const std::string name =
      "mode " + std::to_string(command.mode) + " gait " + std::to_string(command.gait);
  if (motion == nullptr) {
    refused_ = true;
    return name + " is refused: the board has no such motion";
  }
  if (auto objection = Objection(command, *motion)) {
    refused_ = true;
    return name + " is refused: " + *objection;
  }
  Begin(scene, command, *motion);
  return std::nullopt;
}

std::optional<std::string> Body::Objection(const BoardCommand& command,
                                           const Motion& motion) const {
  if (motion.kind == Kind::kOff) return std::nullopt;
  if (supply_.battery_empty) return "the battery is empty";
  if (!supply_.motor_power) return "the motors have no power";
  if (fault_->status != BoardStatus::kNormal && motion.kind != Kind::kLie) {
    return "there is a fault: " + std::string(fault_->name);
  }
  if (motion_->kind == Kind::kLeap && Share() < 1) return "a jump has not ended";
  const bool low = motion.kind == Kind::kLie || motion.kind == Kind::kStand;
  if (motion_->kind == Kind::kStand && Share() < 1 && !low) {
    return "the body has not stood up yet";
  }
  const bool goes_on = command.mode == mode() && command.gait == gait_ &&
                       (motion.kind == Kind::kWalk || motion.kind == Kind::kPose);
  if (!goes_on && !MayFollow(mode(), gait_, command.mode)) {
    return "it may not follow mode " + std::to_string(mode());
  }
  return std::nullopt;
}

void Body::Begin(const Scene& scene, const BoardCommand& command, const Motion& motion) {
  taken_life_count_ = command.life_count;
  refused_ = false;
  const bool goes_on = command.mode == mode() && command.gait == gait_ &&
                       command.duration == Duration::zero() &&
                       command_.duration == Duration::zero() &&
                       (motion.kind == Kind::kWalk || motion.kind == Kind::kPose);
  switching_ = command.mode != mode();
  command_ = command;
  gait_ = command.gait;
  motion_ = &motion;
  if (goes_on) return;
  time_ = TimeOf(scene, command, motion, attitude_.height_m);
  elapsed_ = Duration::zero();
  began_at_ = attitude_;
}

void Body::BeginOff(const Scene& scene) {
  const std::int8_t taken = taken_life_count_;
  Begin(scene, BoardCommand{}, *FindMotion(kModeOff, 0));
  taken_life_count_ = taken;  // not from a command
}

void Body::SetFault(const FaultKind& fault, std::size_t motor) {
  fault_ = &fault;
  motor_errors_ = {};
  if (!fault.of_a_motor) return;
  const int bit = static_cast<int>(fault.status) - static_cast<int>(BoardStatus::kMotorOverHeat);
  motor_errors_.at(motor) = 1 << bit;
}

void Body::Step(const Scene& scene, const Supply& supply, Duration now, Duration dt,
                NormalRandom& random) {
  const double seconds = ToSeconds(dt);
  supply_ = supply;
  if (!supply_.on() && motion_->kind != Kind::kOff) BeginOff(scene);
  const double share = Share();
  if (!Stalled()) elapsed_ = std::min(elapsed_ + dt, time_);

  const Pose2 pose = pose_;
  const Attitude attitude = attitude_;
  Move(scene, Drive(scene, now, seconds, random) + LeapBetween(share, Share()));
  attitude_ = NextAttitude(scene, seconds);
  Measure(pose, attitude, seconds);
  const double target_c = kAmbientC + WarmthC(activity());
  motor_temperature_c_ += (target_c - motor_temperature_c_) * seconds / kWarmingSeconds;
}

// With a fault it only lies down or ends its jump.
bool Body::Stalled() const {
  return fault_->status != BoardStatus::kNormal && motion_->kind != Kind::kOff &&
         motion_->kind != Kind::kLie && motion_->kind != Kind::kLeap;
}

double Body::Share() const {
  return time_ > Duration::zero() ? ToSeconds(elapsed_) / ToSeconds(time_) : 1;
}

Vector3d Body::Drive(const Scene& scene, Duration now, double seconds, NormalRandom& random) {
  const BodySpec& spec = scene.body;
  const bool timed = command_.duration > Duration::zero();
  const bool wanted = timed ? elapsed_ < time_ : now - last_heartbeat_ <= spec.command_timeout;
  Vector3d target = Vector3d::Zero();
  if (motion_->kind == Kind::kWalk && wanted && !Stalled()) {
    target = command_.speed.cwiseMin(motion_->limit).cwiseMax(-motion_->limit);
    target.head<2>() *= 1 - spec.slip;
    target.z() *= 1 - spec.yaw_slip.value_or(spec.slip);
  }
  walking_ += (target - walking_) * (1 - std::exp(-seconds / ToSeconds(spec.lag)));
  if (spec.noise == 0) return walking_ * seconds;
  Vector3d noisy = walking_;
  for (double& value : noisy) value *= 1 + spec.noise * random.Normal();
  return noisy * seconds;
}

Vector3d Body::LeapBetween(double share, double next_share) const {
  if (motion_->kind != Kind::kLeap) return Vector3d::Zero();
  const double gain = Smooth(Flight(next_share)) - Smooth(Flight(share));
  if (gain == 0) return Vector3d::Zero();
  // What it has turned already is removed from the path, which is in the frame of its start.
  const double turned_rad = motion_->leads.z() * Smooth(Flight(share));
  Vector3d by = motion_->leads * gain;
  by.head<2>() = Rotation2Dd(-turned_rad) * Vector2d(by.head<2>());
  return by;
}

Attitude Body::NextAttitude(const Scene& scene, double seconds) const {
  Attitude wanted{scene.body.stand_height_m, 0, 0};
  switch (motion_->kind) {
    case Kind::kOff:
    case Kind::kLie:
      wanted.height_m = scene.body.lie_height_m;
      break;
    case Kind::kPose: {
      wanted.height_m += command_.raised_m;
      wanted.roll_rad = command_.attitude.x();
      wanted.pitch_rad = command_.attitude.y();
      const double times = 4 * seconds / std::max(ToSeconds(time_), seconds);
      return Stalled() ? attitude_ : Between(attitude_, wanted, 1 - std::exp(-times));
    }
    case Kind::kLeap: {
      const double flight = Flight(Share());
      wanted.height_m += motion_->height_m * 4 * flight * (1 - flight);
      wanted.roll_rad = Wrapped(motion_->roll_rad * Smooth(flight));
      wanted.pitch_rad = Wrapped(motion_->pitch_rad * Smooth(flight));
      return wanted;
    }
    case Kind::kShow:
      wanted.pitch_rad = motion_->pitch_rad;
      break;
    case Kind::kStand:
    case Kind::kWalk:
      break;
  }
  return Between(began_at_, wanted, Smooth(Share()));
}

void Body::Move(const Scene& scene, const Vector3d& by) {
  const Vector2d ahead = by.head<2>();
  const Step2 step =
      Go(scene, pose_.position_m, pose_.position_m + Rotation2Dd(pose_.yaw_rad) * ahead);
  const Vector2d moved = Rotation2Dd(-pose_.yaw_rad) * Vector2d(step.to_m - pose_.position_m);
  bumped_ = step.bumped;
  pose_.position_m = step.to_m;
  pose_.yaw_rad = Wrapped(pose_.yaw_rad + by.z());
  const double drift_rad = scene.body.odometry_yaw_drift_rad_per_m * moved.norm();
  odometry_.position_m +=
      Rotation2Dd(odometry_.yaw_rad) * Vector2d(moved * scene.body.odometry_scale);
  odometry_.yaw_rad = Wrapped(odometry_.yaw_rad + by.z() + drift_rad);
}

void Body::Measure(const Pose2& pose, const Attitude& attitude, double seconds) {
  const Vector2d moved = Rotation2Dd(-pose_.yaw_rad) * Vector2d(pose_.position_m - pose.position_m);
  const Vector3d before = speed_;
  speed_ << moved / seconds, (attitude_.height_m - attitude.height_m) / seconds;
  turn_rate_ << Wrapped(attitude_.roll_rad - attitude.roll_rad),
      Wrapped(attitude_.pitch_rad - attitude.pitch_rad), Wrapped(pose_.yaw_rad - pose.yaw_rad);
  turn_rate_ /= seconds;
  const Matrix3d tilt = (AngleAxisd(attitude_.pitch_rad, Vector3d::UnitY()) *
                         AngleAxisd(attitude_.roll_rad, Vector3d::UnitX()))
                            .toRotationMatrix();
  acceleration_ = (speed_ - before) / seconds + tilt.transpose() * Vector3d(0, 0, kGravity);
}

// More than 95 counts as done.
int Body::progress_percent() const {
  constexpr int kNotDone = 95;
  const double share = Share();
  return share < 1 ? std::min(kNotDone, static_cast<int>(share * 100)) : 100;
}

BoardStatus Body::status() const {
  if (supply_.battery_empty) return BoardStatus::kLowBattery;
  if (!supply_.motor_power) return BoardStatus::kDamped;
  if (fault_->status != BoardStatus::kNormal) return fault_->status;
  if (refused_) return BoardStatus::kBanTrans;
  return switching_ && elapsed_ < kSwitching ? BoardStatus::kTransitioning : BoardStatus::kNormal;
}

bool Body::in_the_air() const {
  const double flight = Flight(Share());
  return motion_->kind == Kind::kLeap && flight > 0 && flight < 1;
}

double Body::motor_temperature_c(std::size_t motor) const {
  constexpr double kKneesAreWarmerC = 1.5;
  return motor_temperature_c_ + (motor % 3 == 2 ? kKneesAreWarmerC : 0);
}

Activity Body::activity() const {
  if (motion_->kind == Kind::kOff) return Activity::kOff;
  if (motion_->kind == Kind::kLie) return Activity::kLying;
  const bool showing =
      (motion_->kind == Kind::kLeap || motion_->kind == Kind::kShow) && Share() < 1;
  const bool walking = walking_.cwiseAbs().maxCoeff() > kStillSpeed;
  return showing || walking ? Activity::kMoving : Activity::kStanding;
}

}  // namespace musher::world
