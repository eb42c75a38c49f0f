#pragma once
// The output of `musher skill plan`: text for people and a JSON document. Keys are a contract, as
// in json.hpp.

#include <optional>
#include <string>
#include <vector>

#include "musher/cli/render/skill.hpp"
#include "musher/messages/plan_msgs/plan.hpp"

namespace musher::cli {

// The last report of one robot in one step.
struct PlanMember {
  int step = 0;  // from 1
  std::string robot;
  std::string skill;
  std::string goal_id;  // 32 hexadecimal digits; empty: it was not sent
  SkillReport report;
};

// What was reported of a plan, in the order of steps and robots.
class PlanReport {
 public:
  explicit PlanReport(std::size_t steps) : steps_(steps) {}

  // Takes over a feedback; returns the members that have changed.
  std::vector<PlanMember> Take(const msg::PlanExecution::Feedback& feedback);

  // The plan has completed: a result may overtake the last feedback.
  void Complete();

  std::size_t steps() const { return steps_; }
  int step() const { return step_; }  // 0: none has begun
  const std::vector<PlanMember>& members() const { return members_; }
  // Present step: "jetbot_0 nav_2d 45 %, cf2x_0 take_off 30 %", and the progress of the
  // whole plan.
  SkillReport Summary() const;

 private:
  std::size_t steps_;
  int step_ = 0;
  std::vector<PlanMember> members_;
};

// How a plan ended.
struct PlanFinish {
  SkillOutcome outcome = SkillOutcome::kLost;
  std::string message;
  std::optional<double> duration_s;
  std::string goal_id;  // 32 hexadecimal digits
};

// "step 1 of 3  jetbot_0  nav_2d   45 %  Moving... (2.0s)"
std::string PlanMemberLine(const PlanMember& member, std::size_t steps);
// "the plan failed after 3.2 s: Execution failed in timestep 2. …"
std::string PlanFinishText(const PlanFinish& finish);
std::string PlanFinishJson(const PlanFinish& finish, const PlanReport& report);

}  // namespace musher::cli
