#include "musher/cli/commands/skill/plan_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <variant>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/cli/machine/skill_choice.hpp"

namespace musher::cli {
namespace {

using config_toml::Findings;
using config_toml::TableReader;

// "[1, 2.5, \"a\"]"; nothing for a value that no parameter can have.
std::optional<std::string> ParameterText(const config_toml::Value& value, bool in_list) {
  if (const auto* is = value.As<bool>()) return *is ? "true" : "false";
  if (const auto* number = value.As<std::int64_t>()) return std::to_string(*number);
  if (const auto* number = value.As<double>()) return fmt::format("{}", *number);
  if (const auto* text = value.As<std::string>()) {
    return in_list ? config_toml::Quote(*text) : *text;
  }
  const auto* list = value.As<config_toml::Array>();
  if (list == nullptr) return std::nullopt;
  std::string text;
  for (const config_toml::Value& element : *list) {
    const auto inside = ParameterText(element, true);
    if (!inside) return std::nullopt;
    text += (text.empty() ? "" : ", ") + *inside;
  }
  return "[" + text + "]";
}

void ReadMember(const config_toml::Member& member, const std::string& step, Findings& findings,
                std::vector<PlanFile::Member>& members) {
  const std::string path = step + "." + member.key;
  if (!config_toml::IsName(member.key)) {
    findings.Error(member.at, step + ": " + config_toml::Quote(member.key) +
                                  " is not the name of a robot; expected " +
                                  std::string(config_toml::kNameRule));
    return;
  }
  const auto* content = member.value.As<config_toml::Table>();
  if (content == nullptr) {
    findings.Error(
        member.value.at,
        path + ": expected a table, such as { skill = \"nav_2d\", goal_pos = [1, 2, 0] }");
    return;
  }
  TableReader table(*content, member.at, path, findings);
  table.Require("skill", "the name of a skill");
  const auto skill = table.String("skill");
  PlanFile::Member read{member.key, skill ? skill->text : "", skill ? skill->at : member.at, {}};
  for (const config_toml::Member& parameter : *content) {
    if (parameter.key == "skill") continue;
    if (const auto text = ParameterText(parameter.value, false)) {
      read.parameters.push_back({parameter.key, *text, parameter.at});
    } else {
      findings.Error(parameter.value.at, path + "." + parameter.key +
                                             ": expected a text, a number, true, false or a list");
    }
  }
  members.push_back(std::move(read));
}

PlanFile ReadSteps(const config_toml::Table& root, Findings& findings) {
  PlanFile plan;
  TableReader reader(root, {1, 1}, "", findings);
  reader.Require("step", "[[step]], once for each step of the plan");
  for (const config_toml::Value* step : reader.Tables("step")) {
    const std::string path = fmt::format("step {}", plan.steps.size() + 1);
    const auto& members = *step->As<config_toml::Table>();
    if (members.empty()) findings.Error(step->at, path + ": has no robots");
    plan.steps.emplace_back();
    for (const auto& member : members) ReadMember(member, path, findings, plan.steps.back());
  }
  reader.RefuseOthers();
  return plan;
}

const msg::SkillOffers* OfferOf(const std::string& robot,
                                const std::vector<msg::SkillOffers>& offers) {
  const std::string action = "/" + robot + "/skill_execution";
  const auto found = std::ranges::find_if(
      offers, [&](const msg::SkillOffers& offer) { return offer.action.ends_with(action); });
  return found == offers.end() ? nullptr : &*found;
}

void CheckMember(const PlanFile::Member& member, const msg::SkillOffers& of,
                 const std::function<void(const config_toml::Position&, std::string)>& add) {
  std::vector<std::string> skills;
  for (const msg::SkillOffer& offer : of.skills) skills.push_back(offer.skill);
  const auto offer = std::ranges::find(of.skills, member.skill, &msg::SkillOffer::skill);
  if (offer == of.skills.end()) {
    return add(member.at, member.robot + ": " + NoSuch("skill", member.skill, skills));
  }
  const std::string here = member.robot + " " + member.skill + ": ";
  std::vector<std::string> keys;
  for (const std::string& declared : offer->parameters) {
    keys.push_back(ParameterName(declared));
    const bool given =
        std::ranges::count(member.parameters, keys.back(), &PlanFile::Parameter::key) > 0;
    const bool required = declared.find(", required") != std::string::npos;
    if (required && !given) add(member.at, here + "the parameter " + declared + " is missing");
  }
  for (const PlanFile::Parameter& parameter : member.parameters) {
    if (std::ranges::count(keys, parameter.key) > 0) continue;
    add(parameter.at, here + NoSuch("parameter", parameter.key, keys));
  }
}

}  // namespace

PlanFileReading ReadPlanText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<PlanFileReading>(text, path, ReadSteps);
}

PlanFileReading ReadPlanFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadPlanText);
}

std::vector<Diagnostic> CheckPlanFile(const PlanFile& plan,
                                      const std::vector<msg::SkillOffers>& offers,
                                      const std::string& path) {
  std::vector<Diagnostic> found;
  const auto add = [&](const config_toml::Position& at, const std::string& message) {
    found.push_back({path, at.line, at.column, Severity::kError, message});
  };
  for (const auto& step : plan.steps) {
    for (const PlanFile::Member& member : step) {
      if (const auto* offer = OfferOf(member.robot, offers)) CheckMember(member, *offer, add);
    }
  }
  return found;
}

msg::SkillPlan ToMessage(const PlanFile& plan) {
  msg::SkillPlan message;
  for (const auto& step : plan.steps) {
    msg::TimestepSkills& skills = message.steps.emplace_back();
    skills.timestep = static_cast<std::int32_t>(message.steps.size());
    for (const PlanFile::Member& member : step) {
      msg::SkillInfo info;
      info.skill = member.skill;
      for (const auto& parameter : member.parameters) {
        info.params.push_back({parameter.key, parameter.value});
      }
      skills.robots.push_back({member.robot, {std::move(info)}});
    }
  }
  return message;
}

}  // namespace musher::cli
