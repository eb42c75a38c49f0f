#pragma once
// Reads what phrases and cues have in common: the keys en, zh and recording of their tables.

#include <filesystem>

#include "musher/lifecycle/toml/table_reader.hpp"
#include "musher/modules/audio/phrases.hpp"

namespace musher::audio {

// A recording is seen from `folder`. Faults, of which nothing at all to be heard is one, go to the
// reader.
Spoken ReadSpoken(config_toml::TableReader& reader, const std::filesystem::path& folder);

}  // namespace musher::audio
