#pragma once
// The extensions' tables of the config.

#include <optional>

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/wedding/extension/interview.hpp"
#include "musher/modules/wedding/extension/observing_idle.hpp"
#include "musher/modules/wedding/extension/search.hpp"

namespace musher::wedding {

// Each: nothing where it is not enabled.
std::optional<SearchRules> ReadSearch(config_toml::TableReader& table);
std::optional<InterviewRules> ReadInterview(config_toml::TableReader& table);
std::optional<ActionRules> ReadActions(config_toml::TableReader& table);

}  // namespace musher::wedding
