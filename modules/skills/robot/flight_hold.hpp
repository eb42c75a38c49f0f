#pragma once
// Keeps a flyer at its place while no skill and no drive moves it: after each end of a skill, in a
// pause and at a stop. A velocity of 0 does not: the wind carries it away. With a low battery it
// descends there instead, until it stands on the ground, also where no skill has moved it and it is
// found in the air: an empty one falls. Where it comes no lower far above the ground, on a roof or
// in an updraught, the descent goes on slowly until it is charged.
//
// Above something that its sensor below sees it goes aside, to the nearest free place within
// kMostAsideM, and to its own place again, but only where its scan covers the way: without a scan
// it is held there, and lands once that has gone.
//
//   not needed ── used, low ──▶ armed ── not used, in the air, braked ──▶ holding, or descending
//        ▲                                                             │
//        └── landed, seen on the ground, or moved against its commands ◀───┘
//
// What is moved against its commands is in a hand, or has been put down: it is never held again,
// and so climbs nowhere, until a skill, a drive or another program moves it. That is one that comes
// kSunkM lower than its place, that is carried kLostM away, or that stands off its place while it
// is commanded back. With a low battery it descends also then: it only goes down.
//
// A pose that jumps farther than a body moves is a correction of the localisation: the place jumps
// with it, so the flyer stays where it is.
//
// Another program that commands it has it until kOtherEnds after its last command. One that it has
// moved is then held where it is. If that command led down it may have landed, on a table for
// example: then only one that drifts aside within kMayStand is held; one that stands, or comes up,
// as in a hand, has landed.
//
// Metres; the frame of the odometry, with its zero on the ground. Pure; one thread.

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/time.hpp"
#include "musher/modules/skills/robot/position_hold.hpp"

namespace musher::skills {

// Another program that commands a flyer, or has just done so.
struct OtherProgram {
  navigation::Velocity command;  // its last one, in the frame of the body
  Duration silent{};             // since then
  std::optional<navigation::Point> was_at;
  double followed_m = 0;                     // by the flyer, in the direction of its commands
  bool flies = false;                        // it has done so in the air
  std::optional<navigation::Point> left_at;  // once it was silent
  Duration stood{};                          // since then
};

class FlightHold {
 public:
  static constexpr double kInTheAirM = 0.05;  // above the zero of the frame; a lower one stands
  static constexpr double kLostM = 1.5;       // off its place
  static constexpr double kSunkM = 0.2;       // below its place
  static constexpr double kMovedOnM = 3;      // without commands, while its process starts again
  static constexpr Duration kOtherEnds = std::chrono::seconds(1);
  static constexpr Duration kMayStand = std::chrono::seconds(5);
  static constexpr double kDescentMps = 0.5;
  static constexpr double kMostAsideM = 2.1;      // to land with a low battery
  static constexpr double kLastDescentMps = 0.2;  // near the ground, and without a height

  // Says whether a recent scan covers the way to a place, in the frame of the odometry. Without it
  // none does.
  void SetSight(std::function<bool(const navigation::Point& place)> covers) {
    covers_ = std::move(covers);
  }

  // A skill or a drive moves it.
  void Use();
  // The process before has had it in the air at this place a moment ago: it is used if its next
  // pose is in the air within kMovedOnM.
  void Restore(const navigation::Point& place) { restored_ = place; }
  // It stands on the ground: it is not held there.
  void Land();
  // Another program has commanded it so, in the frame of the body. With a low battery it still
  // descends.
  void NoteOther(const navigation::Velocity& command);
  // From now on it descends, or no more; a repetition changes nothing.
  void SetBatteryLow(bool low);
  // Its battery is charged: one that stands high is not held there.
  void NoteCharging();
  // The last command did not reach the body, so that it does not move shows nothing.
  void NoteStopped();
  // The last command led down, and was held by what is below.
  void NoteHeldDescent() { descent_held_ = true; }
  // It descends and comes no lower, far above the ground.
  bool StandsHigh() const;
  // Why it is no longer held since Use(): "it came 0.21 m lower …". Empty: it is held, or landed.
  const std::string& ended() const { return ended_; }
  // It is held, or will be once no skill and no drive moves it.
  bool armed() const { return armed_; }
  // Another program has it, and has not put it down.
  bool of_other() const { return other_.has_value(); }

  // The command, in the frame of the body, `step` after the last one; nullopt: none is needed.
  // Without a pose it is 0, and with a low battery down, unless it stood on the ground.
  // `speed_m_s`: of the body.
  std::optional<navigation::Velocity> Command(const std::optional<navigation::Pose>& pose,
                                              double speed_m_s, Duration step);

 private:
  void FollowJump(const navigation::Pose& pose, Duration step);
  std::optional<navigation::Velocity> Descend(const navigation::Pose& pose, Duration step);
  // The command to another place, if its own is taken; nullopt: it descends where it is.
  std::optional<navigation::Velocity> GoAside(const navigation::Pose& pose, Duration step);
  bool Sees(const navigation::Point& place) const { return covers_ && covers_(place); }
  std::optional<navigation::Point> NextPlace();
  // Why a body at `pose` is moved by something else than its commands; empty: it is not.
  std::string MovedAgainstCommands(const navigation::Pose& pose, Duration step);
  void End(std::string why);
  // `pose`: null where it is not known.
  void WatchOther(const navigation::Pose* pose, Duration step);
  void NoteFollowed(const navigation::Pose& pose);
  void AfterOther(const navigation::Pose* pose, Duration step);

  PositionHold hold_;
  std::function<bool(const navigation::Point& place)> covers_;
  std::optional<OtherProgram> other_;
  std::optional<navigation::Point> restored_;  // until the first pose
  bool armed_ = false;
  bool landed_ = false;  // and no skill or drive has moved it since then
  bool low_ = false;
  bool arms_ = false;  // if the next pose is in the air
  Duration braking_{};
  Duration still_{};  // how long it has not come lower
  double lowest_m_ = 0;
  bool descent_held_ = false;               // since the last command
  Duration held_{};                         // for so long
  std::optional<navigation::Point> taken_;  // the place around which it looks for another one
  int tried_ = 0;                           // places around it
  std::optional<navigation::Point> aside_;  // where it goes now
  navigation::Point aside_from_;
  bool stopped_ = false;  // the last command has not reached the body
  Duration going_{};      // for so long
  std::optional<navigation::Pose> place_;
  std::optional<navigation::Pose> last_;  // of the last Command()
  Duration same_{};                       // so long that one has not changed
  navigation::Point unmoved_at_;          // off its place it has not left here
  Duration unmoved_{};                    // for so long
  std::string ended_;
};

}  // namespace musher::skills
