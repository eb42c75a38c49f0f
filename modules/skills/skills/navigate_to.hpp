#pragma once
// Drives or flies to a place: navigate_to, and nav_2d for robots on the ground, nav_3d for flyers.
//
//   goal_pos          m, x y z in the map; on the ground z is not used and may be left out
//   goal_quat_wxyz    the direction at the goal, default [1, 0, 0, 0]; of any length above 0
//   start_pos         m, where the path begins; default: where the robot is
//   start_quat        the direction there; default: as the robot looks
//   ground_height     m, the height of the goal on the ground, default 0 (not of nav_3d)
//
// States, limits and faults: goal_skill.hpp. A failed plan or drive is a failure. Details:
// distance_to_goal (m), current_velocity (m/s), estimated_time (s).

#include "musher/modules/skills/skills/goal_skill.hpp"

namespace musher::skills {

class NavigateTo : public GoalSkill {
 public:
  // Of which robots: kBoth by its kind.
  enum class For : std::uint8_t { kBoth, kGround, kAir };

  explicit NavigateTo(Robot& robot, For robots = For::kBoth) : GoalSkill(robot), for_(robots) {}

 private:
  void Describe(skill::Table& table) override;
  Result<> Take(const skill::Tick& tick) override;
  navigation::Pose Goal(const skill::Tick& /*tick*/) const override { return goal_; }
  std::optional<navigation::Pose> Start() const override { return start_; }
  std::optional<std::string> OnArrival(skill::Tick& tick) override;

  Result<navigation::Point> PlaceOf(const skill::Values& parameters, const std::string& name) const;

  const For for_;
  navigation::Pose goal_;
  std::optional<navigation::Pose> start_;
};

}  // namespace musher::skills
