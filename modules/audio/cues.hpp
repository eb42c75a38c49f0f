#pragma once
// Sounds that an application requests by name: a topic carries the name of a cue, a file maps it
// to what is played. Plain values; cues_toml.cpp reads them.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/modules/audio/phrases.hpp"

namespace musher::audio {

struct Cue {
  Spoken spoken;
  std::optional<bool> interrupts = std::nullopt;  // none: as its topic is configured

  friend bool operator==(const Cue&, const Cue&) = default;
};
using Cues = std::map<std::string, Cue, std::less<>>;  // by id

// A topic on which cues are requested.
struct CueTopic {
  std::string topic;       // absolute with a '/' before it, else in the machine's namespace
  bool interrupts = true;  // interrupts what plays; else a cue waits for its turn
  Cues cues;

  friend bool operator==(const CueTopic&, const CueTopic&) = default;
};

struct CuesReading {
  std::optional<Cues> cues;             // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// Never throws; an unreadable file is a diagnostic, and so is a recording that cannot be read.
CuesReading ReadCuesFile(const std::string& path);
// The same for a text; `path` is what diagnostics and relative paths refer to.
CuesReading ReadCuesText(std::string_view text, const std::string& path);

}  // namespace musher::audio
