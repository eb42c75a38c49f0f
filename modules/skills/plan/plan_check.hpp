#pragma once
// Whether a plan can be executed, before anything is started. Plain function, no IO.

#include <string>

#include "musher/base/result.hpp"
#include "musher/messages/plan_msgs/plan.hpp"

namespace musher::skills {

// "step 2 (timestep 5)"; steps are counted from 1.
std::string StepText(const msg::SkillPlan& plan, std::size_t index);

// Fails with all errors, a line each, each with its step and robot: a plan without steps, a step
// without robots, a robot that is in a step twice, one without exactly one skill, a name that no
// robot can have, two robots that go to one place: in one step, or to where the other still is.
Result<> CheckPlan(const msg::SkillPlan& plan);

}  // namespace musher::skills
