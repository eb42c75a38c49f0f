#pragma once
// Queries a skill of an actuator by its service `<actuator>/get_skill`.

#include <string>
#include <variant>

#include "musher/cli/machine/link.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"

namespace musher::cli {

using SkillAnswer = std::variant<msg::GetSkill::Response, Failure>;

// The actuator offers the skill. The Failure says that it does not answer, or what it refuses.
SkillAnswer QuerySkill(Link& link, const GlobalOptions& global, const std::string& actuator,
                       const msg::GetSkill::Request& request);

}  // namespace musher::cli
