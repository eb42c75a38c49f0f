#pragma once
// Queries a skill of an actuator by its service `<actuator>/get_skill`, and pauses and resumes it
// by
// `<actuator>/pause_skill`.

#include <string>
#include <variant>

#include "musher/cli/machine/link.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"

namespace musher::cli {

using SkillAnswer = std::variant<msg::GetSkill::Response, Failure>;

// The actuator offers the skill. The Failure says that it does not answer, or what it refuses.
SkillAnswer QuerySkill(Link& link, const GlobalOptions& global, const std::string& actuator,
                       const msg::GetSkill::Request& request);

// Whether a run has begun and has not ended.
bool SkillRuns(const msg::SkillFeedback& feedback);

// Pauses a skill, or resumes it. The Failure says that the actuator does not answer.
using PauseAnswer = std::variant<msg::PauseSkill::Response, Failure>;
PauseAnswer PauseSkill(Link& link, const GlobalOptions& global, const std::string& actuator,
                       const msg::PauseSkill::Request& request);

}  // namespace musher::cli
