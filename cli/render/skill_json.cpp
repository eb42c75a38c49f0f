// The JSON documents of `musher skill`.

#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/skill.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::cli {
namespace {

OrderedJson OfSkillEnd(const SkillEnd& end) {
  return {{"skill", end.skill},
          {"actuator", end.actuator},
          {"outcome", SkillOutcomeWord(end.outcome)},
          {"message", end.message},
          {"progress", end.progress},
          {"duration_s", end.duration_s ? OrderedJson(*end.duration_s) : OrderedJson()},
          {"goal_id", Known(end.goal_id)}};
}

const char* SkillStatusName(std::uint8_t status) {
  switch (status) {
    case msg::SkillFeedback::kStatusProcessing:
      return "processing";
    case msg::SkillFeedback::kStatusCompleted:
      return "completed";
    case msg::SkillFeedback::kStatusFailed:
      return "failed";
    case msg::SkillFeedback::kStatusCancelled:
      return "cancelled";
    default:
      return "unknown";
  }
}

}  // namespace

std::string SkillsJson(const std::vector<msg::SkillOffers>& all) {
  OrderedJson actuators = OrderedJson::object();
  for (const msg::SkillOffers& of : all) {
    OrderedJson skills = OrderedJson::array();
    for (const msg::SkillOffer& offer : of.skills) {
      OrderedJson parameters = OrderedJson::array();
      for (const std::string& declared : offer.parameters) {
        parameters.push_back({{"key", ParameterName(declared)}, {"declared", declared}});
      }
      skills.push_back(
          {{"skill", offer.skill}, {"summary", offer.summary}, {"parameters", parameters}});
    }
    actuators[of.actuator] = {{"action", of.action}, {"skills", skills}};
  }
  return JsonLine({{"actuators", actuators}});
}

std::string SkillEndJson(const SkillEnd& end) {
  return JsonLine(OfSkillEnd(end));
}

std::string SkillCancelJson(const std::vector<SkillEnd>& ends) {
  OrderedJson runs = OrderedJson::array();
  for (const SkillEnd& end : ends) runs.push_back(OfSkillEnd(end));
  return JsonLine({{"runs", runs}});
}

std::string SkillPausedJson(const std::vector<SkillPaused>& all) {
  OrderedJson runs = OrderedJson::array();
  for (const SkillPaused& one : all) {
    runs.push_back({{"skill", one.skill},
                    {"actuator", one.actuator},
                    {"done", one.done},
                    {"state", one.done ? OrderedJson(one.message) : OrderedJson()},
                    {"message", one.done ? OrderedJson() : OrderedJson(one.message)}});
  }
  return JsonLine({{"runs", runs}});
}

std::string SkillFeedbackJson(const msg::SkillFeedback& feedback, std::int64_t wall_ns) {
  OrderedJson details = OrderedJson::object();
  OrderedJson requested_by;
  for (const msg::SkillDetail& detail : feedback.details) {
    (detail.key == "requested_by" ? requested_by : details[detail.key]) = detail.value;
  }
  const std::chrono::duration<double> stamp = msg::FromStamp(feedback.header.stamp);
  return JsonLine({{"time", UtcText(wall_ns)},
                   {"stamp_s", stamp.count()},
                   {"actuator", feedback.actuator},
                   {"skill", feedback.skill},
                   {"goal_id", Known(feedback.goal_id)},
                   {"requested_by", requested_by},
                   {"status", SkillStatusName(feedback.status)},
                   {"state", Known(feedback.state)},
                   {"progress", feedback.progress},
                   {"message", feedback.message},
                   {"details", details}});
}

}  // namespace musher::cli
