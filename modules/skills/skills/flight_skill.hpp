#pragma once
// What the skills of flyers have in common: only a robot that flies executes them; without odometry
// the flyer hovers, and the skill fails after 2 s; at every end, in a pause and at a cancellation
// the velocity command is zero, and a flyer in the air is held at its place
// (robot/flight_hold.hpp).
//
// A pose that jumps farther than a body can move, a height that has changed by more than kOffPlaceM
// while no odometry came, and a flyer that is more than kOffPlaceM beside its place, end the skill:
// where that place is now is not known, and it flies to none blindly. A skill that needs no place
// takes a new one.
//
// One that was in the air, and stands on the ground or is in a hand after a pause or a restart of
// the process, ends too, unless it lands: people do not expect it to fly off.
//
// Heights are absolute: metres above the zero of the map, never above the start.

#include <optional>
#include <string>

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/position_hold.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/navigation/gate/motion_guard.hpp"

namespace musher::skills {

// "1.0m", as in the messages of flights.
std::string HeightText(double height_m);

class FlightSkill : public skill::Skill {
 public:
  static constexpr double kOffPlaceM = 1.5;     // horizontally, or in height
  static constexpr double kStandsBelowM = 0.1;  // above the zero of the map

  explicit FlightSkill(Robot& robot);

  skill::Next Step(skill::Tick& tick) final;
  skill::Next Cancel(skill::Tick& tick) final;
  void OnEnd(const skill::Ended& ended) override;
  void OnPause() override;

 protected:
  // A step with odometry.
  virtual skill::Next Fly(const navigation::Pose& now, skill::Tick& tick) = 0;
  // False: one that is carried off goes on where it is then.
  virtual bool KeepsItsPlace() const { return true; }

  // Above the zero of the map: that of the robot, or the lower one of the parameter `ceiling`.
  double Ceiling(const skill::Tick& tick) const;

  // Sends the command that keeps the flyer at `place`, or brings it there.
  void Keep(const navigation::Pose& place, const navigation::Pose& now, const skill::Tick& tick);
  // The same for x, y and yaw, with this vertical velocity.
  void KeepWhile(double climb_mps, const navigation::Pose& place, const navigation::Pose& now,
                 const skill::Tick& tick);

  // The parameter `retries`: attempts after the first one.
  static void TakesRetries(skill::Table& table);
  // Another attempt from `state`; a failure once they are used up.
  static skill::Next AgainOrFail(const skill::Tick& tick, skill::StateId state, std::string why);

  const Robot& robot() const { return robot_; }
  void NoteLanding() { robot_.NoteLanding(); }
  void ExpectGround(double height_m) { robot_.ExpectGround(height_m); }
  // Why it has come no lower for so long, by what is below it; nullopt: it has, or is not held.
  static constexpr double kHeldS = 10;
  std::optional<std::string> HeldTooLong(const navigation::Pose& now, skill::Tick& tick,
                                         double limit_s = kHeldS) const;

  // A pose in the data of the skill, which is saved.
  static void Remember(const navigation::Pose& place, skill::Tick& tick);
  static navigation::Pose Remembered(const skill::Tick& tick);

 private:
  skill::Next WaitForOdometry(skill::Tick& tick);
  // That the pose cannot be believed, or that the flyer was carried away; nullopt: neither.
  // `was_blind`: the last step had no odometry.
  std::optional<std::string> WhyLost(const navigation::Pose& now, bool was_blind,
                                     skill::Tick& tick);
  // That it was put down or taken in a pause, or before this process; nullopt: it was not.
  std::optional<std::string> WhyTaken(const navigation::Pose& now, skill::Tick& tick) const;

  Robot& robot_;
  PositionHold hold_;
  navigation::MotionGuard guard_;
  std::optional<navigation::Pose> last_;  // since the begin or a pause
};

}  // namespace musher::skills
