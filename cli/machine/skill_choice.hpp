#pragma once
// The skill that a command line means among those that the running actuators offer, and its
// parameters. Pure.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/skill.hpp"

namespace musher::cli {

// A skill of one actuator.
struct OfferedSkill {
  std::string actuator;
  std::string action;  // by which it is requested: "/robot_0/skill_execution"
  msg::SkillOffer offer;
};

// The skill `name` of each actuator that offers it; of `actuator` alone unless that is empty. Fails
// if there is none, with the nearest name.
Result<std::vector<OfferedSkill>> FindSkill(const std::vector<msg::SkillOffers>& offers,
                                            const std::string& name, const std::string& actuator);
// The only one of them. Fails if several actuators offer it, with their names.
Result<OfferedSkill> ChooseSkill(const std::vector<msg::SkillOffers>& offers,
                                 const std::string& name, const std::string& actuator);

// "altitude" of the declaration "altitude: a number, default 1 (m above the ground)".
std::string ParameterName(std::string_view declared);

// Words "KEY=VALUE" as parameters. Fails for an unknown key, with the nearest, for a key that
// occurs twice and for a word without '='.
Result<std::vector<msg::SkillParameter>> SkillParameters(const msg::SkillOffer& offer,
                                                         const std::vector<std::string>& words);

// What a skill reports: "processing: Planning the path (15%)".
struct SkillReport {
  std::string status;  // "processing", "completed", "failed", "cancelled"; empty: unknown
  std::string message;
  int progress = 0;  // in percent

  friend bool operator==(const SkillReport&, const SkillReport&) = default;
};
// Another text is a message without status.
SkillReport ReadSkillReport(std::string_view text);

}  // namespace musher::cli
