#include "musher/modules/camera/camera_config.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::camera {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Quote;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr std::int64_t kLargestPx = 8192;
constexpr double kFastestHz = 240;
constexpr double kWidestDeg = 175;                // a pinhole camera cannot be wider
constexpr std::string_view kTopic = "image_rgb";  // in messages
constexpr config_toml::TopicRule kRelative = {.relative = true};

class Reader {
 public:
  Reader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {}

  CamerasConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    ServiceConfig& service = config_.service;
    ReadRows(root, {row::Time("self_check_ms", config_.self_check_time),
                    row::Time("silence_ms", config_.silence), row::Time("retry_ms", config_.retry),
                    [this](TableReader& reader) { ReadStates(reader); },
                    row::Required("camera", "a table [camera.<name>] for each camera",
                                  [this](TableReader& reader) { ReadCameras(reader); }),
                    [this](TableReader& reader) { config_.skip = Names(reader, "skip"); },
                    [this](TableReader& reader) { config_.critical = Names(reader, "critical"); },
                    row::Sub("service", {[&](TableReader& reader) { ReadServiceCamera(reader); },
                                         row::Topic("topic", service.topic, kTopic, kRelative),
                                         row::File("folder", service.folder, folder_)})});
    for (const CameraConfig& camera : config_.cameras) {
      if (camera.topic != config_.service.topic) continue;
      findings_.Error(root.At("camera"), "camera." + camera.name +
                                             ".topic: " + Quote(camera.topic) +
                                             " is that of camera_service ([service] topic)");
    }
    if (config_.service.camera.empty() && !config_.cameras.empty()) {
      config_.service.camera = config_.cameras.front().name;
    }
    return std::move(config_);
  }

 private:
  void ReadStates(TableReader& root) {
    const auto states = root.Strings("on_in");
    if (!states) return;
    config_.on_in.clear();
    for (const Word& state : *states) config_.on_in.emplace_back(state.text);
  }

  void ReadCameras(TableReader& root) {
    const Table* tables = root.SubTable("camera");
    if (tables == nullptr) return;
    const config_toml::Position at = root.At("camera");
    TableReader all(*tables, at, "camera", findings_);
    if (tables->empty()) findings_.Error(at, "camera: expected a table [camera.<name>] for each");
    for (const config_toml::Member& member : *tables) {
      const Table* table = all.SubTable(member.key);
      if (table == nullptr) continue;
      if (!config_toml::IsName(member.key)) {
        all.Fault(
            member.at, member.key,
            "expected " + std::string(config_toml::kNameRule) + ", found " + Quote(member.key));
      }
      TableReader reader(*table, member.at, "camera." + member.key, findings_);
      config_.cameras.push_back(ReadCamera(reader, member.key));
      reader.RefuseOthers();
    }
  }

  CameraConfig ReadCamera(TableReader& reader, const std::string& name) {
    CameraConfig camera;
    camera.name = name;
    camera.frame_id = "camera_" + name;
    reader.Require("topic", "the topic of its pictures");
    if (const auto topic = reader.Topic("topic", kTopic, kRelative)) {
      camera.topic = topic->text;
      for (const CameraConfig& other : config_.cameras) {
        if (other.topic != topic->text) continue;
        reader.Fault(topic->at, "topic",
                     Quote(topic->text) + " is that of camera." + other.name + " already");
      }
    }
    if (const auto frame = reader.String("frame_id")) camera.frame_id = frame->text;
    reader.Require("source", "\"world\", \"video\", \"device\" or \"folder\"");
    const auto source = reader.Choice<SourceKind>("source", {{"world", SourceKind::kWorld},
                                                             {"video", SourceKind::kVideo},
                                                             {"device", SourceKind::kDevice},
                                                             {"folder", SourceKind::kFolder}});
    reader.Require("from", "a topic, a file, a device or a folder");
    const auto from = reader.String("from");
    if (source) camera.source = *source;
    if (source && from) camera.from = From(reader, *source, *from);
    ReadEnd(reader, camera);
    camera.on_demand = reader.Bool("on_demand").value_or(false);
    for (const Row& read : FormatRows(camera)) read(reader);
    return camera;
  }

  std::string From(TableReader& reader, SourceKind source, const Word& from) {
    if (source == SourceKind::kWorld) {
      reader.Topic("from", kTopic, kRelative);
      return from.text;
    }
    if (from.text.empty()) reader.Fault(from.at, "from", "expected a path, found nothing");
    const bool number =
        !from.text.empty() && std::all_of(from.text.begin(), from.text.end(),
                                          [](char c) { return c >= '0' && c <= '9'; });
    if (source == SourceKind::kDevice && number) return from.text;
    return config_toml::Absolute(folder_, from.text);
  }

  static void ReadEnd(TableReader& reader, CameraConfig& camera) {
    if (const auto loops = reader.Choice<bool>("at_end", {{"loop", true}, {"stop", false}})) {
      camera.loops = *loops;
      if (camera.source == SourceKind::kWorld || camera.source == SourceKind::kDevice) {
        reader.Warn(reader.At("at_end"), "at_end",
                    "has no effect: only a source \"video\" or \"folder\" ends");
      }
    }
  }

  static Rows FormatRows(CameraConfig& camera) {
    Format& format = camera.format;
    const auto both = [&](TableReader& reader) {
      if ((format.width_px == 0) == (format.height_px == 0)) return;
      const std::string_view given = format.width_px != 0 ? "width_px" : "height_px";
      reader.Fault(reader.At(given), given, "expected both width_px and height_px, or none");
    };
    return {
        row::Integer("width_px", format.width_px, 1, kLargestPx, "pixels"),
        row::Integer("height_px", format.height_px, 1, kLargestPx, "pixels"),
        both,
        row::Choice("encoding", format.encoding,
                    {{"bgr8", "bgr8"}, {"rgb8", "rgb8"}, {"mono8", "mono8"}}),
        row::Number("rate_hz", camera.rate_hz, 0.01, kFastestHz),
        row::Number("hfov_deg", camera.hfov_deg, 1, kWidestDeg),
    };
  }

  void ReadServiceCamera(TableReader& reader) {
    const auto name = reader.String("camera");
    if (!name) return;
    config_.service.camera = name->text;
    CheckName(reader, "camera", *name);
  }

  void CheckName(TableReader& reader, std::string_view key, const Word& name) {
    std::vector<std::string_view> known;
    for (const CameraConfig& camera : config_.cameras) known.emplace_back(camera.name);
    if (std::find(known.begin(), known.end(), name.text) != known.end()) return;
    reader.Fault(name.at, key,
                 "expected one of " + config_toml::Listing(known) + ", found " + Quote(name.text) +
                     findings_.Guess(name.text, known));
  }

  std::vector<std::string> Names(TableReader& root, std::string_view key) {
    std::vector<std::string> names;
    const auto words = root.Strings(key, {.may_be_empty = true});
    if (!words) return names;
    for (const Word& word : *words) {
      names.push_back(word.text);
      CheckName(root, key, word);
      const auto& skip = config_.skip;
      if (key == "critical" && std::find(skip.begin(), skip.end(), word.text) != skip.end()) {
        root.Fault(word.at, key, "a camera that is skipped cannot be critical");
      }
    }
    return names;
  }

  const std::filesystem::path folder_;
  Findings& findings_;
  CamerasConfig config_;
};

}  // namespace

Parsed<CamerasConfig> ReadCamerasText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<CamerasConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Reader(path, findings).Read(root); });
}

Parsed<CamerasConfig> ReadCamerasFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadCamerasText);
}

}  // namespace musher::camera
