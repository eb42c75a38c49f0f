#pragma once
// A robot, or several, and the place they are in, moved in steps of 20 ms of world time. A plain
// value: the same scene, seed and inputs give the same world, however the time is sliced into
// calls.

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/modules/world/body/battery.hpp"
#include "musher/modules/world/body/body.hpp"
#include "musher/modules/world/body/humanoid.hpp"
#include "musher/modules/world/scene/scene.hpp"
#include "musher/modules/world/simulation/field.hpp"
#include "musher/modules/world/simulation/fleet.hpp"
#include "musher/modules/world/simulation/guests.hpp"
#include "musher/modules/world/simulation/referee.hpp"
#include "musher/modules/world/simulation/track.hpp"

namespace musher::world {

inline constexpr Duration kStep = Milliseconds(20);

// Whether the step that ends at `now` reached a multiple of the period.
bool IsDue(Duration now, double rate_hz);

// The outputs of a step.
struct StepOutputs {
  std::vector<int> touches;      // touch_state codes
  std::optional<double> speed;   // the scene changed the speed of time
  std::vector<std::string> log;  // for the log
};

class World {
 public:
  explicit World(Scene scene);

  StepOutputs Step();

  // A command of the body's commander. Returns the reason when it is refused.
  std::optional<std::string> Command(const BoardCommand& command);
  // From 0 to 100; else returns the reason.
  std::optional<std::string> SetBattery(double percent);
  void Plug(bool in);
  void SetMotorPower(bool on) { supply_.motor_power = on; }
  // Returns the reason when the body cannot be there.
  std::optional<std::string> PutDown(const Pose2& at);
  // "none" ends the faults of sensors, too.
  void SetFault(const FaultKind& fault, std::size_t motor);
  // One of kSensorFaults: that sensor publishes nothing any more.
  void Silence(const std::string& sensor) { silent_.insert(sensor); }
  // Drawn only: the machine's state, the colour of a light.
  void SetMachineState(const std::string& state) { machine_state_ = state; }
  void SetLight(int target, const Light& light);
  // This moment, in the charts of the picture.
  void AddMark(const std::string& text) { track_.AddMark({now_, text}); }
  // Of a humanoid; they return the reason when refused.
  std::optional<std::string> SetPose(const std::string& name);
  std::optional<std::string> LookAt(const Eigen::Vector2d& point);
  // A ball appears or disappears. Returns the reason when there is no ball of that name.
  std::optional<std::string> SetShown(const std::string& ball, bool shown);

  // Of the scene's robots, by their index.
  std::optional<std::string> Drive(std::size_t robot, const BodyVelocity& command) {
    return fleet_.Command(robot, command, now_);
  }
  std::optional<std::string> SetBattery(std::size_t robot, double percent) {
    return fleet_.SetBattery(*scene_, robot, percent);
  }
  std::optional<std::string> PutDown(std::size_t robot, const Pose2& at) {
    return fleet_.PutDown(*scene_, BodySolid(), robot, at, now_);
  }
  HandReply UseHand(std::size_t robot, const HandRequest& request) {
    return fleet_.UseHand(*scene_, robot, request);
  }
  void SetPlanned(std::size_t robot, std::vector<Eigen::Vector2d> points_m) {
    fleet_.SetPlanned(robot, std::move(points_m));
  }
  std::optional<std::size_t> FindRobot(const std::string& name) const;

  // Of a scene with a field.
  std::optional<std::string> DriveLift(const Eigen::Vector3d& velocity) {
    return field_->Drive(velocity, now_);
  }
  std::optional<std::string> Lift(const WheelHeights& heights_mm) {
    return field_->Lift(heights_mm);
  }
  std::optional<std::string> CommandArm(double command) {
    return field_->CommandArm(command, now_);
  }
  std::optional<std::string> CommandSpear(double command) {
    return field_->CommandSpear(command, now_);
  }

  Duration now() const { return now_; }
  // As it is now; valid until the next step or change.
  const Scene& scene() const { return *scene_; }
  const Body& body() const { return body_; }
  const Battery& battery() const { return battery_; }
  const std::optional<Humanoid>& humanoid() const { return humanoid_; }
  Gaze gaze() const { return humanoid_ ? humanoid_->gaze() : Gaze{}; }
  const std::vector<Guest>& guests() const { return guests_.all(); }
  const Fleet& fleet() const { return fleet_; }
  const std::optional<Field>& field() const { return field_; }
  // The body as the other robots meet it; nothing if there is none.
  std::vector<Solid> BodySolid() const;
  // The frame of camera `index` in the place's.
  Eigen::Isometry3d CameraPose(std::size_t index) const;
  bool on_pad() const;
  const Track& track() const { return track_; }
  const Referee& referee() const { return referee_; }
  bool IsSilent(const std::string& sensor) const { return silent_.contains(sensor); }

 private:
  void StepBody(StepOutputs& outputs);
  void Apply(const SceneEvent& event, StepOutputs& outputs);
  void StepBalls(StepOutputs& outputs);
  void SetShown(std::size_t ball, bool shown);
  void Record();
  RobotSeen Seen() const;  // by the referee

  std::shared_ptr<const Scene> scene_;  // replaced when a ball appears or disappears
  Duration now_{};
  NormalRandom random_;
  Body body_;
  Battery battery_;
  std::optional<Humanoid> humanoid_;
  Guests guests_;
  Fleet fleet_;
  std::optional<Field> field_;
  Referee referee_;
  Supply supply_;
  std::size_t next_event_ = 0;
  std::vector<std::optional<Duration>> hide_at_;  // of each ball that appeared by an approach
  bool touching_ = false;                         // an obstacle stopped the body in the last step
  std::string machine_state_;
  std::set<std::string> silent_;  // sensors
  Track track_;
};

}  // namespace musher::world
