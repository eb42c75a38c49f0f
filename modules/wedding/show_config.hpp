#pragma once
// The config of the wedding robot, a TOML file; README.md and config/wedding/wedding.toml explain
// its keys.

#include <optional>
#include <string>
#include <string_view>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/wedding/data/gaze.hpp"
#include "musher/modules/wedding/data/show_rules.hpp"
#include "musher/modules/wedding/extension/interview.hpp"
#include "musher/modules/wedding/extension/observing_idle.hpp"
#include "musher/modules/wedding/extension/search.hpp"
#include "musher/modules/wedding/perception.hpp"

namespace musher::wedding {

struct ShowConfig {
  PerceptionRules perception;
  GazeRules gaze;
  IdleRules idle;
  TrackingRules tracking;
  PhotoRules photo;
  FarewellRules farewell;
  SafeStopRules safe_stop;
  std::optional<SearchRules> search;        // nothing: no such state
  std::optional<InterviewRules> interview;  // the same
  std::optional<ActionRules> actions;  // nothing: the states move and speak without action packs

  friend bool operator==(const ShowConfig&, const ShowConfig&) = default;
};

// How a self-check treats another program.
enum class Need { kRequired, kOptional, kNone };

struct WeddingConfig {
  ShowConfig show;
  // Whether the show begins as soon as the robot is Active, also after a restart of its process;
  // else by the command START (application/begin.hpp).
  bool autostart = false;
  double rate_hz = 50;
  double state_rate_hz = 5;
  std::string camera_service = "camera_service";  // empty: no pictures are taken
  Duration photo_timeout = Milliseconds(5000);    // of the steady clock
  Duration self_check_time = Milliseconds(3000);
  Need camera = Need::kRequired;
  Need audio = Need::kRequired;
  Need motion = Need::kRequired;
  Need ready = Need::kNone;        // wedding/system/ready
  bool second_generation = false;  // its topics, beside those of the first
  std::string record;              // a file; empty: nothing is recorded

  friend bool operator==(const WeddingConfig&, const WeddingConfig&) = default;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<WeddingConfig> ReadWeddingFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<WeddingConfig> ReadWeddingText(std::string_view text, const std::string& path);

}  // namespace musher::wedding
