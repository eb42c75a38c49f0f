#pragma once
// The base class of an application that offers skills (behavior/skill): an actuator that runs the
// requested skills while the robot is Active.
//
//   class Arm : public musher::SkillActuator {
//    public:
//     Arm() : SkillActuator("arm") {}
//
//    private:
//     Result<> RegisterSkills(skill::Registry& registry) override {
//       return registry.Add<Grasp>("grasp", gripper_);
//     }
//     void OpenTopics(transport::Endpoints& topics) override { ... of the gripper ... }
//
//     Gripper gripper_;
//   };
//
// clang-format off
//   robot          skills
//   SetUp          are registered; topics are opened
//   SelfCheck      SelfCheck() is called
//   Active         are started by goals, and stepped; paused ones continue
//   DeActive, Protected, LowPower, and states of the config
//                  are paused: their time stands still, a goal stays open, and feedback says
//                  "paused: …" (or, with Options::cancels_when_paused, cancelled at once)
//   OTA, Error, TearDown, an emergency stop
//                  are cancelled at once
// clang-format on
//
// Interfaces, in the namespace of the machine:
//
//   skill_execution        action plan_msgs/SkillExecution
//   skills                 musher_msgs/SkillOffers, latched: its skills with their parameters
//   skill_feedback         musher_msgs/SkillFeedback, at each change of a run, with or without goal
//   <actuator>/get_skill   service musher_msgs/GetSkill: a run's feedback, history, errors, picture
//   <actuator>/pause_skill service musher_msgs/PauseSkill: pauses and resumes one skill
//   <actuator>/cancel_skill service musher_msgs/CancelSkill: cancels one skill, also without goal
//
// A skill that is paused by that service stays paused in every state, also over a restart with
// `kContinued`, until it is resumed or cancelled; others may use its parts of the robot meanwhile.
// It is resumed in Active only, and refused, with the reason, when its parts are in use or its
// preconditions do not hold any more.
//
// Several skills may run at once, each at most once, unless they use the same part of the robot
// (skill::Table::Uses()). A goal has one skill with its parameters as
// texts ("[10, 20, 0]"); see skill::Parse(). One that cannot be started is aborted at once, with
// the reason in its result: an unknown skill, one that runs, one whose parts of the robot are in
// use, invalid parameters, a robot that is not Active. Feedback is "processing: Planning the path
// (15%)", at each change. A goal succeeds only when its skill has completed; cancelling the goal
// cancels the skill; a skill that is cancelled by anything else aborts its goal.
//
// With Options::after_restart the skills that run are in state_dir of the state config,
// <actuator>_skills.toml: the process after one that was killed reports them as failed, with the
// reason, or goes on with them, if they were saved less than a minute ago in the same boot.
//
// In a fault-injection test (simulation/actuator_fault_test.hpp) there is neither transport nor
// clock: skills are registered and cancelled, and not stepped.
//
// Threads: skills, hooks and handlers of topics run on the loop, one at a time. RegisterSkills()
// and SelfCheck() run on the actuator's worker. Times are the machine's, see [controller] clock.

#include <cstdint>
#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/behavior/skill/manager.hpp"

namespace musher {

class SkillActuator : public MachineActuator {
 public:
  struct Options {
    double rate_hz = 10;  // of ticks; more than 0
    bool cancels_when_paused = false;
    std::string action = "skill_execution";
    // Goals whose `robot_id` is another one, and not the actuator's name, are refused; empty: none.
    std::string robot{};
    // What becomes of the skills that ran when the process was killed. Those that go on do so in
    // Active, without a goal.
    enum class AfterRestart : std::uint8_t { kForgotten, kFailed, kContinued };
    AfterRestart after_restart = AfterRestart::kForgotten;
  };

  explicit SkillActuator(const std::string& actuator_name)
      : SkillActuator(actuator_name, Options{}) {}
  SkillActuator(const std::string& actuator_name, const Options& options);
  ~SkillActuator() override;

 protected:
  // In SetUp. A failure fails SetUp.
  virtual Result<> RegisterSkills(skill::Registry& registry) = 0;
  // After that, on the loop: topics and services. Not called in a fault-injection test.
  virtual void OpenTopics(transport::Endpoints& /*topics*/) {}
  // Whether its dependencies are available. May block.
  virtual Result<> SelfCheck() { return Ok(); }
  // Before and after each tick, which steps all skills. An exception cancels all skills at once.
  virtual void BeforeTick(Time /*now*/) {}
  virtual void AfterTick(Time /*now*/) {}
  // No skill is stepped from now on: the robot is not Active, or an emergency stop was engaged.
  // Skills are already paused or cancelled. Bring the outputs to neutral; must return at once and
  // be idempotent. An exception is logged, and shown in the status until a further pause succeeds.
  // With it, or with one of a skill's OnEnd(), an emergency stop is not confirmed.
  virtual void OnPause() {}

  // Cancels all skills at once, for example because the process ends: OnPause() is called, their
  // goals end, and the process after this one finds that none ran. On the loop only.
  void CancelSkills(const std::string& why);

  // The skills; available from SetUp on. On the loop only. Skills started here have no goal.
  skill::Manager& manager();
  // Whether skills are stepped now. On the loop only.
  bool ticking() const;
  // Why no skill can be started now: the state, or a stop that holds the actuator. On the loop
  // only.
  Result<> CheckTicking() const;
  // The same, or that a request which has just arrived may be old, because this process could not
  // run: for skills that a request of the application's own starts. On the loop only.
  Result<> CheckMayStart() const;
  // The time of the machine's clock. On the loop only.
  Time Now() const;

  void OnEmergencyStop() override;

 private:
  // Not available: a callback of a derived class would replace the one that runs the skills.
  using MachineActuator::RegisterStateCallback;

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher
