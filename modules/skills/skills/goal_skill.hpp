#pragma once
// What navigate_to and move have in common: the robot travels to a goal, and perhaps to another
// one after it.
//
//   INITIALIZING  the request is checked, planner and controller are reachable; a flyer is in the
//                 air
//   PLANNING      15 s
//   RECOVERING    the robot has no room where it stands, or there is no path: one recovery of the
//                 parameter `recoveries` that may help after the other, and another plan after
//                 each; once all are used up, it fails. And at an obstacle that stays; see below
//   EXECUTING     120 s from a plan to its goal; an obstacle leads back to PLANNING, not counted
//   GIVING_WAY    another robot comes the other way and goes first (give_way.hpp): then PLANNING,
//                 not counted; 120 s
//   STOPPING      of a cancellation: until the robot stands
//
// An obstacle that stays: the path is planned again, which leads around it if it can. Once the
// robot has stood there for `blocked_after`, and then each `blocked_again`, it does the next one of
// `at_obstacle`, in turn, that is among `recoveries`; back_up only if what is nearest is ahead: a
// person who yields to it in a door gets room. Who has come into its way in the last seconds, and
// is no robot that says where it drives, it lets pass before it plans again: a path around someone
// who walks on is wrong before it has turned onto it. It stands on its path and drives on once that
// is free; where they stand before each other it backs up first. That ends after kLetPass at a
// stand. Unless `at_obstacle` has clear it does not forget what it has seen: it would drive into
// the same trap again. It fails once it has stood at obstacles for `blocked_limit` without having
// come nearer to the goal.
//
// A planner, a controller or a map that is late, or is lost on the way: INITIALIZING again, up to
// `lost_limit` (travel_skill.hpp). A pause cancels the drive; then the path is planned again.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/skills/skills/give_way.hpp"
#include "musher/modules/skills/skills/mover_watch.hpp"
#include "musher/modules/skills/skills/recovery.hpp"
#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {

// The defaults of `blocked_limit`, `blocked_after` and `blocked_again`.
inline constexpr Duration kBlockedLimit = std::chrono::seconds(60);
inline constexpr Duration kBlockedRecovery = std::chrono::seconds(8);
inline constexpr Duration kBlockedAgain = std::chrono::seconds(4);
inline constexpr Duration kLetPass = std::chrono::seconds(20);

class GoalSkill : public TravelSkill {
 public:
  explicit GoalSkill(Robot& robot)
      : TravelSkill(robot), recovery_(robot), give_way_(robot, travel_) {}

  void Declare(skill::Table& table) final;
  skill::Next Step(skill::Tick& tick) final;
  skill::Next OnLimit(skill::Tick& tick) final;

 protected:
  virtual void Describe(skill::Table& table) = 0;
  // Checks the request, and takes what it needs of it. Before the first step.
  virtual Result<> Take(const skill::Tick& tick) = 0;
  virtual navigation::Pose Goal(const skill::Tick& tick) const = 0;
  // Where the first path begins; nullopt: where the robot is.
  virtual std::optional<navigation::Pose> Start() const { return std::nullopt; }
  // Nullopt: there is another goal; else the message of the success.
  virtual std::optional<std::string> OnArrival(skill::Tick& tick) = 0;
  // Stands before messages: "Waypoint 2 of 4: ".
  virtual std::string Prefix(const skill::Tick& /*tick*/) const { return {}; }
  // The share of the whole, where `share` of the path to this goal is done. May add details.
  virtual double Share(skill::Tick& /*tick*/, double share) const { return share; }

  Robot& robot() { return robot_; }
  const Robot& robot() const { return robot_; }

 private:
  Result<> TakeRecoveries(const skill::Values& parameters);
  skill::Next Initialize(skill::Tick& tick);
  skill::Next Plan(skill::Tick& tick);
  skill::Next Recover(skill::Tick& tick);
  // Begins the next recovery that may help; fails where there is none.
  skill::Next AfterTrouble(skill::Tick& tick, Trouble trouble, const std::string& why);
  skill::Next Execute(skill::Tick& tick);
  skill::Next LetPass(skill::Tick& tick);
  skill::Next Decide(skill::Tick& tick, const TravelStep& step);
  skill::Next AfterBlocked(const skill::Tick& tick, const TravelStep& step);
  // That is due now at an obstacle that stays.
  std::optional<RecoveryKind> DueRecovery() const;
  skill::Next BeginRecovery(RecoveryKind kind, Trouble trouble, const std::string& why);
  // Whether who has come lately stands in its way, and is no robot that it knows.
  bool IsMoverInTheWay() const;
  bool IsFaceToFace() const;
  // Lets pass who is in its way.
  skill::Next LetMoverPass(const std::string& why);
  void NoteBlockedTime(const skill::Tick& tick);

  // From the first obstacle on the way to a goal.
  struct Blocked {
    double nearest_m = 0;  // to the goal, so far
    Duration stood{};      // since it came nearer
    int recoveries = 0;    // done since then
    Standstill standstill{};
  };

  Recovery recovery_;
  GiveWay give_way_;
  std::vector<RecoveryKind> recoveries_;
  std::vector<RecoveryKind> at_obstacle_;
  Duration blocked_limit_ = kBlockedLimit;
  Duration blocked_after_ = kBlockedRecovery;
  Duration blocked_again_ = kBlockedAgain;
  Trouble trouble_ = Trouble::kTightStart;   // for which it recovers
  std::optional<RecoveryKind> recovers_by_;  // nothing in RECOVERING: the run was restored
  bool taken_ = false;
  bool started_ = false;  // the first path is there: Start() does not count any more
  std::optional<Blocked> blocked_;
  MoverWatch movers_;
  skill::StateId planning_ = skill::kIdle;
  skill::StateId recovering_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
  skill::StateId giving_way_ = skill::kIdle;
};

}  // namespace musher::skills
