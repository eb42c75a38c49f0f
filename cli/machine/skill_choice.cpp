#include "musher/cli/machine/skill_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <set>

#include "musher/base/suggest.hpp"

namespace musher::cli {
namespace {

// Moves " (15%)" from the end of the text into a number.
int TakeProgress(std::string& text) {
  const std::size_t begin = text.rfind(" (");
  if (begin == std::string::npos || !text.ends_with("%)")) return 0;
  int progress = 0;
  const char* const end = text.data() + text.size() - 2;
  const auto [stop, error] = std::from_chars(text.data() + begin + 2, end, progress);
  if (error != std::errc() || stop != end) return 0;
  text.erase(begin);
  return std::clamp(progress, 0, 100);
}

}  // namespace

Result<std::vector<OfferedSkill>> FindSkill(const std::vector<msg::SkillOffers>& offers,
                                            const std::string& name, const std::string& actuator) {
  std::vector<OfferedSkill> found;
  std::set<std::string> names;
  for (const msg::SkillOffers& of : offers) {
    if (!actuator.empty() && of.actuator != actuator) continue;
    for (const msg::SkillOffer& offer : of.skills) {
      names.insert(offer.skill);
      if (offer.skill == name) found.push_back({of.actuator, of.action, offer});
    }
  }
  if (!found.empty()) return found;
  return Error{kCodeParametersInvalid, (actuator.empty() ? "" : actuator + ": ") +
                                           NoSuch("skill", name, {names.begin(), names.end()})};
}

Result<OfferedSkill> ChooseSkill(const std::vector<msg::SkillOffers>& offers,
                                 const std::string& name, const std::string& actuator) {
  const auto found = FindSkill(offers, name, actuator);
  if (!found) return found.error();
  if (found.value().size() == 1) return found.value().front();
  std::vector<std::string> actuators;
  for (const OfferedSkill& one : found.value()) actuators.push_back(one.actuator);
  return Error{kCodeParametersInvalid,
               fmt::format("{} is offered by {}; choose one of them with --actuator NAME", name,
                           fmt::join(actuators, ", "))};
}

std::string ParameterName(std::string_view declared) {
  return std::string(declared.substr(0, declared.find(':')));
}

Result<std::vector<msg::SkillParameter>> SkillParameters(const msg::SkillOffer& offer,
                                                         const std::vector<std::string>& words) {
  std::vector<std::string> names;
  for (const std::string& declared : offer.parameters) names.push_back(ParameterName(declared));
  std::vector<msg::SkillParameter> parameters;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0) {
      return Error{kCodeParametersInvalid, "expected KEY=VALUE, found '" + word + "'"};
    }
    const std::string key = word.substr(0, equals);
    if (std::find(names.begin(), names.end(), key) == names.end()) {
      return Error{kCodeParametersInvalid,
                   offer.skill + ": " + NoSuch("parameter", key, names) +
                       (names.empty() ? "; the skill has no parameters" : "")};
    }
    const bool twice = std::any_of(parameters.begin(), parameters.end(),
                                   [&key](const auto& earlier) { return earlier.key == key; });
    if (twice) return Error{kCodeParametersInvalid, key + " is given twice"};
    parameters.push_back({key, word.substr(equals + 1)});
  }
  return parameters;
}

SkillReport ReadSkillReport(std::string_view text) {
  SkillReport report{"", std::string(text), 0};
  constexpr std::array<std::string_view, 4> kStatuses{"processing", "completed", "failed",
                                                      "cancelled"};
  for (const std::string_view status : kStatuses) {
    if (!text.starts_with(status) || !text.substr(status.size()).starts_with(": ")) continue;
    report.status = status;
    report.message.erase(0, status.size() + 2);
    report.progress = TakeProgress(report.message);
  }
  return report;
}

}  // namespace musher::cli
