#pragma once
// The skills of an actuator as messages: what it offers, and the progress of a run. Plain
// functions, no IO; stamps are added by the caller.

#include <string>

#include "musher/behavior/skill/manager.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"

namespace musher {

// `action`: absolute, "/robot_0/skill_execution". Entries whose factory makes no skill are left
// out.
msg::SkillOffers OfferSkills(const std::string& actuator, const std::string& action,
                             const skill::Manager& manager);

// `goal_id`: empty when the run was not started by a goal.
msg::SkillFeedback ReportRun(const std::string& actuator, const skill::Run& run,
                             const std::string& goal_id);

// The reply of get_skill. `ticking`: skills are executed now. The reply has an `error` for an
// unknown skill, with the nearest, and for an unknown format of the picture.
msg::GetSkill::Response ReportSkill(const std::string& actuator, const skill::Manager& manager,
                                    bool ticking, const std::string& goal_id,
                                    const msg::GetSkill::Request& request);

}  // namespace musher
