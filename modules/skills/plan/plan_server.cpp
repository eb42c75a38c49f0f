#include "musher/modules/skills/plan/plan_server.hpp"

#include <set>
#include <utility>

#include "musher/application/refusal.hpp"
#include "musher/base/words.hpp"
#include "musher/modules/skills/plan/plan_check.hpp"
#include "musher/transport/goal_id_text.hpp"

namespace musher::skills {
namespace {

constexpr Duration kTick = Milliseconds(50);
constexpr Duration kAnswerTime = std::chrono::seconds(3);  // of a server, to a goal
constexpr Duration kCancelTime = std::chrono::seconds(1);  // then the cancellation is repeated
// To make a client for a goal that the process before has left: of a minute, one a second.
constexpr int kMostAttempts = 60;

std::string LeftGoal(const std::string& robot) {
  return robot + ": a skill that a process before has left to it";
}

}  // namespace

PlanServer::~PlanServer() {
  if (!execution_) return;
  for (const auto& sent : execution_->sent) CancelGoal(sent.first);
}

void PlanServer::Open(transport::Endpoints& endpoints) {
  transport::ActionHandlers<msg::PlanExecution> handlers;
  handlers.start = [this](const Goal& goal) { Start(goal); };
  handlers.cancel = [this](const Goal& goal) {
    if (!execution_ || execution_->goal.id() != goal.id()) return;
    execution_->run.Cancel("by its client", true);
    Advance();
  };
  endpoints.ServeAction<msg::PlanExecution>(config_.action, std::move(handlers));
  CancelGoalsOfProcessBefore();
}

void PlanServer::CancelGoalsOfProcessBefore() {
  const auto left = saved_.Found();
  if (!left) {
    return log_(LogLevel::kWarning,
                "what a process before has left to its robots is not known; cancel what they still "
                "do by musher skill cancel: " +
                    left.error().message);
  }
  left_ = left.value();
  CancelLeftGoals();
  for (const auto& [id, robot] : left_) {
    log_(LogLevel::kWarning, LeftGoal(robot) + " is not cancelled yet: " + no_client_ +
                                 "; it is tried again each second");
  }
}

void PlanServer::CancelLeftGoals() {
  for (const auto& [id, robot] : SavedGoals::Goals(left_)) {
    if (const Result<> made = MakeClient(robot); !made) {
      no_client_ = made.error().message;
      continue;
    }
    log_(LogLevel::kWarning,
         LeftGoal(robot) + " is cancelled (goal " + transport::GoalIdText(id) + ")");
    left_.erase(id);
    CancelUntilReply(robot, id);
  }
  TryAgainLater();
}

void PlanServer::TryAgainLater() {
  const bool tries_clients = !left_.empty() && attempts_ < kMostAttempts;
  if (!tries_clients && !saved_.failed()) return try_again_.reset();
  if (!try_again_) try_again_ = node_.loop().Every(SavedGoals::kRetry, [this] { TryAgain(); });
}

void PlanServer::TryAgain() {
  if (!left_.empty() && attempts_ < kMostAttempts) {
    ++attempts_;
    CancelLeftGoals();
    if (attempts_ == kMostAttempts) LogGivenUp();
  }
  SaveGoals();
}

void PlanServer::LogGivenUp() const {
  for (const auto& [id, robot] : left_) {
    log_(LogLevel::kWarning, LeftGoal(robot) + " is not cancelled: " + no_client_ +
                                 "; it is tried again with each plan and after `musher restart " +
                                 actuator_ +
                                 "`; `musher skill cancel` cancels what the robot does");
  }
}

// Those that may still run: of the present step, those whose cancellation has no reply, and those
// that cannot be cancelled yet.
void PlanServer::SaveGoals() {
  SavedGoals::Goals goals = cancelling_;
  goals.insert(left_.begin(), left_.end());
  if (execution_) {
    for (const auto& [robot, id] : execution_->sent) {
      goals[id] = execution_->run.present().robots[robot].robot_id;
    }
  }
  const bool had_failed = saved_.failed();
  const Result<> saved = saved_.Save(goals, node_.loop().Now());
  if (!saved) log_(LogLevel::kWarning, saved.error().message);
  if (had_failed && !saved_.failed() && !goals.empty()) {
    log_(LogLevel::kInfo, "the goals of the plan are saved");
  }
  TryAgainLater();
}

void PlanServer::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (permitted) return;
  not_permitted_ = why;
  if (!execution_) return;
  execution_->run.Cancel(why, false);
  Advance();
}

