#include "musher/modules/skills/plan/saved_goals.hpp"

#include <filesystem>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/transport/goal_id_text.hpp"

namespace musher::skills {
namespace {

SavedGoals::Goals ReadGoals(const config_toml::Table& table, config_toml::Findings& findings) {
  config_toml::TableReader root(table, {1, 1}, "", findings);
  SavedGoals::Goals goals;
  for (config_toml::TableReader& goal : root.Subs("goal")) {
    const auto robot = goal.String("robot");
    const auto text = goal.String("id");
    const auto id = text ? transport::ReadGoalId(text->text) : std::nullopt;
    // A cancellation without an id would cancel all goals of the robot.
    if (robot && config_toml::IsName(robot->text) && id && *id != transport::kNoGoalId) {
      goals[*id] = robot->text;
    } else {
      findings.Error(goal.at(), "goal: expected what Save() has written, a robot and an id");
    }
  }
  return goals;
}

std::string GoalsText(const SavedGoals::Goals& goals) {
  std::string text;
  for (const auto& [id, robot] : goals) {
    text += "[[goal]]\nrobot = \"" + robot + "\"\nid = \"" + transport::GoalIdText(id) + "\"\n";
  }
  return text;
}

}  // namespace

Result<SavedGoals::Goals> SavedGoals::Found() const {
  std::error_code none;
  if (file_.empty() || !std::filesystem::exists(file_, none)) return Goals();
  const Result<std::string> text = config_toml::ReadModuleText(file_);
  if (!text) return text.error();
  auto read = config_toml::ReadTextWith<Parsed<Goals>>(text.value(), file_, ReadGoals);
  if (read.config) return *std::move(read.config);
  return Error{kCodeFailed, FormatDiagnostic(read.diagnostics.front())};
}

Result<> SavedGoals::Save(const Goals& goals, Time now) {
  const bool again = failed() && now >= retry_at_;
  if (file_.empty() || (saved_ == goals && !again)) return Ok();
  saved_ = goals;
  if (goals.empty()) {
    on_disk_.Remove();  // one that stays names goals that have ended
    fault_.clear();
    return Ok();
  }
  const Result<> written = on_disk_.Replace(GoalsText(goals));
  const std::string fault = written ? "" : written.error().message;
  retry_at_ = now + kRetry;
  if (std::exchange(fault_, fault) == fault || written) return Ok();
  return Error{
      kCodeFailed,
      "the goals of the plan are not saved, and go on if this process is killed; it is tried "
      "again each second: " +
          fault};
}

}  // namespace musher::skills
