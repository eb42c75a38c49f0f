#include "musher/modules/wedding/show_config.hpp"

#include <filesystem>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/modules/wedding/extension/extension_toml.hpp"

namespace musher::wedding {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

Row NeedOf(std::string_view key, Need& need) {
  return row::Choice(
      key, need,
      {{"required", Need::kRequired}, {"optional", Need::kOptional}, {"none", Need::kNone}});
}

Rows CheckRows(WeddingConfig& config) {
  return {
      row::Time("time_ms", config.self_check_time),
      NeedOf("camera", config.camera),
      NeedOf("audio", config.audio),
      NeedOf("motion", config.motion),
      NeedOf("ready", config.ready),
      row::Check(
          "ready", [&] { return config.ready == Need::kNone || config.second_generation; },
          "expected second_generation = true, too: the topic belongs to it"),
  };
}

// `gives_lost`: the file has tracking.lost_ms, which is checked there.
Rows PerceptionRows(ShowConfig& show, const bool& gives_lost) {
  PerceptionRules& rules = show.perception;
  return {
      row::Time("age_ms", rules.age),
      row::Check(
          "age_ms", [&] { return rules.age <= show.tracking.lost || gives_lost; },
          "expected at most tracking.lost_ms: a face that still counts is not lost"),
      row::Time("blind_ms", rules.blind, 0),
      row::Number("gesture_confidence", rules.gesture_confidence, 0, 1),
      row::Number("gesture_threshold", show.tracking.gesture_threshold, 0, 1),
  };
}

Rows GazeRows(GazeRules& rules) {
  return {
      row::Number("follow", rules.follow, 0.001, 0.999),
      row::Choice("camera", rules.camera, {{"body", Mount::kBody}, {"head", Mount::kHead}}),
      row::Degrees("hfov_deg", rules.hfov_rad, 1, 170),
      row::Number("height_to_width", rules.height_to_width, 0.1, 10),
      row::Degrees("yaw_limit_deg", rules.yaw_limit_rad, 1, 360),
      row::Degrees("pitch_limit_deg", rules.pitch_limit_rad, 0, 180),
      row::Number("pitch_speed_rad_s", rules.pitch_speed_rad_s, 0.01, 100),
      row::Time("joints_age_ms", rules.joints_age),
  };
}

Rows TrackingRows(ShowConfig& show, const bool& gives_lost) {
  return {
      row::Time("lost_ms", show.tracking.lost),
      row::Check(
          "lost_ms", [&] { return show.tracking.lost >= show.perception.age || !gives_lost; },
          "expected at least perception.age_ms: a face that still counts is not lost"),
  };
}

Rows PhotoRows(WeddingConfig& config) {
  PhotoRules& photo = config.show.photo;
  return {
      row::Time("confirm_ms", photo.confirm),
      row::Time("pose_ms", photo.pose),
      row::Time("countdown_ms", photo.countdown),
      row::Time("shutter_ms", photo.shutter),
      row::Topic("service", config.camera_service, "camera_service",
                 {.of = "a service", .may_be_empty = true}),
      row::Time("timeout_ms", config.photo_timeout),
  };
}

Rows InterviewRows(WeddingConfig& config) {
  return {
      [&](TableReader& interview) { config.show.interview = ReadInterview(interview); },
      row::Check(
          "video",
          [&] {
            const bool video = config.show.interview && config.show.interview->video;
            return !video || !config.camera_service.empty();
          },
          "expected photo.service to name the camera that records it, found \"\""),
  };
}

Rows ActionRows(ShowConfig& show) {
  return {
      [&](TableReader& actions) { show.actions = ReadActions(actions); },
      row::Check(
          "enabled", [&] { return !show.actions || show.search; },
          "expected [search] enabled = true, too: an action's IDLE leads to SEARCH"),
  };
}

WeddingConfig Read(const Table& table, const std::string& path, Findings& findings) {
  WeddingConfig config;
  ShowConfig& show = config.show;
  TableReader root(table, {1, 1}, "", findings);
  bool gives_lost = false;
  const auto look_for_lost = [&](TableReader& reader) {
    if (const Table* tracking = reader.SubTable("tracking")) {
      gives_lost = TableReader(*tracking, {}, "", findings).Has("lost_ms");
    }
  };
  const auto record = [&, folder = config_toml::FolderOf(path)](TableReader& reader) {
    if (const auto file = reader.String("file"); file && !file->text.empty()) {
      config.record = config_toml::Absolute(folder, file->text);
    }
  };
  ReadRows(
      root,
      {row::Number("rate_hz", config.rate_hz, 1, 1000),
       row::Number("state_rate_hz", config.state_rate_hz, 0.1, 100),
       row::Bool("autostart", config.autostart),
       row::Bool("second_generation", config.second_generation), look_for_lost,
       row::Sub("check", CheckRows(config)),
       row::Sub("perception", PerceptionRows(show, gives_lost)),
       row::Sub("gaze", GazeRows(show.gaze)),
       row::Sub("idle", {row::Time("confirm_ms", show.idle.confirm, 0),
                         row::Number("sway", show.idle.sway, 0, 0.5),
                         row::Time("sway_period_ms", show.idle.sway_period)}),
       row::Sub("tracking", TrackingRows(show, gives_lost)), row::Sub("photo", PhotoRows(config)),
       row::Sub("farewell", {row::Time("time_ms", show.farewell.time)}),
       row::Sub("safe_stop", {row::Time("clear_ms", show.safe_stop.clear)}),
       row::Sub("search", {[&](TableReader& search) { show.search = ReadSearch(search); }}),
       row::Sub("interview", InterviewRows(config)), row::Sub("actions", ActionRows(show)),
       row::Sub("record", {record})});
  return config;
}

}  // namespace

Parsed<WeddingConfig> ReadWeddingText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<WeddingConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings); });
}

Parsed<WeddingConfig> ReadWeddingFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadWeddingText);
}

}  // namespace musher::wedding
