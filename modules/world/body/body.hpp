#pragma once
// The body of a CyberDog-like quadruped with its motion board: takes the board's commands, moves,
// and reports as the board does.
//
//   Off (0) - Lie (7) - Stand (12) - Walk (11, 9 ...) - Pose (3, 21) - Leap (16, 17) - Show (62
//   ...)
//
// A new command has another life_count than the one before; a repeated one serves as a heartbeat.
// A command is refused (switch_status BAN_TRANS) if its mode may not follow the present one, while
// the body is in the air, or before it has stood up; and with the fault's status during a fault.
// Walking ends when the commands do. Without power the body sinks down.
//
// A plain value: time and random numbers come in as arguments.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/modules/world/body/battery.hpp"
#include "musher/modules/world/body/motion_table.hpp"
#include "musher/modules/world/body/normal_random.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

inline constexpr std::size_t kMotors = 12;

struct BoardCommand {
  int mode = 0;
  int gait = 0;
  std::int8_t life_count = 0;
  Eigen::Vector3d speed{0, 0, 0};     // x and y in m/s, yaw in rad/s
  Eigen::Vector3d attitude{0, 0, 0};  // roll, pitch, yaw in rad, for poses
  double raised_m = 0;                // for poses: the trunk, above its standing height
  Duration duration{};                // zero: until the commands end
};

// MotionStatus.switch_status.
enum class BoardStatus : std::int8_t {
  kNormal = 0,
  kTransitioning = 1,
  kDamped = 3,
  kLifted = 4,
  kBanTrans = 5,
  kOverHeat = 6,
  kLowBattery = 7,
  kOrientation = 8,
  kFoot = 9,
  kStuck = 10,
  kMotorOverHeat = 11,
  kMotorOverCurrent = 12,
  kMotor = 13,
};

// The faults of a board, by their names in scenes.
struct FaultKind {
  std::string_view name;
  BoardStatus status = BoardStatus::kNormal;
  bool of_a_motor = false;
};
const std::vector<FaultKind>& Faults();  // "none" is the first
const FaultKind* FindFault(std::string_view name);

struct Supply {
  bool motor_power = true;
  bool battery_empty = false;

  bool on() const { return motor_power && !battery_empty; }
};

struct Attitude {
  double height_m = 0;
  double roll_rad = 0;
  double pitch_rad = 0;
};

class Body {
 public:
  explicit Body(const Scene& scene);

  // Returns the reason when it refuses the command.
  std::optional<std::string> Take(const Scene& scene, const BoardCommand& command, Duration now);

  void Step(const Scene& scene, const Supply& supply, Duration now, Duration dt,
            NormalRandom& random);

  // Moved to a place by hand: odometry does not notice.
  void PutDown(const Pose2& at) { pose_ = at; }
  void SetFault(const FaultKind& fault, std::size_t motor);

  int mode() const { return motion_->mode; }
  int gait() const { return gait_; }
  int progress_percent() const;
  BoardStatus status() const;
  std::int8_t life_count() const { return taken_life_count_; }
  bool in_the_air() const;
  bool bumped() const { return bumped_; }  // in the last step
  const std::array<std::int32_t, kMotors>& motor_errors() const { return motor_errors_; }
  double motor_temperature_c(std::size_t motor) const;

  const Pose2& pose() const { return pose_; }          // in the place's frame
  const Pose2& odometry() const { return odometry_; }  // from where it was switched on
  const Attitude& attitude() const { return attitude_; }
  const Eigen::Vector3d& speed() const { return speed_; }          // m/s in the body's frame
  const Eigen::Vector3d& turn_rate() const { return turn_rate_; }  // rad/s: roll, pitch, yaw
  // The reading of an accelerometer in the trunk, gravity included.
  const Eigen::Vector3d& acceleration() const { return acceleration_; }
  Activity activity() const;

 private:
  std::optional<std::string> Objection(const BoardCommand& command, const Motion& motion) const;
  void Begin(const Scene& scene, const BoardCommand& command, const Motion& motion);
  void BeginOff(const Scene& scene);
  bool Stalled() const;
  double Share() const;  // progress of the motion, 0 to 1
  // The displacement by walking and jumping in a step, in its own frame: x and y in m, yaw in rad.
  Eigen::Vector3d Drive(const Scene& scene, Duration now, double seconds, NormalRandom& random);
  Eigen::Vector3d LeapBetween(double share, double next_share) const;
  Attitude NextAttitude(const Scene& scene, double seconds) const;
  void Move(const Scene& scene, const Eigen::Vector3d& by);
  void Measure(const Pose2& pose, const Attitude& attitude, double seconds);

  const Motion* motion_;  // in the table, which is immutable
  int gait_ = 0;
  BoardCommand command_;
  Duration time_{};     // that the motion takes
  Duration elapsed_{};  // of it
  Attitude began_at_;
  Duration last_heartbeat_{};  // last heartbeat of the commander
  std::optional<std::int8_t> seen_life_count_;
  std::int8_t taken_life_count_ = 0;
  bool refused_ = false;
  bool switching_ = false;  // the motion has another mode than the one before
  Supply supply_;
  const FaultKind* fault_;
  std::array<std::int32_t, kMotors> motor_errors_{};
  double motor_temperature_c_ = 0;

  Pose2 pose_;
  Pose2 odometry_;
  Attitude attitude_;
  Eigen::Vector3d walking_{0, 0, 0};  // speed: x and y in m/s, yaw in rad/s
  Eigen::Vector3d speed_{0, 0, 0};
  Eigen::Vector3d turn_rate_{0, 0, 0};
  Eigen::Vector3d acceleration_{0, 0, 0};
  bool bumped_ = false;
};

}  // namespace musher::world
