#pragma once
// Ways out for a robot that gets no farther: each is one short motion, or a wait, polled in the
// steps of a skill. The gate before the base checks them as everything else.
//
//   leave_tight_start  turns away from what its scan sees nearest, and goes 0.3 m
//   clear              planner and controller forget what they have seen, and see it again for 1 s
//   wait               stands for 3 s, or as long as it is asked to
//   back_up            0.4 m back along the path that it has come, as far as that leads behind the
//                      robot; straight back where that is less than 0.2 m, as after a start of the
//                      process, a turn on the spot or a motion backwards. It never goes ahead
//   spin               once around, for a look at all sides
//
// A motion without odometry, without a scan, or that the gate holds for a second, fails; so does
// one to where no scanner covers all of its way: what is not seen there may be a person. Frames and
// units of robot.hpp.

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/skills/robot/robot.hpp"
#include "musher/modules/skills/skills/way_back.hpp"

namespace musher::skills {

enum class RecoveryKind : std::uint8_t { kLeaveTightStart, kClear, kWait, kBackUp, kSpin };

// What a robot has to recover from.
enum class Trouble : std::uint8_t {
  kTightStart,  // the planner: it has no room where it stands
  kNoPath,      // the planner: no path, or none in its time
  kBlocked,     // an obstacle stays in the way, and the robot has stood before it for some time
  kMover,       // who walks stands in the way
};

class Recovery {
 public:
  // Of "leave_tight_start, clear, wait, back_up, spin", in any order and number; empty: none.
  // `name`: of the parameter, for the error.
  static Result<std::vector<RecoveryKind>> Parse(const std::string& name, const std::string& text);
  static std::string NameOf(RecoveryKind kind);
  static bool Moves(RecoveryKind kind);
  // Whether it may help. A motion changes no map, and flyers are not moved.
  static bool Helps(RecoveryKind kind, Trouble trouble, bool flies);
  // At most, of one.
  static Duration LongestOf(RecoveryKind kind);

  // How fast kBackUp moves and kSpin turns.
  static constexpr double kMostMPerS = 0.15;
  static constexpr double kMostRadPerS = 0.6;

  // How far kBackUp and kSpin lead, and how long kWait is.
  struct Amount {
    double ahead_m = -0.4;              // of kBackUp; negative: backwards
    bool as_it_came = true;             // kBackUp: on the path that it has come; else straight
    double turn_rad = 2 * M_PI;         // of kSpin, to the left; negative: to the right
    double speed_m_s = kMostMPerS;      // of kBackUp
    std::optional<Duration> longest{};  // nullopt: LongestOf(); all of it, of kWait
  };

  explicit Recovery(Robot& robot) : robot_(robot) {}

  void Begin(RecoveryKind kind) { Begin(kind, {}); }
  void Begin(RecoveryKind kind, const Amount& amount);
  // Nullopt: it goes on; else its end, with the reason of a failure, and the base stands. The code
  // of a motion's failure: Fault::kOdometry and kJump without its pose, kObstacle where the gate
  // holds it, kLate at its limit, kScan where it does not see its way, kCodeFailed where it has
  // left its way.
  std::optional<Result<>> Step(Duration step);
  double share() const;  // 0 to 1
  // How far kBackUp has come on its way, or how far it is from its begin; how far kSpin has turned
  // to the side to which it was to turn, or to the left.
  double moved_m() const { return moved_m_; }
  double turned_rad() const { return turned_rad_; }

 private:
  std::optional<Result<>> StepOfClear();
  std::optional<Result<>> StepOfMotion(Duration step);
  void BeginMotion(const navigation::Pose& pose, const navigation::Pose& odometry);
  void NoteMotion(const navigation::Pose& pose);
  bool IsMotionOver() const;
  navigation::Velocity Command(const navigation::Pose& odometry,
                               const std::vector<navigation::Point>& around);
  // What is left of its way, in the frame of the body: places, each with the direction in which the
  // body goes on.
  std::vector<navigation::Pose> WayLeft(const navigation::Pose& odometry, double ahead_m_s) const;
  // Whether a scan covers all that the body comes to there.
  bool IsCovered(const std::vector<navigation::Pose>& way) const;

  Duration longest() const { return amount_.longest.value_or(LongestOf(kind_)); }

  Robot& robot_;
  Amount amount_;
  RecoveryKind kind_ = RecoveryKind::kWait;
  skill::Future<bool> cleared_;
  std::optional<Duration> cleared_at_;
  Duration passed_{};
  Duration held_{};
  std::optional<navigation::Pose> begin_;
  std::optional<WayBack> way_back_;  // of kBackUp, where its path is known
  double moved_m_ = 0;
  double away_m_ = 0;  // from its begin
  double side_m_ = 0;  // to the side of the heading there
  double step_m_ = 0;  // since the last step
  double turned_rad_ = 0;
  navigation::Pose last_;
  bool turns_ = true;  // of kLeaveTightStart: until it looks away
};

}  // namespace musher::skills
