#pragma once
// A value of a TOML text as a value of a skill.

#include <optional>

#include "musher/base/toml/document.hpp"
#include "musher/behavior/skill/value.hpp"

namespace musher::skill {

// Nothing for a table, a date, and an array of other values than numbers.
std::optional<Value> ReadValue(const config_toml::Value& value);

}  // namespace musher::skill
