#include "musher/modules/skills/plan/plan_run.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace musher::skills {
namespace {

std::string Seconds(Duration time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", ToSeconds(time));
  return text;
}

}  // namespace

PlanRun::PlanRun(msg::SkillPlan plan, const PlanRules& rules, Time now)
    : plan_(std::move(plan)), rules_(rules) {
  BeginStep(now);
}

void PlanRun::BeginStep(Time now) {
  step_begun_ = now;
  running_ = false;
  members_.assign(present().robots.size(), Member{});
  changed_ = true;
}

std::string PlanRun::NameOf(std::size_t robot) const {
  const msg::RobotSkill& asked = present().robots[robot];
  return asked.robot_id + " " + asked.skill_list.front().skill;
}

bool PlanRun::AllEnded() const {
  return std::ranges::all_of(members_, [](const Member& m) { return !m.sent || m.ended; });
}

void PlanRun::Fail(const std::string& why) {
  if (ending_) return;
  why_cancelled_ = "with its plan, in which " + why;
  ending_ = PlanEnd{PlanOutcome::kAborted, "Execution failed in timestep " +
                                               std::to_string(present().timestep) + ". " + why};
}

void PlanRun::OnSent(std::size_t robot, std::string goal_id) {
  members_[robot].goal_id = std::move(goal_id);
}

void PlanRun::OnFeedback(std::size_t robot, std::string status) {
  Member& member = members_[robot];
  if (member.ended) return;
  changed_ = changed_ || member.status != status;
  member.status = std::move(status);
}

void PlanRun::OnEnd(std::size_t robot, bool success, std::string message) {
  Member& member = members_[robot];
  if (!member.sent || member.ended) return;
  member.ended = true;
  member.status = std::move(message);
  // For its server the client that has cancelled it is this dispatcher.
  const bool by_failure = member.cancelled && !success && !why_cancelled_.empty();
  if (by_failure) member.status = "cancelled: " + why_cancelled_;
  changed_ = true;
  if (!success) Fail(NameOf(robot) + ": " + member.status);
}

void PlanRun::Cancel(const std::string& why, bool by_client) {
  if (ending_) return;
  ending_ = PlanEnd{by_client ? PlanOutcome::kCanceled : PlanOutcome::kAborted,
                    "Cancelled in timestep " + std::to_string(present().timestep) + ": " + why};
}

PlanActions PlanRun::SendAll() {
  PlanActions actions;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    members_[i].sent = true;
    members_[i].status = "sent";
    actions.send.push_back(i);
  }
  running_ = true;
  changed_ = true;
  return actions;
}

PlanActions PlanRun::CancelRest(Time now) {
  PlanActions actions;
  if (!cancelling_since_) cancelling_since_ = now;
  if (AllEnded()) {
    actions.end = ending_;
    return actions;
  }
  const bool late = now - *cancelling_since_ >= rules_.cancel_limit;
  std::string open;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Member& member = members_[i];
    if (!member.sent || member.ended) continue;
    open += (open.empty() ? "" : ", ") + NameOf(i);
    if (!std::exchange(member.cancelled, true)) actions.cancel.push_back(i);
  }
  if (late) {
    actions.end = ending_;
    actions.end->message +=
        "; not ended " + Seconds(rules_.cancel_limit) + " after their cancellation: " + open;
  }
  return actions;
}

PlanActions PlanRun::Advance(Time now,
                             const std::function<bool(const std::string& robot)>& available) {
  PlanActions actions;
  if (!ending_ && running_ && AllEnded()) {
    if (step_ + 1 == plan_.steps.size()) {
      ending_ = PlanEnd{PlanOutcome::kSucceeded, "All timesteps completed."};
    } else {
      ++step_;
      BeginStep(now);
    }
  }
  if (!ending_ && !running_) {
    std::string missing;
    for (const msg::RobotSkill& robot : present().robots) {
      if (!available(robot.robot_id)) missing += (missing.empty() ? "" : ", ") + robot.robot_id;
    }
    if (missing.empty()) {
      actions = SendAll();
    } else if (now - step_begun_ >= rules_.server_wait) {
      Fail("no action server within " + Seconds(rules_.server_wait) + ": " + missing);
    }
  }
  if (ending_) actions = CancelRest(now);
  actions.feedback = std::exchange(changed_, false);
  return actions;
}

msg::PlanExecution::Feedback PlanRun::Feedback() const {
  msg::PlanExecution::Feedback feedback;
  feedback.current_timestep = present().timestep;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const msg::RobotSkill& asked = present().robots[i];
    feedback.skill_statuses.push_back(
        {asked.robot_id, asked.skill_list.front().skill, members_[i].goal_id, members_[i].status});
  }
  return feedback;
}

}  // namespace musher::skills
