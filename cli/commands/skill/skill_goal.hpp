#pragma once
// A goal of the action by which skills are requested.

#include <optional>
#include <string>
#include <string_view>

#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/render/skill.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/goal_id_text.hpp"

namespace musher::cli {

using transport::GoalIdText;
using transport::ReadGoalId;

// Sets outcome, message and progress from the end of a goal, which its actuator has accepted or
// not.
void FillSkillEnd(const transport::GoalOutcome<msg::SkillExecution>& of, bool accepted,
                  SkillEnd& end);

// Outcome of a goal that was rejected, or whose server is lost; nullopt: its server has a result.
std::optional<SkillOutcome> UnansweredOutcome(transport::GoalEnd end, bool accepted);

// The end of a goal that --timeout has cancelled: "cancelled after 3.2 s", "failed after 3.2 s: the
// battery is empty".
std::string EndAfterTimeout(const SkillEnd& end);

// `interrupted`: by Ctrl-C.
ExitCode ExitCodeOf(SkillOutcome outcome, bool interrupted);

}  // namespace musher::cli
