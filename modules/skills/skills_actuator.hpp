#pragma once
// The actuator of a robot's skills. See README.md in this folder.
//
// clang-format off
//   Active                                            goals start skills, stepped 10 times a second
//   DeActive, Protected, LowPower, own states         skills are paused, the robot stands
//   OTA, Error, TearDown, an emergency stop, SIGTERM  skills are cancelled, the robot stands
// clang-format on
//
// SelfCheck fails without odometry. What else cannot be reached makes it degraded. It also cancels
// the drives that a crashed process has left to the controller.
//
// With a low battery the skills that move the robot fail, before their first step as well; `land`
// goes on. A flyer lands in every state.
//
// Threads: those of SkillActuator.

#include <memory>
#include <string>
#include <vector>

#include "musher/actuator/program/end_signals.hpp"
#include "musher/application/skill_actuator.hpp"
#include "musher/modules/skills/nav2/nav2_goals.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"

namespace musher::skills {

class SkillsActuator : public SkillActuator {
 public:
  // `robot` must outlive it, and be what the entries were made with.
  SkillsActuator(const std::string& actuator_name, RosRobot& robot,
                 std::vector<skill::Entry> entries);

  // Before Init(): at SIGTERM and SIGINT the robot stands, then the process ends. They must outlive
  // it.
  void StandAt(const program::EndSignals& signals) { signals_ = &signals; }

 private:
  Result<> RegisterSkills(skill::Registry& registry) override;
  void OpenTopics(transport::Endpoints& topics) override;
  Result<> SelfCheck() override;
  void BeforeTick(Time now) override;
  void AfterTick(Time now) override;
  void OnPause() override;
  void EndMotions(const std::string& why);
  // Whether a goal of nav2 may begin, or go on to its next pose.
  Result<> CheckMayMove() const;

  RosRobot& robot_;
  const program::EndSignals* signals_ = nullptr;
  const std::vector<skill::Entry> entries_;
  std::weak_ptr<Nav2Goals> nav2_;  // kept by the endpoints
};

}  // namespace musher::skills
