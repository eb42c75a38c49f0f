#pragma once
// The output of `musher skill`: text for people and JSON documents. Keys are a contract, as in
// json.hpp.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/cli/machine/skill_choice.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"

namespace musher::cli {

enum class SkillOutcome {
  kCompleted,
  kFailed,
  kCancelled,
  kRefused,   // it was not started
  kLost,      // its actuator is lost
  kNoAnswer,  // its actuator has not answered
  kTimeout,   // it has not ended within --timeout
  kRunning,   // it goes on
};
std::string SkillOutcomeWord(SkillOutcome outcome);       // "completed", ..., "no_answer": of JSON
std::string_view SkillOutcomeName(SkillOutcome outcome);  // "completed", ..., "no answer", ...
// "completed in 2.0 s", for a sentence about a run or a plan; without a duration "completed".
std::string SkillOutcomeText(SkillOutcome outcome, std::optional<double> duration_s);

// How a requested run of a skill ended.
struct SkillEnd {
  std::string skill;
  std::string actuator;
  SkillOutcome outcome = SkillOutcome::kLost;
  std::string message;
  int progress = 0;                  // the last one, in percent
  std::optional<double> duration_s;  // since its request; none: it is of another client
  std::string goal_id;               // 32 hexadecimal digits
};

// `whole`: with their parameters.
std::string SkillsText(const std::vector<msg::SkillOffers>& all, bool whole, bool colour);
std::string SkillsJson(const std::vector<msg::SkillOffers>& all);

// " 15 %  Planning the path"
std::string SkillReportLine(const SkillReport& report);
// "take_off  [####................]  20 %  Rising  3 s", shorter than 80 columns.
std::string SkillProgressText(const std::string& skill, const SkillReport& report,
                              std::int64_t seconds, bool colour);
// "take_off of cf2x_0 failed after 3.2 s: the battery is empty"
std::string SkillEndText(const SkillEnd& end);
std::string SkillEndJson(const SkillEnd& end);
std::string SkillCancelJson(const std::vector<SkillEnd>& ends);

// What an actuator has answered to `skill pause` or `skill resume`.
struct SkillPaused {
  std::string skill;
  std::string actuator;
  bool pause = true;  // false: it was to be resumed
  bool done = false;
  std::string message;  // the state of the skill; why not
};
// "navigate_to of jetbot_0 paused in EXECUTING", "navigate_to of jetbot_0 goes on from EXECUTING",
// "jetbot_0: pick_up cannot be paused: …"
std::string SkillPausedText(const SkillPaused& one);
std::string SkillPausedJson(const std::vector<SkillPaused>& all);

// A line of `skill watch`.
std::string SkillFeedbackLine(const msg::SkillFeedback& feedback, std::int64_t wall_ns,
                              bool colour);
std::string SkillFeedbackJson(const msg::SkillFeedback& feedback, std::int64_t wall_ns);

}  // namespace musher::cli
