#include "musher/modules/wedding/show_config.hpp"

#include <filesystem>
#include <numbers>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/wedding/extension/extension_toml.hpp"

namespace musher::wedding {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

constexpr double kRadPerDeg = std::numbers::pi / 180;

void Take(TableReader& table, const char* key, Duration& time, std::int64_t least_ms = 1) {
  time = table.Time(key, least_ms).value_or(time);
}

void Take(TableReader& table, const char* key, double& number, double least, double most) {
  number = table.Number(key, least, most).value_or(number);
}

// The file has degrees.
void TakeAngle(TableReader& table, const char* key, double& angle_rad, double least, double most) {
  if (const auto angle_deg = table.Number(key, least, most)) angle_rad = *angle_deg * kRadPerDeg;
}

class Reader {
 public:
  Reader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {}

  WeddingConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    Take(root, "rate_hz", config_.rate_hz, 1, 1000);
    Take(root, "state_rate_hz", config_.state_rate_hz, 0.1, 100);
    config_.autostart = root.Bool("autostart").value_or(false);
    config_.second_generation = root.Bool("second_generation").value_or(false);
    if (const Table* tracking = root.SubTable("tracking")) {
      gives_lost_ = TableReader(*tracking, {}, "", findings_).Has("lost_ms");
    }
    In(root, "check", [&](TableReader& check) { ReadCheck(check); });
    In(root, "perception", [&](TableReader& perception) { ReadPerception(perception); });
    In(root, "gaze", [&](TableReader& gaze) { ReadGaze(gaze); });
    ReadStates(root);
    In(root, "search", [&](TableReader& search) { config_.show.search = ReadSearch(search); });
    In(root, "interview", [&](TableReader& interview) { ReadInterviewOf(interview); });
    In(root, "actions", [&](TableReader& actions) {
      config_.show.actions = ReadActions(actions);
      if (config_.show.actions && !config_.show.search) {
        actions.Fault(actions.At("enabled"), "enabled",
                      "expected [search] enabled = true, too: an action's IDLE leads to SEARCH");
      }
    });
    In(root, "record", [&](TableReader& record) {
      if (const auto file = record.String("file"); file && !file->text.empty()) {
        config_.record = config_toml::Absolute(folder_, file->text);
      }
    });
    root.RefuseOthers();
    return std::move(config_);
  }

 private:
  // `read` gets the table `key`, if present.
  template <class ReadTable>
  void In(TableReader& root, const char* key, ReadTable&& read) {
    const Table* table = root.SubTable(key);
    if (table == nullptr) return;
    TableReader reader(*table, root.At(key), key, findings_);
    read(reader);
    reader.RefuseOthers();
  }

  void ReadInterviewOf(TableReader& interview) {
    config_.show.interview = ReadInterview(interview);
    const bool video = config_.show.interview && config_.show.interview->video;
    if (video && config_.camera_service.empty()) {
      interview.Fault(interview.At("video"), "video",
                      "expected photo.service to name the camera that records it, found \"\"");
    }
  }

  void ReadCheck(TableReader& check) {
    const auto need = [&check](const char* key, Need& taken) {
      taken = check
                  .Choice<Need>(key, {{"required", Need::kRequired},
                                      {"optional", Need::kOptional},
                                      {"none", Need::kNone}})
                  .value_or(taken);
    };
    Take(check, "time_ms", config_.self_check_time);
    need("camera", config_.camera);
    need("audio", config_.audio);
    need("motion", config_.motion);
    need("ready", config_.ready);
    if (config_.ready != Need::kNone && !config_.second_generation) {
      check.Fault(check.At("ready"), "ready",
                  "expected second_generation = true, too: the topic belongs to it");
    }
  }

  void ReadPerception(TableReader& perception) {
    PerceptionRules& rules = config_.show.perception;
    Take(perception, "age_ms", rules.age);
    if (rules.age > config_.show.tracking.lost && !gives_lost_) {
      perception.Fault(perception.At("age_ms"), "age_ms",
                       "expected at most tracking.lost_ms: a face that still counts is not lost");
    }
    Take(perception, "blind_ms", rules.blind, 0);
    Take(perception, "gesture_confidence", rules.gesture_confidence, 0, 1);
    Take(perception, "gesture_threshold", config_.show.tracking.gesture_threshold, 0, 1);
  }

  void ReadGaze(TableReader& gaze) {
    GazeRules& rules = config_.show.gaze;
    Take(gaze, "follow", rules.follow, 0.001, 0.999);
    rules.camera = gaze.Choice<Mount>("camera", {{"body", Mount::kBody}, {"head", Mount::kHead}})
                       .value_or(rules.camera);
    TakeAngle(gaze, "hfov_deg", rules.hfov_rad, 1, 170);
    Take(gaze, "height_to_width", rules.height_to_width, 0.1, 10);
    TakeAngle(gaze, "yaw_limit_deg", rules.yaw_limit_rad, 1, 360);
    TakeAngle(gaze, "pitch_limit_deg", rules.pitch_limit_rad, 0, 180);
    Take(gaze, "pitch_speed_rad_s", rules.pitch_speed_rad_s, 0.01, 100);
    Take(gaze, "joints_age_ms", rules.joints_age);
  }

  void ReadService(TableReader& photo) {
    const auto service = photo.String("service");
    if (!service) return;
    config_.camera_service = service->text;
    if (service->text.empty() || config_toml::IsTopic(service->text)) return;
    photo.Fault(service->at, "service",
                "expected the name of a service, as in \"camera_service\", or \"\", found " +
                    config_toml::Quote(service->text));
  }

  void ReadStates(TableReader& root) {
    ShowConfig& show = config_.show;
    In(root, "idle", [&](TableReader& idle) {
      Take(idle, "confirm_ms", show.idle.confirm, 0);
      Take(idle, "sway", show.idle.sway, 0, 0.5);
      Take(idle, "sway_period_ms", show.idle.sway_period);
    });
    In(root, "tracking", [&](TableReader& tracking) {
      Take(tracking, "lost_ms", show.tracking.lost);
      if (show.tracking.lost < show.perception.age && tracking.Has("lost_ms")) {
        tracking.Fault(tracking.At("lost_ms"), "lost_ms",
                       "expected at least perception.age_ms: a face that still counts is not lost");
      }
    });
    In(root, "photo", [&](TableReader& photo) {
      Take(photo, "confirm_ms", show.photo.confirm);
      Take(photo, "pose_ms", show.photo.pose);
      Take(photo, "countdown_ms", show.photo.countdown);
      Take(photo, "shutter_ms", show.photo.shutter);
      ReadService(photo);
      Take(photo, "timeout_ms", config_.photo_timeout);
    });
    In(root, "farewell",
       [&](TableReader& farewell) { Take(farewell, "time_ms", show.farewell.time); });
    In(root, "safe_stop", [&](TableReader& stop) { Take(stop, "clear_ms", show.safe_stop.clear); });
  }

  const std::filesystem::path folder_;
  Findings& findings_;
  WeddingConfig config_;
  bool gives_lost_ = false;  // the file has tracking.lost_ms, which is checked there
};

}  // namespace

WeddingReading ReadWeddingText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<WeddingReading>(
      text, path,
      [&](const Table& root, Findings& findings) { return Reader(path, findings).Read(root); });
}

WeddingReading ReadWeddingFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadWeddingText);
}

}  // namespace musher::wedding
