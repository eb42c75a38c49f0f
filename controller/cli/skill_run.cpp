// musher skill run NAME KEY=VALUE...: requests a run of a skill, shows its progress and waits for
// its end.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/render/skill.hpp"
#include "musher/controller/cli/skill_commands.hpp"
#include "musher/controller/cli/skill_goal.hpp"
#include "musher/controller/cli/skill_offers.hpp"
#include "musher/controller/cli/skill_progress.hpp"

namespace musher::cli {
namespace {

using SkillGoalOutcome = transport::GoalOutcome<msg::SkillExecution>;

constexpr Duration kStartTime = std::chrono::seconds(5);    // for the reply to the request
constexpr Duration kCancelTime = std::chrono::seconds(10);  // for the end after a timeout
constexpr Duration kLostAfter = std::chrono::seconds(3);

struct SkillRunOptions {
  std::string name;
  std::vector<std::string> parameters;  // "altitude=2"
  std::string actuator;                 // empty: the only one that offers the skill
};

// "cancelled after 3.2 s", "failed after 3.2 s: the battery is empty"
std::string EndAfterTimeout(const SkillEnd& end) {
  const std::string text =
      fmt::format("{} after {:.1f} s", SkillOutcomeName(end.outcome), end.duration_s.value_or(0));
  const bool says_more = end.outcome != SkillOutcome::kCancelled && !end.message.empty();
  return says_more ? text + ": " + end.message : text;
}

class SkillRun {
 public:
  SkillRun(Link& link, const GlobalOptions& global, const OfferedSkill& skill, Console& console)
      : link_(link),
        global_(global),
        skill_(skill),
        console_(console),
        progress_(link.loop(), skill.offer.skill, console) {}

  Result<> Begin(const std::vector<msg::SkillParameter>& parameters) {
    auto client = transport::MakeActionClient<msg::SkillExecution>(
        link_.node(), transport::ResolveName(global_.name_space, skill_.action), {kLostAfter, {}});
    if (!client) return client.error();
    client_ = std::move(client).value();
    transport::GoalEvents<msg::SkillExecution> events;
    events.on_accepted = [this] {
      accepted_ = true;
      if (cancels_) RequestCancel();
    };
    events.on_feedback = [this](const msg::SkillExecution::Feedback& feedback) {
      report_ = ReadSkillReport(feedback.status);
      progress_.Show(report_);
    };
    events.on_end = [this](const SkillGoalOutcome& outcome) { end_ = outcome; };
    msg::SkillExecution::Goal goal;
    goal.skill_request.robot_id = skill_.actuator;
    goal.skill_request.skill_list.resize(1);
    goal.skill_request.skill_list[0].skill = skill_.offer.skill;
    goal.skill_request.skill_list[0].params = parameters;
    id_ = client_->SendGoal(goal, kStartTime, std::move(events));
    return Ok();
  }

  // Until the end of the goal; until Ctrl-C has come twice; or until a timeout is over, and the
  // time for the cancellation that follows it.
  SkillEnd Wait() {
    std::optional<Time> deadline;
    if (global_.timeout) deadline = link_.loop().Now() + *global_.timeout;
    while (!end_) {
      const Duration left =
          deadline ? *deadline - link_.loop().Now() : Duration(std::chrono::hours(24));
      link_.RunUntil([this] { return end_.has_value(); }, left);
      if (end_) break;
      const bool over = deadline && link_.loop().Now() >= *deadline;
      if (link_.TakeInterrupt()) {
        if (std::exchange(interrupted_, true)) break;
        Cancel("cancelling " + skill_.offer.skill + "; Ctrl-C again returns without waiting");
      } else if (over && std::exchange(timed_out_, true)) {
        break;
      } else if (over) {
        Cancel("");
        deadline = link_.loop().Now() + kCancelTime;
      }
    }
    progress_.Clear();
    return End();
  }

  ExitCode ExitOf(SkillOutcome outcome) const {
    switch (outcome) {
      case SkillOutcome::kCompleted:
        return ExitCode::kDone;
      case SkillOutcome::kCancelled:
        return interrupted_ ? ExitCode::kInterrupted : ExitCode::kNotDone;
      case SkillOutcome::kLost:
        return ExitCode::kUnknownEnd;
      case SkillOutcome::kNoAnswer:
      case SkillOutcome::kTimeout:
        return ExitCode::kNoAnswer;
      case SkillOutcome::kRunning:
        return ExitCode::kInterrupted;
      default:
        return ExitCode::kNotDone;
    }
  }

 private:
  void Cancel(const std::string& news) {
    progress_.Clear();
    if (!news.empty()) console_.PrintError(news);
    cancels_ = true;
    if (accepted_) RequestCancel();
  }
  void RequestCancel() {
    client_->Cancel(id_, kCancelTime, [this](const Result<msg::CancelGoal::Response>& reply) {
      const bool refused = reply && reply.value().return_code == msg::CancelGoal::kErrorRejected;
      if (reply && !refused) return;
      progress_.Clear();
      console_.PrintError(
          skill_.actuator +
          (refused ? " refuses the cancellation of " : " does not answer to the cancellation of ") +
          skill_.offer.skill);
    });
  }

  SkillEnd End() const {
    SkillEnd end{skill_.offer.skill,     skill_.actuator,
                 SkillOutcome::kRunning, "",
                 report_.progress,       std::chrono::duration<double>(progress_.elapsed()).count(),
                 GoalIdText(id_)};
    if (end_) {
      FillSkillEnd(*end_, accepted_, end);
    } else {
      end.message = "`musher skill cancel " + end.skill + "` cancels it";
    }
    if (!timed_out_ || end.outcome == SkillOutcome::kCompleted) return end;
    end.message = end_ ? EndAfterTimeout(end) : "it goes on, " + end.message;
    end.outcome = SkillOutcome::kTimeout;
    end.duration_s = std::chrono::duration<double>(*global_.timeout).count();
    return end;
  }

  Link& link_;
  const GlobalOptions& global_;
  const OfferedSkill& skill_;
  Console& console_;
  SkillProgress progress_;
  transport::GoalId id_{};
  SkillReport report_;
  bool accepted_ = false;
  bool cancels_ = false;
  bool interrupted_ = false;
  bool timed_out_ = false;
  std::optional<SkillGoalOutcome> end_;
  std::unique_ptr<transport::ActionClient<msg::SkillExecution>> client_;  // last: uses all above
};

ExitCode RunSkill(const SkillRunOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return console.Fail(offers.error());
  if (const auto failure = offers.value()->Await(options.actuator)) return console.Fail(*failure);
  const auto skill = ChooseSkill(offers.value()->all(), options.name, options.actuator);
  if (!skill) return console.Fail(Failure{ExitCode::kNotDone, skill.error()});
  const auto parameters = SkillParameters(skill.value().offer, options.parameters);
  if (!parameters) return console.Fail(Failure{ExitCode::kNotDone, parameters.error()});
  SkillRun run(*link.value(), global, skill.value(), console);
  if (const auto begun = run.Begin(parameters.value()); !begun) return console.Fail(begun.error());
  const SkillEnd end = run.Wait();
  if (console.mode().json) console.Print(SkillEndJson(end));
  if (end.outcome != SkillOutcome::kCompleted) {
    console.PrintError(SkillEndText(end));
  } else if (!console.mode().json) {
    console.Print(SkillEndText(end));
  }
  return run.ExitOf(end.outcome);
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
