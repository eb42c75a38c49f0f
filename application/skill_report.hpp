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

// The last of the details are `paused`, of a run that is paused by a request, and `requested_by`,
// if it is known.
msg::SkillFeedback ReportRun(const std::string& actuator, const skill::Run& run);

// The reply of get_skill. `ticking`: skills are executed now. The reply has an `error` for an
// unknown skill, with the nearest, and for an unknown format of the picture.
msg::GetSkill::Response ReportSkill(const std::string& actuator, const skill::Manager& manager,
                                    bool ticking, const msg::GetSkill::Request& request);

}  // namespace musher