Result<> PlanServer::CheckNotLate() {
  const auto could_not_run = breaks_.Recent();
  if (!could_not_run) return Ok();
  return Refused<ApplicationRefusal::kMayBeLate>(actuator_, ToMilliseconds(*could_not_run) / 1000);
}

// Before anything else that follows a break: the end of a skill begins the next step.
void PlanServer::CancelAfterBreak() {
  const auto could_not_run = breaks_.Take();
  if (!execution_ || !could_not_run || *could_not_run <= BreakWatch::kLong) return;
  execution_->run.Cancel(actuator_ + " could not run for " +
                             std::to_string(ToMilliseconds(*could_not_run) / 1000) + " s",
                         false);
}

Result<> PlanServer::Admit(const msg::SkillPlan& plan) {
  if (!permitted_) return Error{kCodeStateInvalid, "no plans are executed: " + not_permitted_};
  if (Result<> timely = CheckNotLate(); !timely) return timely;
  if (execution_) return Error{kCodeTargetBusy, "another plan is executed"};
  if (Result<> valid = CheckPlan(plan); !valid) return valid;
  std::set<std::string> robots;
  for (const msg::TimestepSkills& step : plan.steps) {
    for (const msg::RobotSkill& robot : step.robots) robots.insert(robot.robot_id);
  }
  for (const auto& [id, robot] : cancelling_) robots.insert(robot);
  std::erase_if(clients_, [&](const auto& client) { return !robots.contains(client.first); });
  for (const std::string& robot : robots) {
    if (Result<> made = MakeClient(robot); !made) return made;
  }
  return Ok();
}

Result<> PlanServer::MakeClient(const std::string& robot) {
  if (clients_.contains(robot)) return Ok();
  auto made = transport::MakeActionClient<msg::SkillExecution>(
      node_, transport::ResolveName(name_space_, robot + "/" + config_.robot_action));
  if (!made) return made.error();
  clients_[robot] = std::move(made).value();
  return Ok();
}

void PlanServer::Start(const Goal& goal) {
  Goal own = goal;
  const msg::SkillPlan& plan = goal.goal().plan;
  if (const Result<> admitted = Admit(plan); !admitted) {
    log_(LogLevel::kWarning, "plan refused: " + admitted.error().message);
    own.Abort({false, admitted.error().message});
    return;
  }
  if (!left_.empty()) CancelLeftGoals();
  CancelAfterBreak();  // none is under way: a break before this plan does not end it
  own.Execute();
  log_(LogLevel::kInfo, "plan of " + Counted(plan.steps.size(), "step") + " started");
  execution_ = std::make_shared<Execution>(
      Execution{own, PlanRun(plan, config_.rules, node_.loop().Now()), {}, {}});
  ticks_ = node_.loop().Every(kTick, [this] { Advance(); });
  Advance();
}

void PlanServer::Advance() {
  if (!execution_) return;
  CancelAfterBreak();
  const std::size_t step = execution_->run.step();
  const PlanActions actions =
      execution_->run.Advance(node_.loop().Now(), [this](const std::string& robot) {
        const auto client = clients_.find(robot);
        return client != clients_.end() && client->second->Ready();
      });
  if (execution_->run.step() != step) {
    execution_->sent.clear();
    execution_->cancelled.clear();
  }
  SendAll(actions.send);
  for (const std::size_t robot : actions.cancel) CancelGoal(robot);
  if (actions.feedback) execution_->goal.PublishFeedback(execution_->run.Feedback());
  if (actions.end) End(*actions.end);
  SaveGoals();
}

