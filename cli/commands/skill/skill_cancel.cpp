// musher skill cancel NAME: cancels the runs of a skill, and waits for their end. A run with a goal
// is cancelled by its goal, one that goes on after a restart by the service of its actuator.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <list>

#include "musher/base/host.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/skill/skill_commands.hpp"
#include "musher/cli/commands/skill/skill_goal.hpp"
#include "musher/cli/commands/skill/skill_runs.hpp"
#include "musher/cli/machine/skill_request.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

using SkillClient = transport::ActionClient<msg::SkillExecution>;
using RunClient = transport::Client<msg::CancelSkill>;

constexpr Duration kCancelEnd = std::chrono::seconds(15);  // a skill may take 5 s to end in order

struct SkillCancelOptions {
  std::string name;
  std::string actuator;  // empty: every one that runs the skill
};

// A run that is cancelled.
struct Cancelled {
  SkillEnd end;
  bool known = false;                       // how it ended
  std::unique_ptr<SkillClient> client;      // of its goal
  std::unique_ptr<RunClient> run_client{};  // of a run without a goal
};

Result<> CancelGoalOf(Link& link, const GlobalOptions& global, const OfferedSkill& skill,
                      const transport::GoalId& id, Duration timeout, Cancelled& cancelled) {
  auto client = transport::MakeActionClient<msg::SkillExecution>(
      link.node(), transport::ResolveName(global.name_space, skill.action));
  if (!client) return client.error();
  cancelled.client = std::move(client).value();
  cancelled.client->Cancel(
      id, timeout, [&cancelled](const Result<msg::CancelGoal::Response>& reply) {
        if (!reply || reply.value().return_code != msg::CancelGoal::kErrorRejected) return;
        cancelled.end.outcome = SkillOutcome::kRunning;
        cancelled.end.message = cancelled.end.actuator + " refuses the cancellation";
        cancelled.known = true;
      });
  cancelled.client->GetOutcome(id, timeout, [&cancelled](const auto& outcome) {
    if (!outcome || cancelled.known) return;
    FillSkillEnd(outcome.value(), true, cancelled.end);
    cancelled.known = true;
  });
  return Ok();
}

SkillOutcome OutcomeOf(bool cancelled, const std::string& status) {
  if (cancelled) return SkillOutcome::kCancelled;
  if (status.empty()) return SkillOutcome::kRefused;
  return status == "completed" ? SkillOutcome::kCompleted : SkillOutcome::kFailed;
}

Result<> CancelRunOf(Link& link, const GlobalOptions& global, const OfferedSkill& skill,
                     Duration timeout, Cancelled& cancelled) {
  auto client = transport::MakeClient<msg::CancelSkill>(
      link.node(), transport::ResolveName(global.name_space, skill.actuator + "/cancel_skill"));
  if (!client) return client.error();
  cancelled.run_client = std::move(client).value();
  msg::CancelSkill::Request request;
  request.skill = skill.offer.skill;
  request.by = UserAtHost();
  cancelled.run_client->Call(request, timeout * 2, [&cancelled](const auto& reply) {
    if (!reply) return;
    const SkillReport report = ReadSkillReport(reply.value().message);
    cancelled.end.message = report.message;
    if (!report.status.empty()) cancelled.end.progress = report.progress;
    cancelled.end.outcome = OutcomeOf(reply.value().success, report.status);
    cancelled.known = true;
  });
  return Ok();
}

// Queries an actuator for the run of the skill, and cancels it.
AskedRun CancelOn(Link& link, const GlobalOptions& global, const OfferedSkill& skill,
                  Duration timeout, std::list<Cancelled>& all) {
  const auto answer = QuerySkill(link, global, skill.actuator, {skill.offer.skill, ""});
  if (const auto* failure = std::get_if<Failure>(&answer)) return *failure;
  const msg::SkillFeedback& feedback = std::get<msg::GetSkill::Response>(answer).feedback;
  if (!SkillRuns(feedback)) return false;
  Cancelled& one = all.emplace_back();
  one.end = {
      skill.offer.skill, skill.actuator, SkillOutcome::kTimeout, "its cancellation was requested",
      feedback.progress, std::nullopt,   feedback.goal_id};
  const auto id = ReadGoalId(feedback.goal_id);
  const auto sent = id ? CancelGoalOf(link, global, skill, *id, timeout, one)
                       : CancelRunOf(link, global, skill, timeout, one);
  if (!sent) return Failure{ExitCode::kUsage, sent.error()};
  return true;
}

ExitCode ReportCancelled(const std::list<Cancelled>& all, Console& console) {
  std::vector<SkillEnd> ends;
  ExitCode exit = ExitCode::kDone;
  for (const Cancelled& one : all) {
    ends.push_back(one.end);
    const bool good = one.end.outcome == SkillOutcome::kCancelled;
    if (!good) exit = one.known ? ExitCode::kNotDone : ExitCode::kNoAnswer;
    if (!good) {
      console.PrintError(SkillEndText(one.end));
    } else if (!console.mode().json) {
      console.Print(SkillEndText(one.end));
    }
  }
  if (console.mode().json) console.Print(SkillCancelJson(ends));
  return exit;
}

ExitCode CancelSkill(const SkillCancelOptions& options, const GlobalOptions& global,
                     Console& console) {
  const auto opened = Link::Open(global);
  if (!opened) return console.Fail(opened.error());
  Link& link = *opened.value();
  const Duration timeout = global.timeout.value_or(kCancelEnd);
  std::list<Cancelled> all;
  const AskedRuns asked = AskRunsOf(
      link, global, options.name, options.actuator,
      [&](const OfferedSkill& skill) { return CancelOn(link, global, skill, timeout, all); });
  if (!asked.any) return console.Fail(*asked.failure);
  link.RunUntil(
      [&all] {
        return std::all_of(all.begin(), all.end(), [](const auto& one) { return one.known; });
      },
      timeout);
  const ExitCode exit = ReportCancelled(all, console);
  if (asked.failure) console.PrintError(asked.failure->error.message);
  if (link.interrupted()) return ExitCode::kInterrupted;
  return asked.failure ? asked.failure->exit : exit;
}

}  // namespace

void AddSkillCancel(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("cancel", "Cancel a running skill and wait for its end", CancelSkill, &family);
  AddSkillName(grammar, app, options.name, "The skill, of every actuator that runs it").required();
  AddSkillActuator(grammar, app, options.actuator);
}

}  // namespace musher::cli
