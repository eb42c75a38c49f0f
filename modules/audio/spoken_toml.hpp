#pragma once
// Reads what the tables of phrases and cues share: the keys en, zh and recording.

#include <filesystem>

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/audio/phrases.hpp"

namespace musher::audio {

// The path of a recording is relative to `folder`. Reports errors to the reader, also when there
// is neither text nor recording.
Spoken ReadSpoken(config_toml::TableReader& reader, const std::filesystem::path& folder);

}  // namespace musher::audio
