#pragma once
// The travel of a robot to a goal, in the parts that the moving skills share: the servers are
// reachable, a path is planned, the robot is driven along it, it is stopped.
//
// A part is polled in each step of a skill, and decides nothing about retries and limits of states:
//
//   kPending   not done yet
//   kDone      done
//   kBlocked   an obstacle stays in the way: another path may help
//   kLost      a server, its map or the odometry is missing: waiting may help
//   kFailed    `why` is the reason; another attempt has the same result, unless a recovery helps
//
// Frames and units of robot.hpp. Threads: those of robot.hpp.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/modules/skills/skills/recovery.hpp"

namespace musher::skills {

// How long a server, or the odometry, may be missing before it counts as lost.
inline constexpr Duration kLostAfter = std::chrono::seconds(3);
// The wait for the servers at the begin, and between two attempts.
inline constexpr Duration kServerWait = std::chrono::seconds(2);
// An arrival that is farther from the goal is none. The controller arrives within 0.2 m.
inline constexpr double kArrivedWithinM = 0.5;
// Between the body and an obstacle, as planner and controller keep it by default.
inline constexpr double kObstacleMarginM = 0.1;
// A robot that is slower stands.
inline constexpr double kStandingMPerS = 0.05;
inline constexpr double kStandingRadPerS = 0.05;

bool Stands(const Robot& robot);
// The path without what lies behind the robot, which moves.
navigation::Path FromHere(const Robot& robot, const navigation::Path& path);
// The path of a drive that has not arrived, without what the robot has passed of it: first to the
// nearest place of the path. Where it passes the same place twice, from the first time on. The
// whole path where the robot is more than 2 m off it: the controller refuses that.
navigation::Path RestOf(const Robot& robot, const navigation::Path& path);

// From `point` to the line between `from` and `to`. On the ground heights do not count.
double ApartFromLine(const Robot& robot, const navigation::Point& point,
                     const navigation::Point& from, const navigation::Point& to);

// The way of a robot by its odometry since the last call with `last`, which it sets. A correction
// of its localisation is none, and neither is a step of more than a metre: its odometry has jumped.
navigation::Point WaySince(std::optional<navigation::Point>& last, const Robot& robot);

// "4.2", or "1.41e+308": a request may have any number.
std::string LengthText(double length_m);

// What its scan sees within `most_m`, in the frame of a body at `pose`.
std::vector<navigation::Point> SeenAround(const Robot& robot, const navigation::Pose& pose,
                                          double most_m);

// Of a place for a flyer, named "goal_pos", "way-point 2": above 0 m, and not above its ceiling.
Result<> CheckAltitude(const Robot& robot, const std::string& place, double height_m);
// A flyer at this height is in the air. Robots on the ground always pass.
Result<> CheckInTheAir(const Robot& robot, double height_m);

// Since when a robot has not left a place. What it moves in its place does not count: each new path
// past an obstacle lets it turn, and drive a little.
class Standstill {
 public:
  static constexpr double kWithinM = 0.3;

  // After each step; without a pose it is as if the robot stood.
  void Note(const std::optional<navigation::Pose>& pose, Duration step);
  void Restart() { *this = {}; }
  Duration time() const { return time_; }  // 0: it has just left one

 private:
  std::optional<navigation::Point> place_;
  Duration time_{};
};

struct TravelStep {
  enum class Kind : std::uint8_t { kPending, kDone, kBlocked, kLost, kFailed };

  Kind kind = Kind::kPending;
  std::string why{};
  std::optional<Trouble> trouble{};  // kFailed: a recovery may help
};

class Travel {
 public:
  explicit Travel(Robot& robot) : robot_(robot) {}

  // kDone or kPending; then `why` says what is missing, by the texts of errors.
  TravelStep Reach() const;

  // Asks for a path in the first call, and again after its end and after GiveUp(). `step`: the time
  // since the last call.
  TravelStep Plan(const navigation::Pose& goal, const std::optional<navigation::Pose>& start,
                  Duration step);
  const navigation::Path& planned() const { return planned_; }

  // Drives along `path`, instead of what was driven before. What a moving robot has passed of it
  // since it was planned is left out.
  void Begin(const navigation::Path& path);
  // Drives along what is left of the last path.
  void BeginRest();
  bool planning() const { return plan_.valid(); }
  // Whether a drive has begun, has not ended and was not given up.
  bool driving() const { return drive_ != nullptr; }
  TravelStep Drive(Duration step);
  // To the end of the path: by the controller, or straight when it has not said.
  double distance_to_goal_m() const;
  // Of the path, from where the robot was.
  double length_m() const { return length_m_; }
  // What the scan sees in the way on the next `ahead_m` of the last path, in the frame of the map.
  // Heights do not count.
  std::vector<navigation::Point> InTheWay(double ahead_m) const;
  // On the ground the height does not count.
  double Apart(const navigation::Point& a, const navigation::Point& b) const;
  // distance_to_goal, current_velocity and estimated_time.
  void AddDetails(skill::Tick& tick) const;

  // Forgets the plan and cancels the drive.
  void GiveUp();
  // After GiveUp(): brakes. True once the drive has ended and the robot stands.
  bool Stop(Duration step);
  // At once, at the end of a skill.
  void End();

 private:
  TravelStep PlanEnd(const navigation::Pose& goal);
  TravelStep DriveEnd();
  // What is left of the last path, from where the robot is.
  navigation::Path RemainingPath(const navigation::Pose& pose) const;

  Robot& robot_;
  skill::Future<navigation::Path> plan_;
  navigation::Path planned_;
  navigation::Path path_;  // that is driven
  std::unique_ptr<skills::Drive> drive_;
  std::unique_ptr<skills::Drive> given_up_;  // until its end
  Duration planner_missing_{};
  Duration drive_missing_{};  // the controller or the odometry
  Duration driven_{};
  Duration stopping_{};
  double length_m_ = 0;
};

}  // namespace musher::skills