// Saved before they are sent: this process may be killed in between.
void PlanServer::SendAll(const std::vector<std::size_t>& robots) {
  if (robots.empty()) return;
  for (const std::size_t robot : robots) {
    const std::string& name = execution_->run.present().robots[robot].robot_id;
    execution_->sent[robot] = clients_.at(name)->NextGoalId();
  }
  SaveGoals();
  for (const std::size_t robot : robots) Send(robot);
}

void PlanServer::Send(std::size_t robot) {
  const msg::RobotSkill& asked = execution_->run.present().robots[robot];
  const auto id = clients_.at(asked.robot_id)->SendGoal({asked}, kAnswerTime, EventsOf(robot));
  execution_->sent[robot] = id;
  execution_->run.OnSent(robot, transport::GoalIdText(id));
}

transport::GoalEvents<msg::SkillExecution> PlanServer::EventsOf(std::size_t robot) {
  const std::weak_ptr<Execution> weak = execution_;
  const std::size_t step = execution_->run.step();
  const auto execution = [weak, step]() -> std::shared_ptr<Execution> {
    auto present = weak.lock();
    return present && present->run.step() == step ? present : nullptr;
  };
  transport::GoalEvents<msg::SkillExecution> events;
  // A goal that was cancelled before its server knew it.
  events.on_accepted = [this, execution, robot] {
    const auto present = execution();
    if (present && present->cancelled.contains(robot)) CancelGoal(robot);
  };
  events.on_feedback = [this, execution, robot](const auto& feedback) {
    const auto present = execution();
    if (!present) return;
    present->run.OnFeedback(robot, feedback.status);
    Advance();
  };
  events.on_end = [this, execution, robot](const auto& outcome) {
    const auto present = execution();
    if (!present) return;
    CancelAfterBreak();
    const bool success = outcome.end == transport::GoalEnd::kSucceeded && outcome.result.success;
    const std::string& message = outcome.reason.empty() ? outcome.result.message : outcome.reason;
    const auto sent = present->sent.extract(robot);
    // A robot that was out of reach, or hung, may go on with its skill.
    if (outcome.end == transport::GoalEnd::kLost && sent) {
      CancelUntilReply(present->run.present().robots[robot].robot_id, sent.mapped());
    }
    present->run.OnEnd(robot, success, message);
    Advance();
  };
  return events;
}

void PlanServer::CancelGoal(std::size_t robot) {
  execution_->cancelled.insert(robot);
  const auto sent = execution_->sent.find(robot);
  if (sent == execution_->sent.end()) return;
  CancelUntilReply(execution_->run.present().robots[robot].robot_id, sent->second);
}

// Without a limit: a robot that is out of reach for an hour may still run it. The reply of any
// server ends it, also of the robot's next process, which does not know the goal, and a plan sends
// nothing to a robot without a server: so these are at most the goals that ran when it was lost,
// each with one request a second, which is not sent while there is no server. A request that
// arrives late cancels this goal only.
void PlanServer::CancelUntilReply(const std::string& robot, const transport::GoalId& id) {
  cancelling_[id] = robot;
  clients_.at(robot)->Cancel(id, kCancelTime, [this, robot, id](const auto& reply) {
    if (!reply) return CancelUntilReply(robot, id);
    cancelling_.erase(id);
    SaveGoals();
  });
}

void PlanServer::End(const PlanEnd& end) {
  ticks_.reset();
  Goal goal = std::exchange(execution_, nullptr)->goal;
  const bool success = end.outcome == PlanOutcome::kSucceeded;
  log_(success ? LogLevel::kInfo : LogLevel::kWarning, "plan ended: " + end.message);
  const msg::PlanExecution::Result result{success, end.message};
  if (success) {
    goal.Succeed(result);
  } else if (end.outcome == PlanOutcome::kAborted || !goal.Canceled(result)) {
    goal.Abort(result);
  }
}

}  // namespace musher::skills
