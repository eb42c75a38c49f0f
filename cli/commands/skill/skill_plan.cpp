// musher skill plan FILE: sends a plan for several robots to the plan dispatcher, shows its
// progress and waits for its end.

#include <CLI/CLI.hpp>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/plan_file.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/commands/skill/skill_goal.hpp"
#include "musher/cli/commands/skill/skill_progress.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/machine/goal_run.hpp"
#include "musher/cli/machine/meant_actuator.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/skill_plan.hpp"

namespace musher::cli {
namespace {

constexpr Duration kPlanCancelTime = std::chrono::seconds(15);  // a plan's own limit is 10 s
constexpr Duration kOffersTime = std::chrono::seconds(1);

struct SkillPlanOptions {
  std::string file;
};

class SkillPlanRun {
 public:
  SkillPlanRun(Link& link, const GlobalOptions& global, std::size_t steps, Console& console)
      : global_(global),
        console_(console),
        report_(steps),
        progress_(link.loop(), "plan", console),
        goal_(link, global, console, {"the plan", "the plan dispatcher", kPlanCancelTime},
              [this] { progress_.Clear(); }) {}

  GoalRun<msg::PlanExecution>& goal() { return goal_; }
  const PlanReport& report() const { return report_; }

  void Send(const msg::SkillPlan& plan) {
    goal_.Send({plan}, [this](const msg::PlanExecution::Feedback& feedback) { Show(feedback); });
  }

  PlanFinish Wait() {
    goal_.Wait();
    PlanFinish finish{SkillOutcome::kRunning, "", ToSeconds(progress_.elapsed()),
                      GoalIdText(goal_.id())};
    if (goal_.end()) {
      finish.outcome = OutcomeOf(*goal_.end());
      finish.message =
          goal_.end()->reason.empty() ? goal_.end()->result.message : goal_.end()->reason;
    } else {
      finish.message = "its robots continue; `musher skill cancel NAME` cancels the skill of one";
    }
    if (finish.outcome == SkillOutcome::kCompleted) report_.Complete();
    if (!goal_.timed_out() || finish.outcome == SkillOutcome::kCompleted) return finish;
    finish.outcome = SkillOutcome::kTimeout;
    finish.duration_s = ToSeconds(*global_.timeout);
    return finish;
  }

 private:
  SkillOutcome OutcomeOf(const transport::GoalOutcome<msg::PlanExecution>& of) const {
    if (const auto unanswered = UnansweredOutcome(of.end, goal_.accepted())) return *unanswered;
    if (of.end == transport::GoalEnd::kSucceeded) return SkillOutcome::kCompleted;
    if (of.end == transport::GoalEnd::kCanceled) return SkillOutcome::kCancelled;
    return report_.step() == 0 ? SkillOutcome::kRefused : SkillOutcome::kFailed;
  }

  void Show(const msg::PlanExecution::Feedback& feedback) {
    const std::vector<PlanMember> changed = report_.Take(feedback);
    if (console_.mode().json) return;
    for (const PlanMember& member : changed) {
      const bool ended = member.report.status != "processing" && !member.report.status.empty();
      if (console_.mode().terminal && !ended) continue;
      progress_.Clear();
      console_.Print(PlanMemberLine(member, report_.steps()));
    }
    if (console_.mode().terminal) progress_.Show(report_.Summary());
  }

  const GlobalOptions& global_;
  Console& console_;
  PlanReport report_;
  SkillProgress progress_;
  GoalRun<msg::PlanExecution> goal_;  // last: its callbacks use all above
};

ExitCode FailWith(const std::vector<Diagnostic>& errors, Console& console) {
  for (const Diagnostic& error : errors) console.Note(Printable(FormatDiagnostic(error)) + '\n');
  if (console.mode().json) console.Print(CheckJson(errors));
  return ExitCode::kUsage;
}

ExitCode RunPlan(const SkillPlanOptions& options, const GlobalOptions& global, Console& console) {
  const PlanFileReading reading = ReadPlanFile(options.file);
  if (!reading.plan) return FailWith(reading.diagnostics, console);
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  SkillPlanRun run(*link.value(), global, reading.plan->steps.size(), console);
  if (const auto opened = run.goal().Open("plan_execution"); !opened) {
    return console.Fail(opened.error());
  }
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return console.Fail(offers.error());
  const auto meant = MeantActuator::Begin(*link.value(), global);
  if (!meant) return console.Fail(meant.error());
  if (!run.goal().AwaitServer()) {
    if (link.value()->interrupted()) return ExitCode::kInterrupted;
    return console.Fail(link.value()->NotFound("plan dispatcher"));
  }
  const auto refused = meant.value()->CheckServers(
      [&run] { return run.goal().Servers(); },
      {"no plan dispatcher of machine ", ", has no running plan dispatcher",
       "several machines have a plan dispatcher"});
  if (refused) return console.Fail(*refused);
  offers.value()->AwaitAny(kOffersTime);
  const auto errors = CheckPlanFile(*reading.plan, offers.value()->all(), options.file);
  if (!errors.empty()) return FailWith(errors, console);
  run.Send(ToMessage(*reading.plan));
  const PlanFinish finish = run.Wait();
  if (console.mode().json) console.Print(PlanFinishJson(finish, run.report()));
  if (finish.outcome != SkillOutcome::kCompleted) {
    console.PrintError(PlanFinishText(finish));
  } else if (!console.mode().json) {
    console.Print(PlanFinishText(finish));
  }
  return ExitCodeOf(finish.outcome, run.goal().interrupted());
}

}  // namespace

void AddSkillPlan(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add("plan", "Run a plan of skills for several robots, step by step",
                                    RunPlan, &family);
  grammar.Offer(app.add_option("FILE", options.file, "The plan (TOML)"), Names::kConfigs)
      ->required()
      ->type_name("");
  app.footer(
      "\nA plan has a table for each step, in which each robot has a skill:\n"
      "  [[step]]\n"
      "  jetbot_0 = { skill = \"nav_2d\", goal_pos = [5.6, 1.5, 0] }\n"
      "  cf2x_0 = { skill = \"take_off\", altitude = 1.2 }\n"
      "--timeout SECONDS and Ctrl-C cancel the plan, as those of `skill run`.\n" +
      app.get_footer());
}

}  // namespace musher::cli
