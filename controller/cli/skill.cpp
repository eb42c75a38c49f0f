// musher skill, and musher skill list: the skills of the running robot.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/render/skill.hpp"
#include "musher/controller/cli/skill_commands.hpp"
#include "musher/controller/cli/skill_offers.hpp"

namespace musher::cli {
namespace {

struct SkillListOptions {
  std::string actuator;  // empty: all
};

ExitCode SkillList(const SkillListOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return console.Fail(offers.error());
  if (const auto failure = offers.value()->Await(options.actuator)) return console.Fail(*failure);
  std::vector<msg::SkillOffers> all = offers.value()->all();
  std::erase_if(all, [&options](const msg::SkillOffers& of) {
    return !options.actuator.empty() && of.actuator != options.actuator;
  });
  console.Print(console.mode().json ? SkillsJson(all) : SkillsText(all, console.mode().colour));
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
  AddSkillActuator(grammar, app, options.actuator);
}

void AddSkill(Grammar& grammar) {
  CLI::App& family = grammar.AddFamily("skill", "List, run, cancel and watch the robot's skills");
  AddSkillList(grammar, family);
  AddSkillRun(grammar, family);
  AddSkillCancel(grammar, family);
  AddSkillWatch(grammar, family);
}

}  // namespace musher::cli
