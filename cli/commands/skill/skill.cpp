// musher skill, and musher skill list: the skills of the running robot.

#include <CLI/CLI.hpp>
#include <vector>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

struct SkillListOptions {
  std::string name;      // empty: all, without their parameters
  std::string actuator;  // empty: all
};

Result<std::vector<msg::SkillOffers>> Chosen(const std::vector<msg::SkillOffers>& all,
                                             const SkillListOptions& options) {
  std::vector<msg::SkillOffers> chosen = all;
  if (!options.name.empty()) {
    const auto found = FindSkill(all, options.name, options.actuator);
    if (!found) return found.error();
  }
  std::erase_if(chosen, [&options](msg::SkillOffers& of) {
    if (!options.name.empty()) {
      std::erase_if(of.skills, [&](const auto& offer) { return offer.skill != options.name; });
    }
    const bool other = !options.actuator.empty() && of.actuator != options.actuator;
    return other || of.skills.empty();
  });
  return chosen;
}

ExitCode SkillList(const SkillListOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return console.Fail(offers.error());
  if (const auto failure = offers.value()->Await(options.actuator)) return console.Fail(*failure);
  const auto chosen = Chosen(offers.value()->all(), options);
  if (!chosen) return console.Fail(Failure{ExitCode::kNotDone, chosen.error()});
  const bool whole = !options.name.empty();
  console.Print(console.mode().json ? SkillsJson(chosen.value())
                                    : SkillsText(chosen.value(), whole, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace

CLI::Option& AddSkillName(Grammar& grammar, CLI::App& app, std::string& name,
                          const std::string& what) {
  return *grammar.Offer(app.add_option("NAME", name, what), Names::kSkills)->type_name("");
}

void AddSkillActuator(Grammar& grammar, CLI::App& app, std::string& actuator) {
  grammar
      .Offer(app.add_option("--actuator", actuator, "Only of this actuator"),
             Names::kSkillActuators)
      ->type_name("NAME");
}

void AddSkillList(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("list", "List the skills that the actuators offer", SkillList, &family);
  AddSkillName(grammar, app, options.name, "The skill: its parameters, too");
  AddSkillActuator(grammar, app, options.actuator);
}

void AddSkill(Grammar& grammar) {
  CLI::App& family =
      grammar.AddFamily("skill", "List, run, pause, cancel and watch the robot's skills",
                        "musher skill run take_off altitude=2");
  AddSkillList(grammar, family);
  AddSkillRun(grammar, family);
  AddSkillPlan(grammar, family);
  AddSkillCancel(grammar, family);
  AddSkillPause(grammar, family);
  AddSkillResume(grammar, family);
  AddSkillWatch(grammar, family);
}

}  // namespace musher::cli
