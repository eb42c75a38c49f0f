#include "musher/cli/commands/skill/skill_goal.hpp"

#include <fmt/format.h>

namespace musher::cli {
namespace {

// Also of a goal that was aborted because its skill did not begin: then it has no status.
SkillOutcome SkillOutcomeOf(transport::GoalEnd end, const std::string& status) {
  if (end == transport::GoalEnd::kCanceled || status == "cancelled") {
    return SkillOutcome::kCancelled;
  }
  return status.empty() ? SkillOutcome::kRefused : SkillOutcome::kFailed;
}

}  // namespace

std::optional<SkillOutcome> UnansweredOutcome(transport::GoalEnd end, bool accepted) {
  if (end == transport::GoalEnd::kRejected) return SkillOutcome::kRefused;
  if (end != transport::GoalEnd::kLost) return std::nullopt;
  return accepted ? SkillOutcome::kLost : SkillOutcome::kNoAnswer;
}

void FillSkillEnd(const transport::GoalOutcome<msg::SkillExecution>& of, bool accepted,
                  SkillEnd& end) {
  if (const auto unanswered = UnansweredOutcome(of.end, accepted)) {
    end.outcome = *unanswered;
    end.message = of.reason;
    return;
  }
  const SkillReport report = ReadSkillReport(of.result.message);
  end.message = report.message;
  if (!report.status.empty()) end.progress = report.progress;
  end.outcome = of.end == transport::GoalEnd::kSucceeded ? SkillOutcome::kCompleted
                                                         : SkillOutcomeOf(of.end, report.status);
}

std::string EndAfterTimeout(const SkillEnd& end) {
  const std::string text =
      fmt::format("{} after {:.1f} s", SkillOutcomeName(end.outcome), end.duration_s.value_or(0));
  const bool says_more = end.outcome != SkillOutcome::kCancelled && !end.message.empty();
  return says_more ? text + ": " + end.message : text;
}

ExitCode ExitCodeOf(SkillOutcome outcome, bool interrupted) {
  switch (outcome) {
    case SkillOutcome::kCompleted:
      return ExitCode::kDone;
    case SkillOutcome::kCancelled:
      return interrupted ? ExitCode::kInterrupted : ExitCode::kNotDone;
    case SkillOutcome::kLost:
      return ExitCode::kUnknownEnd;
    case SkillOutcome::kNoAnswer:
    case SkillOutcome::kTimeout:
      return ExitCode::kNoAnswer;
    case SkillOutcome::kRunning:
      return ExitCode::kInterrupted;
    default:
      return ExitCode::kNotDone;
  }
}

}  // namespace musher::cli
