#pragma once
// A robot and the place it is in, moved in steps of 20 ms of world time. A plain value: the same
// scene, seed and inputs give the same world, however the time is sliced into calls.

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/modules/world/battery.hpp"
#include "musher/modules/world/body.hpp"
#include "musher/modules/world/guests.hpp"
#include "musher/modules/world/humanoid.hpp"
#include "musher/modules/world/scene.hpp"
#include "musher/modules/world/track.hpp"

namespace musher::world {

inline constexpr Duration kStep = Milliseconds(20);

// Whether the step that ends at `now` came to a multiple of the period.
bool IsDue(Duration now, double rate_hz);

// What a step brought forth for those outside.
struct Happenings {
  std::vector<int> touches;       // touch_state codes
  std::optional<double> speed;    // the scene changed how fast time runs
  std::vector<std::string> said;  // for the log
};

class World {
 public:
  explicit World(Scene scene);

  Happenings Step();

  // A command of the body's commander. Says why when it is refused.
  std::optional<std::string> Command(const BoardCommand& command);
  // From 0 to 100; else it says why not.
  std::optional<std::string> SetBattery(double percent);
  void Plug(bool in);
  void SetMotorPower(bool on) { supply_.motor_power = on; }
  // Says why when the body cannot be there.
  std::optional<std::string> PutDown(const Pose2& at);
  // "none" ends the faults of sensors, too.
  void SetFault(const FaultKind& fault, std::size_t motor);
  // One of kSensorFaults: nothing comes from that sensor any more.
  void Silence(const std::string& sensor) { silent_.insert(sensor); }
  // What others said, to be drawn: the machine's state, the colour of a light.
  void SetMachineState(const std::string& state) { machine_state_ = state; }
  void SetLight(int target, const Light& light);
  // Of a humanoid; they say why when it is refused.
  std::optional<std::string> SetPose(const std::string& name);
  std::optional<std::string> LookAt(const Eigen::Vector2d& point);

  Duration now() const { return now_; }
  const Scene& scene() const { return *scene_; }
  const Body& body() const { return body_; }
  const Battery& battery() const { return battery_; }
  const std::optional<Humanoid>& humanoid() const { return humanoid_; }
  Gaze gaze() const { return humanoid_ ? humanoid_->gaze() : Gaze{}; }
  const std::vector<Guest>& guests() const { return guests_.all(); }
  // The frame of camera `index` in the place's.
  Eigen::Isometry3d CameraPose(std::size_t index) const;
  bool on_pad() const;
  const Track& track() const { return track_; }
  bool IsSilent(const std::string& sensor) const { return silent_.contains(sensor); }

 private:
  void Happen(const SceneEvent& event, Happenings& happenings);
  void Record();

  std::shared_ptr<const Scene> scene_;  // never changed
  Duration now_{};
  Chance chance_;
  Body body_;
  Battery battery_;
  std::optional<Humanoid> humanoid_;
  Guests guests_;
  Supply supply_;
  std::size_t next_event_ = 0;
  bool touching_ = false;  // the body was stopped by something in the last step
  std::string machine_state_;
  std::set<std::string> silent_;  // sensors
  Track track_;
};

}  // namespace musher::world
