// Random plans with random events: what always holds.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

#include "musher/modules/skills/plan/plan_check.hpp"
#include "musher/modules/skills/plan/plan_run.hpp"

namespace musher::skills::plan_property_test {

msg::SkillPlan RandomPlan() {
  msg::SkillPlan plan;
  const int steps = *rc::gen::inRange(1, 4);
  for (int i = 0; i < steps; ++i) {
    msg::TimestepSkills step{i, {}};
    const int robots = *rc::gen::inRange(1, 4);
    for (int r = 0; r < robots; ++r) {
      msg::SkillInfo skill;
      skill.skill = "wait";
      step.robots.push_back({"robot_" + std::to_string(r), {skill}});
    }
    plan.steps.push_back(step);
  }
  return plan;
}

// Executes a plan and checks each action. `open`: goals that were sent and have not ended.
class Execution {
 public:
  explicit Execution(const msg::SkillPlan& plan) : plan_(plan), run_(plan, {}, now_) {}

  bool ended() const { return end_.has_value(); }
  const std::optional<PlanEnd>& end() const { return end_; }

  void Advance() {
    const std::size_t before = run_.step();
    const PlanActions actions = run_.Advance(now_, [this](const std::string&) { return there_; });
    RC_ASSERT(run_.step() == before || (run_.step() == before + 1 && open_.empty()));
    for (const std::size_t robot : actions.send) {
      RC_ASSERT(!failed_ && !cancelled_);
      RC_ASSERT(robot < run_.present().robots.size());
      RC_ASSERT(open_.insert(robot).second);
    }
    for (const std::size_t robot : actions.cancel) {
      RC_ASSERT(failed_ || cancelled_);
      RC_ASSERT(open_.contains(robot));
      RC_ASSERT(cancelled_robots_.insert(robot).second);
    }
    if (!actions.end) return;
    end_ = actions.end;
    const bool late = end_->message.find("not ended") != std::string::npos;
    RC_ASSERT(open_.empty() || late);
    if (late) RC_ASSERT(cancelled_robots_ == open_);
    const bool succeeded = end_->outcome == PlanOutcome::kSucceeded;
    const bool missing = end_->message.find("no action server") != std::string::npos;
    RC_ASSERT(!missing || missing_);
    RC_ASSERT(succeeded == (!failed_ && !cancelled_ && !missing));
    if (succeeded) RC_ASSERT(run_.step() + 1 == plan_.steps.size());
  }

  void Event() {
    switch (*rc::gen::inRange(0, 6)) {
      case 0:
        now_ += Milliseconds(*rc::gen::inRange(0, 4000));
        missing_ = missing_ || !there_;
        break;
      case 1:
        there_ = !there_;
        break;
      case 2:
      case 3:
        EndOne(true);
        break;
      case 4:
        EndOne(*rc::gen::inRange(0, 3) > 0);
        break;
      default:
        if (*rc::gen::inRange(0, 6) == 0) {
          cancelled_ = true;
          run_.Cancel("a test", true);
        }
    }
    Advance();
  }
  void LetTimePass() {
    there_ = false;
    missing_ = true;
    now_ += std::chrono::seconds(20);
    Advance();
    // Robots that run for ever: only a cancellation ends them.
    if (!ended()) {
      cancelled_ = true;
      run_.Cancel("a test", true);
      Advance();
      now_ += std::chrono::seconds(20);
      if (!ended()) Advance();
    }
  }

 private:
  void EndOne(bool success) {
    if (open_.empty()) return;
    const std::size_t robot = *open_.begin();
    open_.erase(open_.begin());
    cancelled_robots_.erase(robot);
    failed_ = failed_ || !success;
    run_.OnEnd(robot, success, "its end");
  }

  const msg::SkillPlan plan_;
  Time now_{};
  PlanRun run_;
  bool there_ = true;
  bool failed_ = false;
  bool cancelled_ = false;
  bool missing_ = false;  // perhaps: its servers were waited for
  std::set<std::size_t> open_;
  std::set<std::size_t> cancelled_robots_;  // those of them that are cancelled
  std::optional<PlanEnd> end_;
};

RC_GTEST_PROP(PlanProperty, EveryPlanEndsOnceWithoutAGoalThatRunsOn, ()) {
  const msg::SkillPlan plan = RandomPlan();
  RC_ASSERT(CheckPlan(plan).ok());
  Execution execution(plan);
  execution.Advance();
  for (int i = 0; i < 40 && !execution.ended(); ++i) execution.Event();
  if (!execution.ended()) execution.LetTimePass();
  RC_ASSERT(execution.ended());
}

}  // namespace musher::skills::plan_property_test
