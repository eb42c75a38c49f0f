#include "musher/cli/render/skill_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "musher/cli/console/console.hpp"
#include "musher/cli/console/json_line.hpp"

namespace musher::cli {

std::vector<PlanMember> PlanReport::Take(const msg::PlanExecution::Feedback& feedback) {
  std::vector<PlanMember> changed;
  step_ = feedback.current_timestep;
  for (const msg::PlanSkillFeedback& of : feedback.skill_statuses) {
    SkillReport report = ReadSkillReport(of.status);
    if (report.status.empty() && report.message.empty()) continue;  // not sent yet
    auto found = std::ranges::find_if(members_, [&](const PlanMember& member) {
      return member.step == step_ && member.robot == of.robot_id;
    });
    if (found == members_.end()) {
      members_.push_back({step_, of.robot_id, of.skill_name, of.skill_id, std::move(report)});
      changed.push_back(members_.back());
    } else if (found->report != report) {
      found->report = std::move(report);
      found->goal_id = of.skill_id;
      changed.push_back(*found);
    }
  }
  return changed;
}

void PlanReport::Complete() {
  for (PlanMember& member : members_) {
    if (member.report.status == "completed") continue;
    member.report.status = "completed";
    member.report.progress = 100;
  }
}

SkillReport PlanReport::Summary() const {
  SkillReport summary{"processing", "", 0};
  int total = 0;
  int count = 0;
  for (const PlanMember& member : members_) {
    if (member.step != step_) continue;
    total += member.report.progress;
    ++count;
    summary.message += fmt::format("{}{} {} {} %", summary.message.empty() ? "" : ", ",
                                   member.robot, member.skill, member.report.progress);
  }
  const double present = count == 0 ? 0 : static_cast<double>(total) / count;
  const double before = 100.0 * std::max(step_ - 1, 0);
  if (steps_ > 0) {
    summary.progress = static_cast<int>((before + present) / static_cast<double>(steps_));
  }
  return summary;
}

std::string PlanMemberLine(const PlanMember& member, std::size_t steps) {
  return fmt::format("step {} of {}  {}  {}  {}", member.step, steps, Printable(member.robot),
                     Printable(member.skill), SkillReportLine(member.report));
}

std::string PlanFinishText(const PlanFinish& finish) {
  const std::string what = SkillOutcomeText(finish.outcome, finish.duration_s);
  return "the plan " + what + (finish.message.empty() ? "" : ": " + Printable(finish.message));
}

std::string PlanFinishJson(const PlanFinish& finish, const PlanReport& report) {
  OrderedJson robots = OrderedJson::array();
  for (const PlanMember& member : report.members()) {
    robots.push_back({{"step", member.step},
                      {"robot", member.robot},
                      {"skill", member.skill},
                      {"status", member.report.status},
                      {"message", member.report.message},
                      {"progress", member.report.progress},
                      {"goal_id", Known(member.goal_id)}});
  }
  return JsonLine(
      {{"outcome", SkillOutcomeWord(finish.outcome)},
       {"message", finish.message},
       {"step", report.step()},
       {"steps", report.steps()},
       {"duration_s", finish.duration_s ? OrderedJson(*finish.duration_s) : OrderedJson()},
       {"goal_id", Known(finish.goal_id)},
       {"skills", robots}});
}

}  // namespace musher::cli
