// musher skill watch [NAME]: shows what the skills report, live.

#include <CLI/CLI.hpp>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

struct SkillWatchOptions {
  std::string name;      // empty: all skills
  std::string actuator;  // empty: of all actuators
};

ExitCode WatchSkills(const SkillWatchOptions& options, const GlobalOptions& global,
                     Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto on_lost = [&](const std::string& actuator) {
    if (!options.actuator.empty() && options.actuator != actuator) return;
    const Failure lost{ExitCode::kNoController, {kCodeNetError, actuator + " is lost"}};
    console.Print(console.mode().json ? FailureJson(lost)
                                      : LocalTime(WallNow()) + "  " + lost.error.message);
  };
  const auto offers = SkillOffers::Begin(*link.value(), global, on_lost);
  if (!offers) return console.Fail(offers.error());
  if (const auto failure = offers.value()->Await(options.actuator)) return console.Fail(*failure);
  if (!options.name.empty()) {
    const auto found = FindSkill(offers.value()->all(), options.name, options.actuator);
    if (!found) return console.Fail(Failure{ExitCode::kNotDone, found.error()});
  }
  const auto feedback = transport::MakeSubscription<msg::SkillFeedback>(
      link.value()->node(), transport::ResolveName(global.name_space, "skill_feedback"),
      [&](const msg::SkillFeedback& of, const transport::SampleInfo&) {
        const bool wanted = (options.name.empty() || options.name == of.skill) &&
                            (options.actuator.empty() || options.actuator == of.actuator);
        if (!wanted) return;
        console.Print(console.mode().json
                          ? SkillFeedbackJson(of, WallNow())
                          : SkillFeedbackLine(of, WallNow(), console.mode().colour));
      });
  if (!feedback) return console.Fail(feedback.error());
  link.value()->EndWithReader();
  link.value()->RunUntilInterrupted(console);
  return ExitCode::kDone;
}

}  // namespace

void AddSkillWatch(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add(
      "watch", "Show every change of the running skills, until Ctrl-C", WatchSkills, &family);
  AddSkillName(grammar, app, options.name, "Only this skill");
  AddSkillActuator(grammar, app, options.actuator);
}

}  // namespace musher::cli
