// musher skill run NAME KEY=VALUE...: requests a run of a skill, shows its progress and waits for
// its end.

#include <CLI/CLI.hpp>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/commands/skill/skill_goal.hpp"
#include "musher/cli/commands/skill/skill_progress.hpp"
#include "musher/cli/machine/goal_run.hpp"
#include "musher/cli/machine/meant_actuator.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

struct SkillRunOptions {
  std::string name;
  std::vector<std::string> parameters;  // "altitude=2"
  std::string actuator;                 // empty: the only one that offers the skill
};

class SkillRun {
 public:
  SkillRun(Link& link, const GlobalOptions& global, const OfferedSkill& skill, Console& console)
      : global_(global),
        skill_(skill),
        progress_(link.loop(), skill.offer.skill, console),
        goal_(link, global, console, {skill.offer.skill, skill.actuator},
              [this] { progress_.Clear(); }) {}

  Result<> Begin(const std::vector<msg::SkillParameter>& parameters) {
    if (auto opened = goal_.Open(skill_.action); !opened) return opened;
    msg::SkillExecution::Goal goal;
    goal.skill_request.robot_id = skill_.actuator;
    goal.skill_request.skill_list.resize(1);
    goal.skill_request.skill_list[0].skill = skill_.offer.skill;
    goal.skill_request.skill_list[0].params = parameters;
    goal_.Send(goal, [this](const msg::SkillExecution::Feedback& feedback) {
      report_ = ReadSkillReport(feedback.status);
      progress_.Show(report_);
    });
    return Ok();
  }

  SkillEnd Wait() {
    goal_.Wait();
    SkillEnd end{skill_.offer.skill,     skill_.actuator,
                 SkillOutcome::kRunning, "",
                 report_.progress,       ToSeconds(progress_.elapsed()),
                 GoalIdText(goal_.id())};
    if (goal_.end()) {
      FillSkillEnd(*goal_.end(), goal_.accepted(), end);
    } else {
      end.message = "its cancellation was requested; `musher skill cancel " + end.skill +
                    "` requests it again";
    }
    if (!goal_.timed_out() || end.outcome == SkillOutcome::kCompleted) return end;
    end.message = goal_.end() ? EndAfterTimeout(end) : end.message;
    end.outcome = SkillOutcome::kTimeout;
    end.duration_s = ToSeconds(*global_.timeout);
    return end;
  }

  bool interrupted() const { return goal_.interrupted(); }

 private:
  const GlobalOptions& global_;
  const OfferedSkill& skill_;
  SkillProgress progress_;
  SkillReport report_;
  GoalRun<msg::SkillExecution> goal_;  // last: its callbacks use all above
};

ExitCode RunSkill(const SkillRunOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return console.Fail(offers.error());
  const auto meant = MeantActuator::Begin(*link.value(), global);
  if (!meant) return console.Fail(meant.error());
  if (const auto failure = offers.value()->Await(options.actuator)) return console.Fail(*failure);
  std::vector<msg::SkillOffers> of_machine = offers.value()->all();
  if (options.actuator.empty()) {
    std::erase_if(of_machine,
                  [&](const auto& one) { return meant.value()->IsOfAnother(one.actuator); });
  }
  const auto skill = ChooseSkill(of_machine, options.name, options.actuator);
  if (!skill) return console.Fail(Failure{ExitCode::kNotDone, skill.error()});
  const auto parameters = SkillParameters(skill.value().offer, options.parameters);
  if (!parameters) return console.Fail(Failure{ExitCode::kNotDone, parameters.error()});
  if (const auto failure = meant.value()->Check(skill.value().actuator)) {
    return console.Fail(*failure);
  }
  SkillRun run(*link.value(), global, skill.value(), console);
  if (const auto begun = run.Begin(parameters.value()); !begun) return console.Fail(begun.error());
  const SkillEnd end = run.Wait();
  if (console.mode().json) console.Print(SkillEndJson(end));
  if (end.outcome != SkillOutcome::kCompleted) {
    console.PrintError(SkillEndText(end));
  } else if (!console.mode().json) {
    console.Print(SkillEndText(end));
  }
  return ExitCodeOf(end.outcome, run.interrupted());
}

}  // namespace

void AddSkillRun(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("run", "Run a skill, show its progress and wait for its end", RunSkill, &family);
  AddSkillName(grammar, app, options.name, "The skill").required();
  grammar
      .Offer(app.add_option("PARAMETERS", options.parameters,
                            "KEY=VALUE each: altitude=2, goal_pos=[1,2,0],\n"
                            "'text=two words'"),
             Names::kSkillKeys)
      ->type_name("");
  AddSkillActuator(grammar, app, options.actuator);
  app.footer(
      "\n--timeout SECONDS cancels the skill then; without it the skill's own limits hold. Ctrl-C\n"
      "cancels it and waits for its end; the second Ctrl-C returns at once." +
      app.get_footer());
}

}  // namespace musher::cli
