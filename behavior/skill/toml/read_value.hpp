#pragma once
// Values of a TOML text as values of a skill.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/behavior/skill/table.hpp"

namespace musher::skill {

// Nothing for a table, a date, and an array of other values than numbers.
std::optional<Value> ReadValue(const config_toml::Value& value);

// Sets the parameter of this name. Reports one that the skill does not declare, with the nearest,
// and a value of another kind.
void ReadParameter(config_toml::Findings& findings, const config_toml::Member& member,
                   const Table& skill, const std::string& path, Values& parameters);

// "skill.walk.parameters: there is no parameter "sped"; did you mean "speed"?".
void UnknownName(config_toml::Findings& findings, config_toml::Position at, const std::string& path,
                 const std::string& what, const std::string& name,
                 const std::vector<std::string>& known);

}  // namespace musher::skill
