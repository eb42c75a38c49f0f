// musher skill pause NAME, musher skill resume NAME: one skill stands still until it is resumed.

#include <CLI/CLI.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "musher/base/joined.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/machine/skill_request.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

struct SkillPauseOptions {
  std::string name;
  std::string actuator;  // empty: every one that runs the skill
};

// What an actuator that runs the skill has answered; nothing: it does not run it.
struct Asked {
  std::optional<SkillPaused> paused;
  std::optional<Failure> failure;  // it has not answered
};

Asked AskOne(Link& link, const GlobalOptions& global, const OfferedSkill& skill, bool pause) {
  Asked asked;
  const auto runs = QuerySkill(link, global, skill.actuator, {skill.offer.skill, ""});
  if (const auto* failure = std::get_if<Failure>(&runs)) {
    asked.failure = *failure;
    return asked;
  }
  const msg::SkillFeedback& feedback = std::get<msg::GetSkill::Response>(runs).feedback;
  if (!SkillRuns(feedback)) return asked;
  const auto answer = PauseSkill(link, global, skill.actuator, {skill.offer.skill, pause});
  if (const auto* failure = std::get_if<Failure>(&answer)) {
    asked.failure = *failure;
    return asked;
  }
  const auto& response = std::get<msg::PauseSkill::Response>(answer);
  asked.paused =
      SkillPaused{skill.offer.skill, skill.actuator, pause, response.success, response.message};
  return asked;
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
  const auto offers = SkillOffers::Begin(link, global);
  if (!offers) return console.Fail(offers.error());
  if (const auto failure = offers.value()->Await(options.actuator)) return console.Fail(*failure);
  const auto found = FindSkill(offers.value()->all(), options.name, options.actuator);
  if (!found) return console.Fail(Failure{ExitCode::kNotDone, found.error()});
  std::vector<SkillPaused> all;
  std::vector<std::string> actuators;
  std::optional<Failure> failure;
  for (const OfferedSkill& skill : found.value()) {
    actuators.push_back(skill.actuator);
    Asked asked = AskOne(link, global, skill, pause);
    if (asked.paused) all.push_back(*std::move(asked.paused));
    if (asked.failure) failure = std::move(asked.failure);
  }
  if (all.empty() && failure) return console.Fail(*failure);
  if (all.empty()) {
    return console.Fail(Failure{
        ExitCode::kNotDone,
        {kCodeStateInvalid, options.name + " is not running; offered by " + Joined(actuators)}});
  }
  const ExitCode exit = ReportPaused(all, console);
  if (failure) console.PrintError(failure->error.message);
  return failure ? failure->exit : exit;
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
