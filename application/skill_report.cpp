#include "musher/application/skill_report.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "musher/behavior/fsm/graph.hpp"

namespace musher {
namespace {

static_assert(msg::SkillFeedback::kStatusProcessing ==
              static_cast<std::uint8_t>(skill::Status::kProcessing));
static_assert(msg::SkillFeedback::kStatusCancelled ==
              static_cast<std::uint8_t>(skill::Status::kCancelled));

std::string RunTimeText(Duration time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f s", ToSeconds(time));
  return text;
}

// "1.20 s PLANNING → MOVING: decided, the path is planned"
std::string ChangeText(const skill::Run& run, const skill::Change& change) {
  std::string text = RunTimeText(change.at) + " " + std::string(run.table().Name(change.from)) +
                     " → " + std::string(run.table().Name(change.to)) + ": " +
                     std::string(skill::Name(change.cause));
  return change.why.empty() ? text : text + ", " + change.why;
}

// What each skill takes in a request (skill::Manager::StartWithTexts()).
std::string TimeoutText(Duration limit) {
  const std::string otherwise =
      limit == skill::kNoLimit ? "none" : skill::ToText(skill::Value(ToSeconds(limit)));
  return "timeout: a number, default " + otherwise + " (s; a run that takes longer fails)";
}

}  // namespace

msg::SkillOffers OfferSkills(const std::string& actuator, const std::string& action,
                             const skill::Manager& manager) {
  msg::SkillOffers offers{actuator, action, {}};
  for (const std::string& name : manager.Names()) {
    const auto run = manager.Make(name);
    if (!run) continue;
    const skill::Table& table = run.value()->table();
    msg::SkillOffer offer{name, table.summary(), {}};
    for (const auto& parameter : table.parameters()) {
      offer.parameters.push_back(skill::ToText(parameter));
    }
    const bool own = std::ranges::any_of(
        table.parameters(), [](const auto& parameter) { return parameter.name == "timeout"; });
    if (!own) offer.parameters.push_back(TimeoutText(table.limits().run));
    offers.skills.push_back(std::move(offer));
  }
  return offers;
}

msg::SkillFeedback ReportRun(const std::string& actuator, const skill::Run& run) {
  const skill::Origin& origin = run.origin();
  const skill::Feedback& feedback = run.feedback();
  msg::SkillFeedback report;
  report.actuator = actuator;
  report.skill = run.name();
  report.goal_id = origin.goal_id;
  report.status = static_cast<std::uint8_t>(feedback.status);
  report.state = feedback.state;
  report.progress = static_cast<std::uint8_t>(feedback.progress);
  report.message = skill::MessageText(feedback);
  for (const skill::Values::Named& detail : feedback.details) {
    report.details.push_back({detail.name, skill::ToText(detail.value)});
  }
  if (run.pause_requested()) report.details.push_back({"paused", run.pause_why()});
  if (!origin.requested_by.empty()) {
    report.details.push_back({"requested_by", origin.requested_by});
  }
  return report;
}

msg::GetSkill::Response ReportSkill(const std::string& actuator, const skill::Manager& manager,
                                    bool ticking, const msg::GetSkill::Request& request) {
  msg::GetSkill::Response report;
  report.stepping = ticking;
  const skill::Run* run = manager.Find(request.skill);
  std::unique_ptr<skill::Run> idle;
  if (run == nullptr) {
    auto made = manager.Make(request.skill);
    if (!made) {
      report.error = made.error().message;
      return report;
    }
    idle = std::move(made).value();
    run = idle.get();
  }
  report.feedback = ReportRun(actuator, *run);
  if (idle) report.feedback.state = idle->Path();
  for (std::size_t i = 0; i < run->history().size(); ++i) {
    report.history.push_back(ChangeText(*run, run->history()[i]));
  }
  for (std::size_t i = 0; i < run->errors().size(); ++i) {
    const skill::Failure& failure = run->errors()[i];
    report.errors.push_back(RunTimeText(failure.at) + " " + failure.state + ": " + failure.what);
  }
  if (request.format == "dot") {
    report.graph = fsm::ToDot(run->chart(), run->Path());
  } else if (request.format == "mermaid") {
    report.graph = fsm::ToMermaid(run->chart(), run->Path());
  } else if (!request.format.empty()) {
    report.error = "unknown graph format; expected dot or mermaid";
  }
  return report;
}

}  // namespace musher
