#include "musher/behavior/skill/toml/read_value.hpp"

#include <algorithm>

namespace musher::skill {

std::optional<Value> ReadValue(const config_toml::Value& value) {
  if (const auto* flag = value.As<bool>()) return *flag;
  if (const auto* whole = value.As<std::int64_t>()) return *whole;
  if (const auto* number = value.As<double>()) return *number;
  if (const auto* text = value.As<std::string>()) return *text;
  const auto* array = value.As<config_toml::Array>();
  if (array == nullptr) return std::nullopt;
  Numbers numbers;
  for (const config_toml::Value& element : *array) {
    if (const auto* number = element.As<double>()) {
      numbers.push_back(*number);
    } else if (const auto* whole = element.As<std::int64_t>()) {
      numbers.push_back(static_cast<double>(*whole));
    } else {
      return std::nullopt;
    }
  }
  return numbers;
}

void ReadParameter(config_toml::Findings& findings, const config_toml::Member& member,
                   const Table& skill, const std::string& path, Values& parameters) {
  const auto& declared = skill.parameters();
  const auto known = std::ranges::find(declared, member.key, &Table::Parameter::name);
  if (known == declared.end()) {
    std::vector<std::string> names;
    names.reserve(declared.size());
    for (const Table::Parameter& parameter : declared) names.push_back(parameter.name);
    return UnknownName(findings, member.at, path, "parameter", member.key, names);
  }
  const auto read = ReadValue(member.value);
  const auto value = read ? std::optional(As(known->kind, *read)) : std::nullopt;
  if (value && value->ok()) {
    parameters.Set(member.key, value->value());
  } else {
    findings.Error(member.value.at,
                   path + "." + member.key + ": expected " + std::string(Name(known->kind)));
  }
}

void UnknownName(config_toml::Findings& findings, config_toml::Position at, const std::string& path,
                 const std::string& what, const std::string& name,
                 const std::vector<std::string>& known) {
  const std::vector<std::string_view> candidates(known.begin(), known.end());
  findings.Error(at, path + ": there is no " + what + " " + config_toml::Quote(name) +
                         findings.Guess(name, candidates));
}

}  // namespace musher::skill
