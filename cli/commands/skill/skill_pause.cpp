// musher skill pause NAME, musher skill resume NAME: one skill stands still until it is resumed.

#include <CLI/CLI.hpp>
#include <vector>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/commands/skill/skill_runs.hpp"
#include "musher/cli/machine/skill_request.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

struct SkillPauseOptions {
  std::string name;
  std::string actuator;  // empty: every one that runs the skill
};

AskedRun AskOne(Link& link, const GlobalOptions& global, const OfferedSkill& skill, bool pause,
                std::vector<SkillPaused>& all) {
  const auto runs = QuerySkill(link, global, skill.actuator, {skill.offer.skill, ""});
  if (const auto* failure = std::get_if<Failure>(&runs)) return *failure;
  if (!SkillRuns(std::get<msg::GetSkill::Response>(runs).feedback)) return false;
  const auto answer = PauseSkill(link, global, skill.actuator, {skill.offer.skill, pause});
  if (const auto* failure = std::get_if<Failure>(&answer)) return *failure;
  const auto& response = std::get<msg::PauseSkill::Response>(answer);
  all.push_back({skill.offer.skill, skill.actuator, pause, response.success, response.message});
  return true;
}

ExitCode ReportPaused(const std::vector<SkillPaused>& all, Console& console) {
  ExitCode exit = ExitCode::kDone;
  for (const SkillPaused& one : all) {
    if (!one.done) {
      exit = ExitCode::kNotDone;
      console.PrintError(SkillPausedText(one));
    } else if (!console.mode().json) {
      console.Print(SkillPausedText(one));
    }
  }
  if (console.mode().json) console.Print(SkillPausedJson(all));
  return exit;
}

ExitCode PauseOrResume(const SkillPauseOptions& options, const GlobalOptions& global, bool pause,
                       Console& console) {
  const auto opened = Link::Open(global);
  if (!opened) return console.Fail(opened.error());
  Link& link = *opened.value();
  std::vector<SkillPaused> all;
  const AskedRuns asked =
      AskRunsOf(link, global, options.name, options.actuator,
                [&](const OfferedSkill& skill) { return AskOne(link, global, skill, pause, all); });
  if (!asked.any) return console.Fail(*asked.failure);
  const ExitCode exit = ReportPaused(all, console);
  if (asked.failure) console.PrintError(asked.failure->error.message);
  return asked.failure ? asked.failure->exit : exit;
}

ExitCode PauseOfSkill(const SkillPauseOptions& options, const GlobalOptions& global,
                      Console& console) {
  return PauseOrResume(options, global, true, console);
}

ExitCode ResumeOfSkill(const SkillPauseOptions& options, const GlobalOptions& global,
                       Console& console) {
  return PauseOrResume(options, global, false, console);
}

}  // namespace

void AddSkillPause(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("pause", "Pause one running skill until it is resumed", PauseOfSkill, &family);
  AddSkillName(grammar, app, options.name, "The skill, of every actuator that runs it").required();
  AddSkillActuator(grammar, app, options.actuator);
}

void AddSkillResume(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add("resume", "Let a paused skill go on", ResumeOfSkill, &family);
  AddSkillName(grammar, app, options.name, "The skill, of every actuator that runs it").required();
  AddSkillActuator(grammar, app, options.actuator);
}

}  // namespace musher::cli
