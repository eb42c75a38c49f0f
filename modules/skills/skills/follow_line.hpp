#pragma once
// Drives along the line that the robot sees. For robots on the ground.
//
//   speed      m/s, default 0.3; above 0, at most 1.0; slower beside the line and in bends
//   distance   m, then it succeeds; 0: until it is cancelled (default)
//
//   INITIALIZING   the line and the odometry are there within 2.0 s
//   EXECUTING      steers to the line, and along it
//   SEARCHING      8 s: the line is lost; the robot stands, and turns 60 degrees to where the
//                  line was, then to the other side; a line that is not found is a failure
//   STOPPING       at the end: until the robot stands
//
// It is never faster than it can brake before what its scan sees ahead, and stands before it; it
// goes on when the obstacle has left, and fails after 10 s without a free way. It fails 3 s after
// the last odometry; until then it stands. Details: offset (m, left positive), heading (rad),
// followed (m), free_ahead (m).

#include <optional>
#include <string>

#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {

class FollowLine : public TravelSkill {
 public:
  using TravelSkill::TravelSkill;

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;
  void OnPause() override;

 private:
  std::optional<std::string> WhyRefused(const skill::Values& parameters) const;
  skill::Next Execute(skill::Tick& tick);
  skill::Next Search(skill::Tick& tick);
  // The path since the last step, kept in the data of the run.
  double Followed(skill::Tick& tick);
  // The command, slowed down for what is ahead.
  navigation::Velocity BeforeObstacles(const navigation::Velocity& wanted,
                                       const navigation::Pose& pose, skill::Tick& tick);

  std::optional<navigation::Point> last_;
  double side_ = 1;  // where the line was seen last: 1 left, -1 right
  Duration blind_{};
  Duration blocked_{};
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
  skill::StateId searching_ = skill::kIdle;
};

}  // namespace musher::skills
